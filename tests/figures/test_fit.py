"""Laws fitted to curves: their numbers in caption and data, and why there is none."""

import numpy as np
import pytest

from sim.base.errors import InputError
from sim.base.plugins import load_plugins
from sim.study.feed import plugin_code
from tests.figures.drawing import notes
from tests.figures.made_plots import drawn
from tests.made.processes import restore_plugins
from tests.made.results import made_point


def stop_height(x, low, high, factor):
    slope, low, high = np.tan(np.radians([x, low, high]))
    return factor * (high - slope) / (slope - low)


#: Numbers of each law by letter, which of them are larger where the law is, and the law.
LAWS = {
    "linear": ({"a": 0.2, "b": -0.1}, "a b", lambda x, a, b: a + b * x),
    "quadratic": (
        {"a": 0.2, "b": -0.1, "c": 0.03},
        "a b c",
        lambda x, a, b, c: a + b * x + c * x**2,
    ),
    "power": ({"a": 0.2, "b": 1.5}, "a", lambda x, a, b: a * x**b),
    "exponential": ({"a": 0.2, "b": 2.0}, "a", lambda x, a, b: a * np.exp(-x / b)),
    "pouliquen": ({"θ1": 0.2, "θ2": 1.1, "B": 0.1}, "B", stop_height),
    "mu_of_i": (
        {"μ1": 0.2, "μ2": 0.5, "I0": 0.4},
        "μ1 μ2",
        lambda x, a, b, c: a + (b - a) / (c / x + 1),
    ),
}
FRICTIONS = (0.3, 0.4, 0.5, 0.6, 0.8)


def flows(law, scatter=0.0, frictions=FRICTIONS, **changes):
    """Return flows whose velocity follows a law of friction, twice as large at 17°."""
    numbers, _, function = LAWS[law]
    signs = np.resize([1, -1, -1, 1], len(frictions))
    return [
        made_point(
            "chute",
            {"velocity": (angle - 15) * (function(friction, *numbers.values()) + scatter * sign)}
            | changes,
            friction=friction,
            angle=angle,
        )
        for angle in (16, 17)
        for friction, sign in zip(frictions, signs, strict=True)
    ]


def fitted(law, points, **plot):
    figure, rows, data = drawn({"x": "friction", "curves": "angle", "fit": law} | plot, points)
    return figure, rows, notes(data)


@pytest.mark.parametrize("law", LAWS)
def test_a_law_is_found_again_and_told_in_caption_and_data(law):
    figure, rows, caption = fitted(law, flows(law))
    assert f"Lines: {law} law y = " in caption and "weighted by the intervals" in caption
    for angle in (16, 17):
        curve = rows[rows["angle [degree]"] == angle]
        for letter, number in LAWS[law][0].items():
            scale = angle - 15 if letter in LAWS[law][1].split() else 1
            found = curve[f"{letter} of the fit"].unique()
            assert found == pytest.approx(scale * number, rel=1e-3)
            half = curve[f"half width of 95 % interval of {letter}"].iloc[0]
            assert half > 0 and f"{letter} = {found[0]:.4g} ± {half:.2g}" in caption
    lines = [line for line in figure.axes[0].lines if len(line.get_xdata()) > len(FRICTIONS)]
    assert len(lines) == 2
    assert all((line.get_xdata()[[0, -1]] == (0.3, 0.8)).all() for line in lines)


def test_intervals_hold_the_truth_where_points_scatter_more_than_their_intervals():
    _, rows, _ = fitted("linear", flows("linear", scatter=0.02))
    curve = rows[rows["angle [degree]"] == 16]
    slope, half = curve[["b of the fit", "half width of 95 % interval of b"]].iloc[0]
    assert abs(slope + 0.1) < half and half > 0.05


def at(velocity):
    """Return flows that all have one velocity."""
    places = [(friction, angle) for friction in FRICTIONS for angle in (16, 17)]
    return [made_point("chute", {"velocity": velocity}, friction=x, angle=y) for x, y in places]


@pytest.mark.parametrize(
    ("law", "points", "why"),
    [
        ("linear", flows("linear", frictions=(0.3, 0.4)), "2 values of x where 3 are needed"),
        ("power", at(-0.1), "some values are not above 0"),
        ("exponential", at(0.0), "it did not converge"),
        ("pouliquen", at(0.1), "it did not converge"),
        ("pouliquen", at(-0.1), "some values are not above 0"),
        ("mu_of_i", flows("linear", frictions=(0.3, 0.4, 0.5)), "3 values of x where 4 are needed"),
        ("linear", flows("linear", regime="accelerating", acceleration=2.0), "0 values of x"),
    ],
)
def test_why_there_is_no_fit_is_said_in_the_caption(law, points, why):
    _, rows, caption = fitted(law, points)
    assert caption.count(f"no fit, as {why}") == 2 and "a of the fit" not in rows


def test_a_plugin_adds_a_law_whose_edit_draws_its_plots_anew(tmp_path):
    codes = set()
    for power in (1, 2):
        (tmp_path / "own.py").write_text(
            "import sim\n"
            "@sim.fit('bent', formula='y = a - b x', start={'a': 1, 'b': 1})\n"
            f"def bent(x, a, b):\n    return a - b * x**{power}\n"
        )
        with restore_plugins():
            load_plugins(tmp_path / "own.py")
            _, rows, data = drawn(
                {"x": "friction", "curves": "angle", "fit": "bent"}, flows("linear")
            )
            assert "Lines: bent law y = a - b x, least squares" in notes(data)
            slope = rows.groupby("angle [degree]")["b of the fit"].first()
            assert (slope.to_numpy() == pytest.approx([0.1, 0.2], rel=1e-3)) == (power == 1)
            codes.add(plugin_code("curves", "bent"))
    assert len(codes) == 2 and plugin_code("curves", None) == ""


@pytest.mark.parametrize(
    ("declared", "why"),
    [
        ("formula='y', start={}", "fit f: start: got {}; allowed: a mapping of"),
        ("formula='y', start={'a': 'b'}", "fit f: start: got {'a': 'b'}; allowed: a mapping of"),
        ("formula='', start={'a': 1}", "fit f: formula: got ''; allowed: text, not empty"),
        ("formula='y', start={'a': 1, 'b': 2}", "fit f takes 1 argument, a, b: got '(x, a)'"),
    ],
)
def test_a_law_of_a_plugin_that_says_too_little_is_refused(tmp_path, declared, why):
    path = tmp_path / "own.py"
    path.write_text(f"import sim\nsim.fit('f', {declared})(lambda x, a: a)\n")
    with restore_plugins(), pytest.raises(InputError) as caught:
        load_plugins(path)
    assert why in str(caught.value)
