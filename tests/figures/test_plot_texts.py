"""What plots say: captions, legends, data beside them, and texts of users letter by letter."""

import io
from collections.abc import Mapping, Sequence
from xml.etree import ElementTree

import matplotlib as mpl
import numpy as np
import pandas as pd
import pytest
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from sim.base.errors import InputError
from sim.base.plugins import load_plugins
from sim.figures.caption import caption, parameter_lines, parted
from sim.figures.pictures import settle
from sim.figures.plot import _MARKERS
from sim.figures.regimes import MARKS
from sim.figures.style import COLOURS, DASHES, MARKERS, SETTINGS, cycle_style
from sim.figures.variables import MOST_ENTRIES
from tests.figures.drawing import derive_texts
from tests.figures.made_plots import GRID, drawn, flows, made
from tests.made.processes import ROOT, restore_plugins
from tests.made.results import MadePoint, made_point


def caption_of(plot: Mapping, points: Sequence[MadePoint]) -> str:
    spec, results = made(plot, points)
    return derive_texts(spec, results)[1]


def at_frictions(*scalars: Mapping, replicates: int = 3) -> list[MadePoint]:
    """Return a flow per friction, what it came to given."""
    return [
        made_point("chute", {"velocity": 0.5} | dict(one), friction=friction, replicates=replicates)
        for one, friction in zip(scalars, GRID["friction"], strict=True)
    ]


STEADY, SHORT = {"regime": "steady"}, {"independent_samples": 4.0}
SPEEDING = {"regime": "accelerating", "acceleration": 2.0}
LOST = {"status": "failed", "reason": "blown up", "velocity": np.nan}


def test_a_caption_is_short_and_the_details_have_the_rest():
    short, details = parted(caption_of({"x": "friction"}, at_frictions(STEADY, SPEEDING, LOST)))
    assert short == (
        "Velocity: mean velocity over the averaging window, against friction μ. Intervals: 95 %, "
        "of the mean over replicates (Student); they may go beyond the axes. Points: steady 1, "
        "accelerating 1, failed 1."
    )
    assert "depth: n = 5" in details
    assert [line for line in details if line.startswith("Left out because the run failed: ")]
    text = caption_of({"x": "friction"}, at_frictions(STEADY, SHORT, SPEEDING))
    assert "Points: steady 1, " in text and "too short to tell 1" in text
    assert "Pale and open markers, too, are means" in text


UNKNOWN = {"velocity_error": np.full(3, np.nan)}


@pytest.mark.parametrize(
    ("plot", "points", "said"),
    [
        (
            {"x": "friction", "y": "velocity_error"},
            at_frictions({}, UNKNOWN, UNKNOWN),
            "without a value: 2",
        ),
        (
            {"kind": "profiles", "x": "velocity", "between": [100, 200]},
            flows(),
            "without a value at these heights: 6",
        ),
    ],
)
def test_a_caption_counts_the_points_that_have_nothing_to_show(plot, points, said):
    assert f"Not drawn, {said}." in caption_of(plot, points)
    assert "Not drawn" not in caption_of(plot, at_frictions(LOST, LOST, LOST))


def test_notes_of_a_plugin_move_no_cursor(tmp_path):
    path = tmp_path / "own.py"
    path.write_text(
        "import sim\n"
        "sim.plot_kind('own', like='curves', notes=lambda data: ['a\\x1b[2J'])(lambda data: None)\n"
    )
    with restore_plugins():
        load_plugins(path)
        plot = {"kind": "own", "x": "friction", "curves": "angle"}
        assert r"a\x1b[2J" in caption_of(plot, flows())


def shown_texts(figure: Figure) -> set[str]:
    """Return the texts of a picture as they are drawn, spaces all alike."""
    with mpl.rc_context(SETTINGS | {"svg.fonttype": "none"}):
        figure.savefig(file := io.BytesIO(), format="svg")
    root = ElementTree.fromstring(file.getvalue())
    texts = root.iter("{http://www.w3.org/2000/svg}text")
    return {" ".join("".join(one.itertext()).split()) for one in texts}


def test_texts_of_users_are_drawn_as_they_are_written(tmp_path):
    """Dollars, subscripts and backslashes mean something to matplotlib, and a first _ hides."""
    law = (ROOT / "docs" / "examples" / "hertz_mindlin.py").read_text()
    law = law.replace('symbol="E", unit="Pa"', 'symbol="_E_$1^2/frac", unit="Pa"')
    own = 'talus.observable("cost", system="chute", unit="m", meaning="a $b")(len)'
    (tmp_path / "own.py").write_text(f"{law}\n{own}\n".replace("/frac", r"\\frac"))
    with restore_plugins():
        load_plugins(tmp_path / "own.py")
        options = {"law": "hertz_mindlin"}
        points = [
            made_point("chute", {"cost": 1.0}, friction=mu, grain_modulus=modulus, **options)
            for mu in (0.3, 0.4)
            for modulus in (1e6, 2e6)
        ]
        curves, _, _ = drawn({"x": "friction", "curves": "grain_modulus", "y": "cost"}, points)
        axis, _, _ = drawn({"x": "grain_modulus", "panels": "friction", "y": "cost"}, points)
    names = {r"_E_$1^2\frac = 1e+06 Pa", r"_E_$1^2\frac = 2e+06 Pa"}
    assert names | {"cost (m)"} <= shown_texts(curves)
    assert r"grain modulus _E_$1^2\frac (Pa)" in shown_texts(axis)


def test_a_caption_names_choices_that_are_not_usual():
    rows = pd.DataFrame({"depth": [3.0, 3.0], "shape": ["disc", "disc"], "rotation": [0.0, 1.0]})
    told = parameter_lines(rows, "conveyor", ("depth", "shape", "rotation"))
    assert told == ["depth: n = 3", "shape disc", "no rotation and rotation"]


# Legends.


def flows_of_frictions(number):
    scalars = {"velocity": 1.0, "shear_depth": 0.01}
    return [
        made_point("chute", scalars, friction=0.2 + one / 1000, angle=angle)
        for one in range(number)
        for angle in (16, 17)
    ]


@pytest.mark.filterwarnings("error:constrained_layout not applied")
def test_a_figure_grows_with_its_legend_and_a_long_label_has_lines():
    label = "Somebody and Others (2001), glass $^3$, 20\N{DEGREE SIGN}, run III"
    plot = {"x": "angle", "curves": "friction", "beside": [{"label": label, "points": [[16, 1]]}]}
    figure, _, _ = drawn(plot, flows_of_frictions(MOST_ENTRIES))
    with mpl.rc_context(SETTINGS):
        settle(figure)
    (axes,), (legend,) = figure.axes, figure.legends
    place, box = legend.get_window_extent(), axes.get_position()
    place = place.transformed(figure.transFigure.inverted())
    assert place.x0 >= 0 and place.x1 <= 1 and box.y1 <= place.y0 and place.y1 <= 1
    assert len(legend.texts) == MOST_ENTRIES + 1 and box.height * figure.get_figheight() > 2
    text = legend.texts[-1].get_text()
    assert "\n" in text and text.replace("\n", " ") == label.replace("$", r"\$")


@pytest.mark.parametrize("plot", [{}, {"kind": "distribution"}])
def test_a_colour_bar_tells_many_curves_of_a_number_apart(plot):
    points = flows_of_frictions(MOST_ENTRIES + 1)
    figure, _, _ = drawn({"x": "angle", "curves": "friction"} | plot, points)
    axes, bar = figure.axes
    assert not figure.legends and bar.get_ylabel() == "friction μ"
    shown = {line.get_color() for line in axes.lines if len(line.get_xdata()) > 1}
    assert len(shown) > MOST_ENTRIES


def test_more_curves_of_several_parameters_than_entries_are_counted():
    points = flows_of_frictions(MOST_ENTRIES // 2 + 1)
    figure, _, _ = drawn({"x": "shear_depth", "curves": ["friction", "angle"]}, points)
    (text,) = figure.legends[0].texts
    assert text.get_text().split() == f"{len(points)} curves, which the data names".split()


def test_no_two_looks_share_colour_and_marker_and_data_beside_look_like_none():
    number = len(COLOURS) * len(DASHES)
    looks = [cycle_style(index) for index in range(number)]
    assert len({(one.colour, one.marker) for one in looks}) == number
    assert len({(one.colour, str(one.dashes)) for one in looks}) == number
    assert not set(_MARKERS) & {*MARKERS, *(marker for marker, _, _ in MARKS.values())}


# Data beside plots, which the study did not simulate.

MEASURED = {"label": "_glass $d$", "points": [[0.1, 0.5], [0.9, 0.9]]}
LAW = {"label": "law", "points": [[0.3, 0.4], [0.6, 0.2], [0.6, 0.1]], "line": True}
OVER = {"x": "friction", "curves": "angle"}


def foreign_lines(axes, data_set: dict) -> list[Line2D]:
    """Return the artists of a foreign data set on some axes."""
    at = np.array(data_set["points"], float)
    return [line for line in axes.lines if np.array_equal(line.get_xydata(), at)]


@pytest.mark.parametrize(
    ("plot", "x", "y"),
    [
        (OVER, "friction", "mean velocity"),
        ({"kind": "map", "x": "friction", "y": "angle", "colour": "velocity"}, "friction", "angle"),
        ({"kind": "profiles", "x": "packing", "panels": "angle"}, "packing", "height"),
        (
            {"kind": "profiles", "x": "granular_temperature", "y": "packing", "curves": "angle"},
            *("granular", "packing"),
        ),
    ],
)
def test_data_beside_are_in_every_panel_the_legend_the_caption_and_the_data(plot, x, y):
    figure, rows, data = drawn(plot | {"beside": [MEASURED, LAW]})
    for axes in figure.axes:
        if axes.get_label() == "<colorbar>":
            continue
        (markers,), (line,) = foreign_lines(axes, MEASURED), foreign_lines(axes, LAW)
        assert markers.get_linestyle() == "None" and markers.get_marker() in _MARKERS
        assert line.get_marker() == "None" and line.get_linestyle() != "-"
        assert not {markers.get_color(), line.get_color()} & set(COLOURS)
        (left, right), (bottom, top) = axes.get_xlim(), axes.get_ylim()
        places = np.array([*MEASURED["points"], *LAW["points"]])
        assert left <= places[:, 0].min() and places[:, 0].max() <= right
        assert bottom <= places[:, 1].min() and places[:, 1].max() <= top
    assert {"_glass $d$", "law"} <= shown_texts(figure)
    assert "not simulated here: _glass $d$ (markers); law (line)." in caption(data, [])
    beside = rows[rows["not of this study"].notna()]
    assert beside["not of this study"].tolist() == ["_glass $d$"] * 2 + ["law"] * 3
    assert beside["point"].isna().all() and rows["point"].notna().sum() == len(rows) - 5
    foreign = beside.dropna(axis=1, how="all").drop(columns="not of this study")
    assert foreign.filter(regex=f"^{x}").iloc[:, 0].tolist() == places[:, 0].tolist()
    assert foreign.filter(regex=f"^{y}").iloc[:, 0].tolist() == places[:, 1].tolist()
    assert foreign.shape[1] == 2


def test_columns_of_a_file_are_drawn_with_their_errors(tmp_path, monkeypatch):
    (tmp_path / "exp.csv").write_text("mu,V (mm/s),s (mm/s)\n0.35,650,40\n0.58,400,300\n")
    monkeypatch.chdir(tmp_path)
    beside = {"file": "exp.csv", "x": "mu", "y": "V", "yerr": "s"}
    label = {"label": "θ = 16°", "points": [[0.3, 0.5]]}
    figure, rows, data = drawn(OVER | {"beside": [beside, label]})
    assert data.spec.foreign[0] == ("exp", ((0.35, 0.65, 0.04), (0.58, 0.4, 0.3)), False)
    axes = figure.axes[0]
    (bars,) = axes.collections[-1:]
    np.testing.assert_allclose(bars.get_segments()[1], [[0.58, 0.1], [0.58, 0.7]])
    assert axes.get_ylim()[0] < 0.1
    assert "exp (markers, bars: its errors)" in caption(data, [])
    assert rows["error, not of this study"].dropna().tolist() == [0.04, 0.3]
    named = [text.get_text() for text in figure.legends[0].texts]
    assert named == ["θ = 16°", "θ = 17°", "exp", "θ = 16°"], "each has an entry of its own"
    natural = {"units": "natural", "beside": beside | {"yerr": "mu"}}
    with pytest.raises(InputError, match=r"unit of column V: got 'mm/s'; allowed: no unit, for a"):
        drawn(OVER | natural)
