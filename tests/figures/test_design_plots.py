"""Plots of points scattered in several parameters, as a design has them."""

import numpy as np
import pandas as pd
import pytest
from matplotlib.contour import ContourSet

from sim.base.statistics import student_half_width
from sim.figures.scatter import binned_means
from sim.study.plot_contents import has_logarithmic_values
from tests.figures.drawing import notes
from tests.figures.made_plots import drawn
from tests.made.results import MadePoint, made_point

UNSTEADY = {"regime": "accelerating", "acceleration": 2.0}


def design(number: int, unsteady: int = 0, **options) -> list[MadePoint]:
    """Return flows at places that fill friction and angle evenly; the first are not steady."""
    places = (np.arange(number)[:, None] * (0.7549, 0.5698) + 0.5) % 1
    return [
        made_point(
            "chute",
            {"velocity": friction + angle / 10} | (UNSTEADY if index < unsteady else {}),
            friction=round(0.3 + 0.4 * friction, 4),
            angle=round(16 + 4 * angle, 4),
            **options,
        )
        for index, (friction, angle) in enumerate(places)
    ]


def grid(columns: int, lines: int, **scalars) -> list[MadePoint]:
    at = [(x, y, {"velocity": 1.0 + x + y} | scalars) for x in range(columns) for y in range(lines)]
    return [made_point("chute", one, friction=0.3 + x / 50, angle=15 + y) for x, y, one in at]


def test_means_are_those_of_groups_of_neighbours():
    x = pd.Series(np.arange(16.0)[::-1])
    means = binned_means(x, 2 * x)
    assert means["points"].tolist() == [4] * 4 and means["mean"].tolist() == [3, 11, 19, 27]
    assert means[["from", "to"]].to_numpy().tolist()[0] == [0, 3]
    half = student_half_width(np.array([0.0, 2, 4, 6]))
    assert means["high"][0] - means["mean"][0] == pytest.approx(half)
    of_values = pd.Series([1.0, 1, 1, 4, 4, 4]), pd.Series([1.0, 10, 100, 2, 2, 2])
    assert binned_means(*of_values)["mean"].tolist() == [37, 2]
    assert binned_means(*of_values, log=True)["mean"][0] == pytest.approx(10)


@pytest.mark.parametrize(
    ("values", "is_log"),
    [
        (np.geomspace(100, 1e4, 20), True),
        (np.linspace(100, 1e4, 20), False),
        (np.geomspace(1, 5, 20), False),
        ([0, 1, 100], False),
    ],
)
def test_a_wide_range_filled_evenly_in_its_logarithm_is_logarithmic(values, is_log):
    assert has_logarithmic_values(pd.Series(values)) is is_log


@pytest.mark.parametrize(("number", "unsteady", "has_band"), [(14, 3, False), (14, 2, True)])
def test_many_points_have_a_running_mean_of_those_that_do_not_accelerate(
    number, unsteady, has_band
):
    plot = {"kind": "scatter", "x": "friction", "colour": "regime"}
    figure, rows, data = drawn(plot, design(number, unsteady))
    (axes,) = figure.axes
    means = [line for line in axes.lines if line.get_linewidth() == 1.6]
    assert len(rows) == number and bool(means) is has_band
    (markers,) = (one for one in axes.collections if len(one.get_offsets()) == number)
    assert (markers.get_facecolor() == 1).all(axis=1).sum() == unsteady
    assert [text.get_text() for text in figure.legends[0].texts] == ["accelerating", "steady"]
    assert ("Line: mean over groups" in notes(data)) is has_band
    assert "Pale and open markers" in notes(data)


@pytest.mark.parametrize(
    ("colour", "label", "column"),
    [("angle", "angle θ (°)", "angle [degree]"), ("shear_depth", "shear depth/σ", "[σ]")],
)
def test_the_colour_of_a_scatter_is_a_parameter_or_an_observable(colour, label, column):
    points = [
        made_point("chute", {"shear_depth": 0.01 * n}, friction=0.3 + n / 10, angle=16 + n)
        for n in range(4)
    ]
    plot = {"kind": "scatter", "x": "friction", "colour": colour, "units": "natural"}
    figure, rows, _ = drawn(plot, points)
    _, bar = figure.axes
    assert bar.get_ylabel().replace("\N{NO-BREAK SPACE}", " ") == label
    assert rows.filter(like=column).shape[1] >= 1


def test_main_effects_are_means_along_each_parameter_on_one_scale():
    figure, rows, data = drawn({"kind": "main_effects"}, design(25, unsteady=1))
    first, second = figure.axes
    assert first.get_ylim() == second.get_ylim()
    assert rows["parameter"].unique().tolist() == ["friction", "angle"]
    assert rows["points"].groupby(rows["parameter"]).sum().tolist() == [24, 24]
    means = rows.filter(like="mean velocity")[rows["parameter"] == "friction"].iloc[:, 0]
    assert means.is_monotonic_increasing
    assert "Not drawn, without a steady mean, as they accelerate: 1." in notes(data)


MAP = {"kind": "map", "x": "friction", "y": "angle", "colour": "velocity"}


def test_cells_of_a_small_grid_have_their_values_and_hatches_where_not_steady():
    figure, _, _ = drawn(MAP, [*grid(3, 2)[:-2], *grid(3, 2, **UNSTEADY)[-2:]])
    axes = figure.axes[0]
    values = [text.get_text() for text in axes.texts]
    assert sorted(values) == ["1", "2", "2", "3", "3", "4"]
    hatched = [one for one in axes.collections if one.get_hatch()]
    assert [(one.get_hatch(), len(one.get_paths())) for one in hatched] == [("////", 1)] * 2
    assert [text.get_text() for text in figure.legends[0].texts] == ["not steady"]
    assert axes.get_xlim() == pytest.approx((0.29, 0.35)) and axes.get_ylim() == pytest.approx(
        (14.5, 16.5)
    )


def test_contours_lie_between_scattered_points_unless_more_varies():
    figure, _, data = drawn(MAP, design(20))
    contours = [one for one in figure.axes[0].collections if isinstance(one, ContourSet)]
    assert len(contours) == 2 and "triangulation" in notes(data)
    deeper = made_point("chute", {"velocity": 1.0}, friction=0.31, angle=19.9, depth=7)
    figure, _, data = drawn(MAP, [*design(19), deeper])
    assert not [one for one in figure.axes[0].collections if isinstance(one, ContourSet)]
    assert "without contours: they also differ in depth n" in notes(data)


def test_curves_of_a_design_say_that_a_scatter_suits_it_better():
    figure, _, data = drawn({"x": "friction"}, design(16))
    assert not figure.legends and "scatter suits a design better" in figure.get_suptitle()
    assert "scatter suits a design better" in notes(data)
    figure, _, data = drawn({"x": "friction"}, grid(4, 4))
    assert figure.legends and not figure.get_suptitle()
