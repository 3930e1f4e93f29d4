"""Laws fitted to curves: their numbers in caption and data, and why there is none."""

import numpy as np
import pytest

from tests.figures.drawing import notes
from tests.figures.made_plots import drawn
from tests.made.results import made_point

#: Numbers a, b, c of each law, and the law.
LAWS = {
    "linear": ((0.2, -0.1), lambda x, a, b: a + b * x),
    "quadratic": ((0.2, -0.1, 0.03), lambda x, a, b, c: a + b * x + c * x**2),
    "power": ((0.2, 1.5), lambda x, a, b: a * x**b),
    "exponential": ((0.2, 2.0), lambda x, a, b: a * np.exp(-x / b)),
}
FRICTIONS = (0.3, 0.4, 0.5, 0.6, 0.8)


def flows(law, scatter=0.0, frictions=FRICTIONS, **changes):
    """Return flows whose velocity follows a law of friction, twice as large at 17°."""
    numbers, function = LAWS[law]
    signs = np.resize([1, -1, -1, 1], len(frictions))
    return [
        made_point(
            "chute",
            {"velocity": (angle - 15) * (function(friction, *numbers) + scatter * sign)} | changes,
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
    assert f"Lines: {law} law y = a" in caption and "weighted by the intervals" in caption
    for angle in (16, 17):
        curve = rows[rows["angle [degree]"] == angle]
        for letter, number in zip("abc", LAWS[law][0], strict=False):
            scale = angle - 15 if letter == "a" or law in ("linear", "quadratic") else 1
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
        ("linear", flows("linear", regime="accelerating", acceleration=2.0), "0 values of x"),
    ],
)
def test_why_there_is_no_fit_is_said_in_the_caption(law, points, why):
    _, rows, caption = fitted(law, points)
    assert caption.count(f"no fit, as {why}") == 2 and "a of the fit" not in rows
