"""Figures of measures: overlaps of spheres; the belt's onset, void, stiffness and density waves."""

import numpy as np
import pytest

from sim.figures.paper_curves import shown_quantities
from sim.figures.style import LONG_DASH
from tests.figures.drawing import dashes, drawn, table, texts
from tests.figures.made_belt import transport
from tests.figures.made_chute import overlap


def curve(axes, colour: str, dash: object = "-") -> dict[float, float]:
    """Return the data of the line of a colour and a dash pattern."""
    (line,) = (
        line
        for line in axes.get_lines()
        if line.get_linestyle() != "None" and len(line.get_xdata()) > 2
        if line.get_color() == colour and dashes(line) == dash
    )
    return dict(zip(line.get_xdata(), line.get_ydata(), strict=True))


def test_overlaps_are_a_line_and_a_dashed_one_per_stiffness(chute_dataset):
    figure, data = drawn("overlaps", chute_dataset)
    (axes,) = figure.axes
    assert axes.get_yscale() == "log"
    for dash, times in ((LONG_DASH, 1), ("-", 10)):
        found = curve(axes, "#000000", dash)
        made = [times * overlap({"depth": depth, "stiffness": 100}) for depth in found]
        assert list(found) == [1.24, 2.5, 5, 10, 20, 40]
        assert list(found.values()) == pytest.approx(made)
    labels = {line.get_label() for line in axes.get_lines() if "=" in line.get_label()}
    assert labels == {
        f"K1 = {stiffness} N/m, {what}"
        for stiffness in (100, 1000)
        for what in ("median", "one of a thousand")
    }
    heading = "half width of 95 % interval of the median overlap [σ]"
    columns = set(table(data))
    assert {"median overlap [σ]", heading, "overlap that one of a thousand exceeds [σ]"} < columns


def test_onset_is_drawn_against_the_acceleration_and_relative_to_the_belt(belt_dataset):
    figure, data = drawn("onset_acceleration", belt_dataset)
    (axes,) = figure.axes
    rows = data.rows
    assert set(rows["frequency"]) == {15, 20}, "80 Hz is far from the onset"
    vertical = rows["amplitude"] * rows["diameter"]
    assert rows["acceleration_ratio"].to_numpy() == pytest.approx(
        (2 * np.pi * rows["frequency"]) ** 2 * vertical / 10
    )
    speed = [transport(each) for each in rows.itertuples()]
    belt = 2 * np.pi * rows["frequency"] * vertical
    assert rows["velocity"].to_numpy() == pytest.approx(speed)
    relative = shown_quantities(data)[0].value.to_numpy()
    assert relative == pytest.approx((speed / belt).to_numpy())
    heights = [y for line in axes.get_lines() if len(line.get_xdata()) for y in line.get_ydata()]
    assert set(relative) <= set(heights)
    labels = {line.get_label() for line in axes.get_lines() if "=" in line.get_label()}
    assert labels == {"$A_z$ = 0.5 ⟨d⟩, α = 45°", "$A_z$ = 1 ⟨d⟩, α = 45°"}


def test_void_is_the_share_of_beads_near_the_belt(belt_dataset):
    figure, _ = drawn("belt_void", belt_dataset)
    for colour in ("#000000", "#0072b2"):
        found = curve(figure.axes[0], colour, "-" if colour == "#000000" else (0, (3, 1.5)))
        assert found == pytest.approx({15: 1 / 15, 20: 1 / 20, 80: 1 / 80})


def test_waves_of_the_first_cycles_stand_beside_the_later_ones(belt_dataset):
    figure, _ = drawn("density_waves", belt_dataset)
    early = curve(figure.axes[0], "#0072b2", LONG_DASH)
    late = curve(figure.axes[0], "#000000")
    assert early == pytest.approx({f: 2 * late[f] for f in late}, rel=0.15)


def test_stiffness_is_a_curve_per_frequency(belt_dataset):
    figure, _ = drawn("belt_stiffness", belt_dataset)
    assert list(curve(figure.axes[0], "#000000")) == [500, 1000, 2000]
    assert figure.axes[0].get_xscale() == "log"


@pytest.mark.parametrize(
    ("name", "heading"),
    [
        ("onset_acceleration", "velocity over the belt's along x [1]"),
        ("belt_void", "beads within the belt's reach [1]"),
        ("belt_stiffness", "mean velocity [m s-1]"),
        ("density_waves", "power in the averaging window [1]"),
    ],
)
def test_data_and_caption(name, heading, belt_dataset):
    data, text = texts(name, belt_dataset)
    assert heading in data
    assert data[heading].notna().all()
    assert "95 % interval" in text
    assert "The paper: " in text
