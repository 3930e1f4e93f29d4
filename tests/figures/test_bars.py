"""Error bars that the axes cut."""

from matplotlib.markers import CARETDOWN, CARETLEFT, CARETRIGHT, CARETUP

from sim.figures.axes import mark_cut_bars
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


def test_bars_along_x_end_in_carets_at_the_sides():
    _, axes = canvas()
    axes.errorbar([1, 2, 3], [1, 2, 3], xerr=[0.5, 3, 2], linestyle="none")
    axes.set_xlim(0, 4)
    before = len(axes.get_lines())
    mark_cut_bars(axes)
    carets = {
        (line.get_xdata()[0], line.get_ydata()[0], line.get_marker())
        for line in axes.get_lines()[before:]
    }
    assert carets == {(0, 2, CARETLEFT), (4, 2, CARETRIGHT), (4, 3, CARETRIGHT)}
