"""Legends of plots: room for what they say, however many and long the entries are."""

import matplotlib as mpl
import pytest

from sim.figures.pictures import settle
from sim.figures.style import COLOURS, DASHES, SETTINGS, cycle_style
from sim.figures.variables import MOST_ENTRIES
from tests.figures.made_plots import drawn
from tests.made.results import made_point


def flows_of_frictions(number):
    return [
        made_point(
            "chute", {"velocity": 1.0, "shear_depth": 0.01}, friction=0.2 + one / 1000, angle=angle
        )
        for one in range(number)
        for angle in (16, 17)
    ]


def boxes(figure):
    """Return the places of the legend and of the axes in the figure, laid out."""
    with mpl.rc_context(SETTINGS):
        settle(figure)
    (axes,), (legend,) = figure.axes, figure.legends
    whole = figure.transFigure.inverted()
    return legend.get_window_extent().transformed(whole), axes.get_position()


@pytest.mark.filterwarnings("error:constrained_layout not applied")
def test_a_figure_grows_with_its_legend():
    figure, _, _ = drawn({"x": "angle", "curves": "friction"}, flows_of_frictions(MOST_ENTRIES))
    legend, axes = boxes(figure)
    assert len(figure.legends[0].texts) == MOST_ENTRIES
    assert legend.y0 >= axes.y1 and legend.y1 <= 1 and axes.height * figure.get_figheight() > 2


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


def test_a_long_label_has_lines():
    label = "Somebody and Others (2001), glass $^3$, 20\N{DEGREE SIGN}, run III"
    beside = [{"label": label, "points": [[16, 1]]}]
    figure, _, _ = drawn(
        {"x": "angle", "curves": "friction", "beside": beside}, flows_of_frictions(2)
    )
    legend, _ = boxes(figure)
    assert legend.x0 >= 0 and legend.x1 <= 1
    text = figure.legends[0].texts[-1].get_text()
    assert "\n" in text and text.replace("\n", " ") == label.replace("$", r"\$")


def test_no_two_looks_share_colour_and_marker():
    number = len(COLOURS) * len(DASHES)
    looks = [cycle_style(index) for index in range(number)]
    assert len({(one.colour, one.marker) for one in looks}) == number
    assert len({(one.colour, str(one.dashes)) for one in looks}) == number
