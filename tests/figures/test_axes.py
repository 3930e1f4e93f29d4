"""Limits of axes that follow values, not wide intervals."""

import pandas as pd

from sim.figures.axes import limit_axis
from sim.figures.style import canvas


def test_bars_that_go_a_little_out_extend_the_axis_and_wide_ones_are_cut():
    values, halves = pd.Series([1.0, 2.0, 3.0]), pd.Series([1.2, 9.0, 1.3])
    _, axes = canvas()
    axes.errorbar([1, 2, 3], values, yerr=halves, linestyle="none")
    limit_axis(axes, "y", values, halves)
    low, high = axes.get_ylim()
    assert -0.3 < low < -0.2 and 4.3 < high < 4.4
