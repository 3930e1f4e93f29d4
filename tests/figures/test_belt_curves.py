"""Gallas' Fig. 6 and Fig. 1c under both protocols."""

import pytest

from sim.figures.style import LONG_DASH
from tests.figures.drawing import dashes, drawn, texts


def legend(axes) -> dict[str, object]:
    return {line.get_label(): dashes(line) for line in axes.get_lines() if "=" in line.get_label()}


def joined(axes, colour: str) -> tuple[list[float], list[float]]:
    """Return the data of the line of a colour."""
    (line,) = (
        line
        for line in axes.get_lines()
        if line.get_color() == colour and line.get_linestyle() != "None" and len(line.get_xdata())
    )
    return list(line.get_xdata()), list(line.get_ydata())


def test_fig_6_has_the_papers_dashes_and_the_velocities(belt_dataset):
    figure, _ = drawn("gallas_6", belt_dataset)
    (axes,) = figure.axes
    assert legend(axes) == {"f = 80 Hz": "-", "f = 20 Hz": LONG_DASH}
    for colour, frequency in (("#000000", 80), ("#0072b2", 20)):
        diameters, velocities = joined(axes, colour)
        assert diameters == [0, 0.5, 1.5]
        assert velocities == pytest.approx([1e-3 * frequency / (1 + d) for d in diameters])


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
        assert joined(axes, "#000000")[0] == [0, 10, 50]
    assert len(data.rows) == 12
    labels = [text.get_text() for text in figure.legends[0].get_texts()]
    assert sorted(labels) == ["f = 20 Hz", "f = 50 Hz"]


@pytest.mark.parametrize(("name", "points"), [("gallas_6", 6), ("protocols_1c", 12)])
def test_data_and_caption(name, points, belt_dataset):
    data, text = texts(name, belt_dataset)
    assert len(data) == points
    assert {"obstacle [⟨d⟩]" if name == "gallas_6" else "shear_damping [g]", "protocol"} < set(data)
    assert "interval of the mean over 3 replicates" in text
    assert "γ = 50g" in text
    assert "The paper: " in text
    assert ("Converged protocol (6 points)" in text) == (name == "protocols_1c")
