"""Papers' figures of velocities and measures against a parameter: curves, data and captions."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from matplotlib.collections import FillBetweenPolyCollection

from sim.figures.curves import MOST_BARS, quantities_by_axis
from sim.figures.style import LONG_DASH
from tests.figures.drawing import dashes, data_of_figure, drawn, picture, table, texts
from tests.figures.made_belt import transport
from tests.figures.made_chute import overlap


def legend(axes) -> dict[str, object]:
    return {line.get_label(): dashes(line) for line in axes.get_lines() if "=" in line.get_label()}


def curve(axes, colour: str, dash: object = "-") -> dict[float, float]:
    """Return the data of the line of a colour and a dash pattern."""
    (line,) = (
        line
        for line in axes.get_lines()
        if line.get_linestyle() != "None" and len(line.get_xdata()) > 2
        if line.get_color() == colour and dashes(line) == dash
    )
    return dict(zip(line.get_xdata(), line.get_ydata(), strict=True))


def test_protocols_stand_side_by_side_on_one_scale(belt_dataset):
    figure, data = drawn("protocols_1c", belt_dataset)
    left, right = figure.axes
    assert [axes.get_title() for axes in (left, right)] == [
        "published protocol",
        "converged protocol",
    ]
    assert left.get_ylim() == right.get_ylim()
    for axes in (left, right):
        assert legend(axes) == {"f = 50 Hz": "-", "f = 20 Hz": LONG_DASH}
        assert list(curve(axes, "#000000")) == [0, 10, 50]
    assert len(data.rows) == 12
    labels = [text.get_text() for text in figure.legends[0].get_texts()]
    assert sorted(labels) == ["f = 20 Hz", "f = 50 Hz", "may be steady (short run)"]
    assert figure.legends[0].get_title().get_text() == "frequency f"
    assert "Converged protocol (6 points)" in texts("protocols_1c", belt_dataset)[1]


def test_overlaps_are_a_line_and_a_dashed_one_per_stiffness(chute_dataset):
    figure, data = drawn("overlaps", chute_dataset)
    (axes,) = figure.axes
    assert axes.get_yscale() == "log"
    for dash, times in ((LONG_DASH, 1), ("-", 10)):
        found = curve(axes, "#000000", dash)
        made = [times * overlap({"depth": depth, "stiffness": 100}) for depth in found]
        assert list(found) == [1.24, 2.5, 5, 10, 20, 40]
        assert list(found.values()) == pytest.approx(made)
    assert set(legend(axes)) == {f"K1 = {stiffness} N/m" for stiffness in (100, 1000)}
    entries = [text.get_text() for text in figure.legends[0].get_texts()]
    assert {"99.9th percentile", "median", "the paper: 0.5 and 5 %"} < set(entries)
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
    relative = quantities_by_axis(data)["y"].value.to_numpy()
    assert relative == pytest.approx((speed / belt).to_numpy())
    heights = [y for line in axes.get_lines() if len(line.get_xdata()) for y in line.get_ydata()]
    assert set(relative) <= set(heights)
    named = [label for label in legend(axes) if "α" in label]
    assert set(named) == {"$A_z$/⟨d⟩ = 0.5, α = 45°", "$A_z$/⟨d⟩ = 1, α = 45°"}


@pytest.fixture(scope="module")
def layers(chute_dataset):
    return data_of_figure("shear_depth", chute_dataset)


def test_every_material_is_a_curve_over_the_depths(layers):
    axes = picture(layers).axes[0]
    assert set(legend(axes)) == {
        "e = 0.7, K1 = 100 N/m",
        "e = 0.85, K1 = 100 N/m",
        "e = 0.85, K1 = 1000 N/m",
    }
    curve = max(axes.get_lines(), key=lambda line: len(line.get_xdata()))
    assert list(curve.get_xdata()) == [1.24, 2.5, 5, 10, 20, 40]
    assert list(curve.get_ydata()) == pytest.approx([10 / depth for depth in curve.get_xdata()])


def test_a_crowded_line_has_a_band_and_lines_join_no_open_marker(belt_dataset):
    data = data_of_figure("gallas_6", belt_dataset)
    row = data.rows[data.rows["frequency"] == 80].iloc[[0]]
    number = MOST_BARS + 2
    many = pd.concat([row] * number, ignore_index=True)
    many = many.assign(obstacle=np.arange(number) / 10, velocity=0.1, half_width=0.01)
    many.loc[3, "regime"] = "accelerating"
    axes = picture(replace(data, rows=many)).axes[0]
    (band,) = (one for one in axes.collections if isinstance(one, FillBetweenPolyCollection))
    assert len(band.get_paths()) == 2, "interrupted where the line is"
    joined = curve(axes, "#000000")
    assert [x for x, y in joined.items() if np.isnan(y)] == [0.3]
    (bars,) = (part.get_segments() for each in axes.containers for part in each.lines[2])
    assert sum(np.isfinite(one).all() and one.size for one in bars) == 4, "of the open marker alone"
