"""What all figures share: styles that tell curves apart, a legend that leaves axes their room."""

import pytest
from matplotlib import rc_context
from matplotlib.backends.backend_agg import FigureCanvasAgg

from sim.figures.style import COLOURS, MARKERS, SETTINGS, canvas, cycled, legend_above


def drawn(labels: list[str]):
    """Return the figure, axes and legend of as many lines as there are labels."""
    with rc_context(SETTINGS):
        figure, axes = canvas()
        handles = [axes.plot([0, 1], [number, 1])[0] for number in range(len(labels))]
        legend_above(figure, handles, labels)
        FigureCanvasAgg(figure).draw()
    return figure, axes, figure.legends[0]


@pytest.mark.parametrize("number", [2, 12, 30])
def test_a_legend_of_many_rows_takes_no_room_of_the_axes(number):
    figure, axes, legend = drawn([f"angle {index}°" for index in range(number)])
    assert axes.bbox.height / figure.dpi > 2.9
    assert legend.get_window_extent().y0 >= axes.bbox.y1
    assert legend.get_window_extent().y1 <= figure.bbox.y1


def test_a_long_entry_is_broken_and_leaves_the_others_side_by_side():
    long = "glass beads on a rough plane, measured by somebody else"
    *_, legend = drawn(["one", "two", "three", long])
    texts = legend.get_texts()
    assert [text.get_text().replace("\n", " ") for text in texts] == ["one", "two", "three", long]
    assert texts[-1].get_text().count("\n") >= 1
    assert len({round(text.get_window_extent().x0) for text in texts}) > 1


def test_markers_and_colours_of_many_curves_differ():
    styles = [cycled(index) for index in range(len(COLOURS) * len(MARKERS))]
    assert len({(style.colour, style.marker) for style in styles}) == len(styles)
    assert len({(style.colour, style.dashes) for style in styles[:35]}) == 35
