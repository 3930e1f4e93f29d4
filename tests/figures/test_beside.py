"""Foreign data in plots: drawn apart, and named in legend, caption and data."""

import numpy as np
import pytest
from matplotlib.lines import Line2D

from sim.base.errors import InputError
from sim.figures.caption import caption
from sim.figures.plot import _MARKERS
from sim.figures.regimes import MARKS
from sim.figures.style import COLOURS, MARKERS
from tests.figures.made_plots import drawn
from tests.figures.test_plot_texts import shown_texts

MEASURED = {"label": "_glass $d$", "points": [[0.3, 0.5], [0.45, 0.9]]}
LAW = {"label": "law", "points": [[0.3, 0.4], [0.6, 0.2], [0.6, 0.1]], "line": True}


def foreign_lines(axes, data_set: dict) -> list[Line2D]:
    """Return the artists of a foreign data set on some axes."""
    at = np.array(data_set["points"], float)
    return [line for line in axes.lines if np.array_equal(line.get_xydata(), at)]


OVER = {"x": "friction", "curves": "angle"}
MAP = {"kind": "map", "x": "friction", "y": "angle"}
HEIGHTS = {"kind": "profiles", "x": "packing", "curves": "friction", "panels": "angle"}
SLICES = {"kind": "profiles", "x": "granular_temperature", "y": "packing"}


@pytest.mark.parametrize(
    ("plot", "x", "y"),
    [
        (OVER, "friction", "mean velocity"),
        (MAP | {"colour": "velocity"}, "friction", "angle"),
        (HEIGHTS, "packing", "height"),
        (SLICES | {"curves": ["friction", "angle"]}, "granular", "packing"),
    ],
)
def test_data_beside_are_in_every_panel_the_legend_the_caption_and_the_data(plot, x, y):
    _, study_rows, _ = drawn(plot)
    figure, rows, data = drawn(plot | {"beside": [MEASURED, LAW]})
    panels = [axes for axes in figure.axes if axes.get_label() != "<colorbar>"]
    for axes in panels:
        (markers,), (line,) = foreign_lines(axes, MEASURED), foreign_lines(axes, LAW)
        assert markers.get_linestyle() == "None" and markers.get_marker() in _MARKERS
        assert line.get_marker() == "None" and line.get_linestyle() != "-"
        assert not {markers.get_color(), line.get_color()} & set(COLOURS)
        (left, right), (bottom, top) = axes.get_xlim(), axes.get_ylim()
        for one in (MEASURED, LAW):
            at = np.array(one["points"])
            assert np.all((left <= at[:, 0]) & (at[:, 0] <= right))
            assert np.all((bottom <= at[:, 1]) & (at[:, 1] <= top))
    assert {"_glass $d$", "law"} <= shown_texts(figure)
    text = caption(data, [])
    assert "not simulated here: _glass $d$ (markers); law (line)." in text
    assert len(rows) == len(study_rows) + 5 and "not of this study" not in study_rows
    beside = rows[rows["not of this study"].notna()]
    assert beside["not of this study"].tolist() == ["_glass $d$"] * 2 + ["law"] * 3
    assert beside["point"].isna().all() and rows["point"].notna().sum() == len(study_rows)
    foreign = beside.dropna(axis=1, how="all").drop(columns="not of this study")
    points = np.array([*MEASURED["points"], *LAW["points"]])
    assert foreign.filter(regex=f"^{x}").iloc[:, 0].tolist() == points[:, 0].tolist()
    assert foreign.filter(regex=f"^{y}").iloc[:, 0].tolist() == points[:, 1].tolist()
    assert foreign.shape[1] == 2


def test_a_label_that_a_curve_has_too_is_another_entry():
    same = MEASURED | {"label": "θ = 16°"}
    figure, _, _ = drawn(OVER | {"beside": [same]})
    named = [text.get_text() for text in figure.legends[0].texts]
    assert named == ["θ = 16°", "θ = 17°", "θ = 16°"]


def test_axes_hold_data_beyond_the_values_run():
    beyond = MEASURED | {"points": [[0.1, 1], [0.9, 0.5]]}
    figure, _, _ = drawn(OVER | {"beside": [beyond]})
    assert max(figure.axes[0].get_xticks()) >= 0.9
    figure, _, _ = drawn(MAP | {"log": ["x"], "beside": [beyond]})
    assert figure.axes[0].get_xscale() == "log"


def test_nothing_beside_looks_like_anything_of_a_study():
    assert not set(_MARKERS) & {*MARKERS, *(marker for marker, _, _ in MARKS.values())}


def test_columns_of_a_file_are_drawn_with_their_errors(tmp_path, monkeypatch):
    (tmp_path / "exp.csv").write_text("mu,V (mm/s),s (mm/s)\n0.35,650,40\n0.58,400,300\n")
    monkeypatch.chdir(tmp_path)
    beside = {"file": "exp.csv", "x": "mu", "y": "V", "yerr": "s"}
    figure, rows, data = drawn(OVER | {"beside": beside})
    assert data.spec.foreign == (("exp", ((0.35, 0.65, 0.04), (0.58, 0.4, 0.3)), False),)
    axes = figure.axes[0]
    (bars,) = axes.collections[-1:]
    np.testing.assert_allclose(bars.get_segments()[1], [[0.58, 0.1], [0.58, 0.7]])
    assert axes.get_ylim()[0] < 0.1
    assert "exp (markers, bars: its errors)" in caption(data, [])
    assert rows["error, not of this study"].dropna().tolist() == [0.04, 0.3]
    natural = {"units": "natural", "beside": beside | {"yerr": "mu"}}
    with pytest.raises(InputError, match=r"unit of column V: got 'mm/s'; allowed: no unit, for a"):
        drawn(OVER | natural)
