"""Error bars that the axes cut, and ticks whose numbers do not touch."""

from itertools import pairwise

import numpy as np
import pandas as pd
import pytest
from matplotlib.markers import CARETDOWN, CARETLEFT, CARETRIGHT, CARETUP

from sim.figures.axes import has_cut_bars, limit_axis, mark_cut_bars, set_ticks
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


def test_bars_that_go_a_little_out_extend_the_axis_and_wide_ones_are_cut():
    values, halves = pd.Series([1.0, 2.0, 3.0]), pd.Series([1.2, 9.0, 1.3])
    _, axes = canvas()
    axes.errorbar([1, 2, 3], values, yerr=halves, linestyle="none")
    limit_axis(axes, "y", values, halves)
    low, high = axes.get_ylim()
    assert -0.3 < low < -0.2 and 4.3 < high < 4.4
    before = len(axes.get_lines())
    mark_cut_bars(axes)
    carets = {line.get_xdata()[0] for line in axes.get_lines()[before:]}
    assert carets == {2}
    none = pd.Series(dtype=float)
    assert has_cut_bars(values, halves, none, logarithmic=False)
    assert not has_cut_bars(values[[0, 2]], halves[[0, 2]], none, logarithmic=False)


@pytest.mark.parametrize(
    ("values", "named", "rotation"),
    [
        ([1, 2, 3], ["1", "2", "3"], 0),
        ([0.35, 0.36, 0.4], ["0.35", "0.36", "0.4"], 0),
        (np.arange(100, 121), [str(value) for value in range(100, 121)], 90),
    ],
)
def test_tick_labels_do_not_touch(values, named, rotation):
    figure, axes = canvas()
    axes.set_xlim(min(values) - 0.01, max(values) + 0.01)
    set_ticks(axes, values, 4.6)
    figure.draw_without_rendering()
    shown = axes.get_xticklabels()
    assert [text.get_text() for text in shown] == named
    assert {text.get_rotation() for text in shown} == {rotation}
    boxes = [text.get_window_extent() for text in shown]
    assert all(one.x1 < other.x0 for one, other in pairwise(boxes))


def test_values_too_dense_for_numbers_keep_their_ticks():
    _, axes = canvas()
    values = np.linspace(0, 1, 201)
    axes.set_xlim(0, 1)
    set_ticks(axes, values, 4.6)
    places = {*axes.get_xticks(), *axes.get_xticks(minor=True)}
    assert places == set(values)
    assert {0.0, 1.0} <= set(axes.get_xticks()) and len(axes.get_xticks()) < 201
