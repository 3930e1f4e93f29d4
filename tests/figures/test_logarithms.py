"""Logarithmic axes of plots: what has no place there is not drawn, and the caption counts it."""

import numpy as np
import pytest

from tests.figures.drawing import notes
from tests.figures.made_plots import SIZE, drawn
from tests.made.results import made_point


def flows(velocities, **options):
    """Return a flow at each friction whose velocity over the height is that at most, -1 below."""

    def packing(height):
        return np.where(height < 5 * SIZE, 0.6, 0.0)

    def profile(velocity):
        return lambda height: np.where(height < 2 * SIZE, -1.0, np.mean(velocity))

    return [
        made_point(
            "chute",
            {"velocity": velocity},
            {"packing_profile": packing, "velocity_profile": profile(velocity)},
            friction=friction,
            **options,
        )
        for friction, velocity in velocities.items()
    ]


@pytest.mark.parametrize("replicates", [2, 3])
def test_profiles_are_interrupted_where_they_are_not_above_zero(replicates):
    points = flows({0.3: 1.0, 0.4: 2.0}, replicates=replicates)
    plot = {"kind": "profiles", "curves": "friction"}
    figure, rows, data = drawn(plot | {"log": ["x"]}, points)
    shown = [np.asarray(line.get_xdata(), float) for line in figure.axes[0].lines]
    assert shown and not any((values <= 0).any() for values in shown)
    lost = int((rows["velocity [m/s]"] <= 0).sum())
    assert lost and f"slices not above 0 on a logarithmic axis: {lost}." in notes(data)
    _, _, data = drawn(plot, points)
    assert "logarithmic" not in notes(data)


def test_a_distribution_counts_the_replicates_that_are_not_drawn():
    points = flows({0.3: [1.0, -1.0, 2.0], 0.4: [1.0, 0.0, -1.0]})
    plot = {"kind": "distribution", "x": "friction", "log": ["y"]}
    _, rows, data = drawn(plot, points)
    assert len(rows) == 6 and "replicates not above 0 on a logarithmic axis: 3." in notes(data)
    assert "logarithmic" not in notes(drawn(plot | {"log": []}, points)[2])


def test_ticks_of_many_powers_are_powers_alone():
    """Others would touch each other in small panels."""
    for powers, others in ((2, True), (5, False)):
        points = [
            made_point("chute", {"velocity": 10.0**-power}, friction=0.3 + power / 10)
            for power in range(powers)
        ]
        figure, _, _ = drawn({"x": "friction", "log": ["y"]}, points)
        digits = {f"{tick:e}"[0] for tick in figure.axes[0].get_yticks()}
        assert (digits == {"1"}) is not others
