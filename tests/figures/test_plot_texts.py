"""What plots of a study's own say: captions of what is drawn, texts of users letter by letter."""

import io
from collections.abc import Mapping, Sequence
from xml.etree import ElementTree

import matplotlib as mpl
import numpy as np
import pandas as pd
import pytest
from matplotlib.figure import Figure
from matplotlib.markers import CARETDOWN, CARETUP

from sim.base.errors import InputError
from sim.base.plugins import load_plugins
from sim.figures.caption import parameters_sentence, parted
from sim.figures.data import figure_data
from sim.figures.family import _draw_points
from sim.figures.render import derive_texts
from sim.figures.style import SETTINGS, CurveStyle
from sim.study.plot_kinds import find_kind
from tests.figures.made_plots import GRID, drawn, flows, made
from tests.made.plugins import restore_plugins
from tests.made.processes import ROOT
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


@pytest.mark.parametrize("y", ["velocity", "shear_depth"])
def test_a_caption_explains_no_marker_and_no_bar_that_is_not_drawn(y):
    depth = {"shear_depth": 0.001}
    steady, plot = depth | {"regime": "steady"}, {"x": "friction", "y": y}
    text = caption_of(plot, at_frictions(steady, steady, steady))
    assert "Bars: " in text
    for word in ("caret", "aside", "markers", "interrupted", "only one"):
        assert word not in text
    speeding = depth | {"regime": "accelerating", "acceleration": 2.0}
    text = caption_of(plot, at_frictions(speeding, speeding, speeding))
    assert "Open markers are flows not shown to be steady: 3 points still" in text
    assert "Filled" not in text and "Lines are interrupted" in text
    short = depth | {"independent_samples": 4.0}
    text = caption_of(plot, at_frictions(steady, short, speeding))
    assert "Filled markers are steady flows; pale ones may be, their runs" in text
    assert "; open ones are not shown to be: 1 point still accelerating" in text
    text = caption_of(plot, at_frictions(short, short, short))
    assert "Pale markers are flows that may be steady, their runs" in text and "open" not in text


def test_a_caption_is_short_and_the_details_have_the_rest():
    steady, speeding = {"regime": "steady"}, {"regime": "accelerating", "acceleration": 2.0}
    points = at_frictions(steady, speeding, {"status": "failed", "reason": "blown up"})
    short, details = parted(caption_of({"x": "friction"}, points))
    assert short == (
        "Velocity: mean velocity over the averaging window, against friction μ. Bars: 95 % "
        "interval of the mean over 3 replicates (Student). Of 3 points, 1 is not shown to be "
        "steady and 1 failed."
    )
    assert details[0].startswith("Parameters: n = ")
    assert details[-1].startswith("Left out because the run failed: ")
    short, _ = parted(caption_of({"x": "friction"}, at_frictions(steady, steady, steady)))
    assert "Of" not in short


def test_a_caption_tells_of_carets_and_of_points_where_they_are():
    wide = {"velocity": 0.4, "shear_depth": [0.001, 0.1, 0.001]}
    usual = {"velocity": 0.4, "shear_depth": [0.001, 0.001, 0.001]}
    plot = {"x": "friction", "y": "shear_depth"}
    points = at_frictions(usual, usual, wide)
    assert "end in a caret" in caption_of(plot, points)
    figure, _, _ = drawn(plot, points)
    assert any(line.get_marker() in (CARETUP, CARETDOWN) for line in figure.axes[0].lines)
    # No marker of points that have no value is explained, and no bar that no point has.
    unknown = {"shear_depth": np.full(1, np.nan), "acceleration": 2.0}
    known = {"shear_depth": 0.001}
    text = caption_of(plot, at_frictions(known, known, unknown, replicates=1))
    assert "arker" not in text and "Bars:" not in text


UNKNOWN = {"velocity_error": np.full(3, np.nan)}


@pytest.mark.parametrize(
    ("plot", "points", "said"),
    [
        ({"x": "friction", "y": "velocity_error"}, at_frictions({}, UNKNOWN, UNKNOWN), "2 points"),
        (
            {"kind": "distribution", "x": "friction", "y": "velocity_error"},
            at_frictions({}, UNKNOWN, UNKNOWN),
            "2 points",
        ),
        (
            {"kind": "profiles", "x": "velocity", "between": [100, 200]},
            flows(),
            "6 points without a value at these heights",
        ),
        (
            {"kind": "profiles", "x": "velocity", "y": "packing", "between": [100, 200]},
            flows(),
            "6 points without a value at these heights",
        ),
    ],
)
def test_a_caption_counts_the_points_that_have_nothing_to_show(plot, points, said):
    assert f"Not drawn: {said}" in caption_of(plot, points)
    lost = {"status": "failed", "reason": "blown up", "velocity": np.nan}
    assert "Not drawn" not in caption_of(plot, at_frictions(lost, lost, lost))


@pytest.mark.parametrize(
    "plot",
    [
        {"kind": "distribution", "x": "friction", "y": "velocity"},
        {"kind": "time_series", "curves": "friction"},
    ],
)
def test_a_caption_tells_what_is_not_steady_where_no_marker_does(plot):
    steady = {"regime": "steady"}
    speeding = {"regime": "accelerating", "acceleration": 2.0}

    def told(*points: Mapping) -> list[str]:
        spec, results = made(plot, at_frictions(*points))
        return find_kind(spec.kind).notes(figure_data(results, spec))

    sentence = "Not surely steady, and drawn all the same: 2 points still accelerating."
    assert sentence in told(steady, speeding, speeding)
    assert "steady" not in " ".join(told(steady, steady, steady))


def test_profiles_tell_of_bands_or_of_pale_lines():
    plot = {"kind": "profiles", "curves": "friction", "panels": "angle"}
    assert "Bands: " in (text := caption_of(plot, flows(replicates=3))) and "pale" not in text
    assert "pale" in (text := caption_of(plot, flows(replicates=2))) and "Bands" not in text
    text = caption_of(plot, flows(replicates=1))
    assert "pale" not in text and "Bands" not in text


@pytest.mark.parametrize(
    ("notes", "said"), [("['a\\x1b[2J']", r"a\x1b[2J"), ("None", "TypeError: 'NoneType'")]
)
def test_notes_of_a_plugin_move_no_cursor(tmp_path, notes, said):
    path = tmp_path / "own.py"
    path.write_text(
        "import sim\n"
        f"sim.plot_kind('own', like='curves', notes=lambda data: {notes})(lambda data: None)\n"
    )
    with restore_plugins():
        load_plugins(path)
        plot = {"kind": "own", "x": "friction", "curves": "angle"}
        if notes == "None":
            with pytest.raises(InputError, match=said):
                caption_of(plot, flows())
        else:
            assert said in caption_of(plot, flows())


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
        points = [
            made_point(
                "chute",
                {"velocity": 0.5, "cost": 1.0},
                law="hertz_mindlin",
                friction=friction,
                youngs_modulus=modulus,
            )
            for friction in (0.3, 0.4)
            for modulus in (1e6, 2e6)
        ]
        curves, _, _ = drawn({"x": "friction", "curves": "youngs_modulus", "y": "cost"}, points)
        axis, _, _ = drawn({"x": "youngs_modulus", "panels": "friction", "y": "cost"}, points)
        panels, _, _ = drawn({"x": "friction", "panels": "youngs_modulus", "y": "cost"}, points)
    names = {r"_E_$1^2\frac = 1e+06 Pa", r"_E_$1^2\frac = 2e+06 Pa"}
    assert names | {"cost (m)"} <= shown_texts(curves)
    assert names <= shown_texts(panels)
    assert r"youngs modulus _E_$1^2\frac (Pa)" in shown_texts(axis)


def test_a_caption_names_choices_that_are_not_usual():
    rows = pd.DataFrame({"depth": [3.0, 3.0], "shape": ["disc", "disc"], "rotation": [0.0, 1.0]})
    told = parameters_sentence(rows, "conveyor", ("depth", "shape", "rotation"))
    assert told == "Parameters: n = 3; shape disc; no rotation and rotation."


def test_where_no_interval_is_known_there_is_no_bar():
    rows = pd.DataFrame({"depth": [1.0, 2.0], "regime": "steady", "quality": "reliable"})
    values, widths = pd.Series([1.0, 2.0]), {"yerr": pd.Series([0.1, float("nan")])}
    axes = Figure().subplots()
    _draw_points(axes, rows, values, "depth", CurveStyle("#000000", "-"), widths)
    drawn = [bars.lines[2] for bars in axes.containers]
    ends = [part.get_segments() for bars in drawn for part in bars]
    assert [len(segments) for segments in ends] == [1, 0, 0]
