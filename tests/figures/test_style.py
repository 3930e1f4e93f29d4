"""What all figures share in their look: error bars that the axes cut."""

from matplotlib.markers import CARETDOWN, CARETUP

from sim.figures.curves import mark_cut_bars
from sim.figures.style import canvas


def test_a_caret_stands_where_an_error_bar_leaves_the_axes():
    _, axes = canvas()
    axes.errorbar([1, 2, 3], [2, 1, 3], yerr=[0.5, 2, 4], color="#d55e00", linestyle="none")
    axes.set_ylim(0, 4)
    before = len(axes.get_lines())
    mark_cut_bars(axes)
    carets = {
        (line.get_xdata()[0], line.get_ydata()[0], line.get_marker(), line.get_color())
        for line in axes.get_lines()[before:]
    }
    assert carets == {
        (2, 0, CARETDOWN, "#d55e00"),
        (3, 0, CARETDOWN, "#d55e00"),
        (3, 4, CARETUP, "#d55e00"),
    }
    assert axes.get_ylim() == (0, 4)
