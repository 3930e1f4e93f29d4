"""What plots of a study's own say: captions of what is drawn, texts of users letter by letter."""

import io
from collections.abc import Mapping, Sequence
from xml.etree import ElementTree

import matplotlib as mpl
import numpy as np
import pandas as pd
import pytest
from matplotlib.figure import Figure

from sim.base.errors import InputError
from sim.base.plugins import load_plugins
from sim.figures.caption import parameter_lines, parted
from sim.figures.render import derive_texts
from sim.figures.style import SETTINGS
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
def test_a_caption_tells_intervals_and_states(y):
    depth = {"shear_depth": 0.001}
    steady, plot = depth | {"regime": "steady"}, {"x": "friction", "y": y}
    text = caption_of(plot, at_frictions(steady, steady, steady))
    assert "Intervals: 95 %" in text and "Points: steady 3." in text
    assert "open" not in text
    speeding = depth | {"regime": "accelerating", "acceleration": 2.0}
    short = depth | {"independent_samples": 4.0}
    text = caption_of(plot, at_frictions(steady, short, speeding))
    assert "Points: steady 1, " in text and "too short to tell 1" in text
    assert "accelerating 1" in text and "Pale and open markers, too, are means" in text


def test_a_caption_is_short_and_the_details_have_the_rest():
    steady, speeding = {"regime": "steady"}, {"regime": "accelerating", "acceleration": 2.0}
    points = at_frictions(steady, speeding, {"status": "failed", "reason": "blown up"})
    short, details = parted(caption_of({"x": "friction"}, points))
    assert short == (
        "Velocity: mean velocity over the averaging window, against friction μ. Intervals: 95 %, "
        "of the mean over replicates (Student); they may go beyond the axes. Points: steady 1, "
        "accelerating 1, failed 1."
    )
    assert "depth: n = 5" in details
    assert [line for line in details if line.startswith("Left out because the run failed: ")]


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
    lost = {"status": "failed", "reason": "blown up", "velocity": np.nan}
    assert "Not drawn" not in caption_of(plot, at_frictions(lost, lost, lost))


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
    told = parameter_lines(rows, "conveyor", ("depth", "shape", "rotation"))
    assert told == ["depth: n = 3", "shape disc", "no rotation and rotation"]
