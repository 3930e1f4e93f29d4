"""Judges of claims about friction, obstacles and the paths of the beads."""

import numpy as np
import pytest

from sim.claims.verdict import INCONCLUSIVE, REPRODUCED
from sim.papers.gallas.judges.friction import g9, g10, g11, g12, g36
from sim.papers.gallas.judges.paths import g24, g25, g31, g32, g33, g34
from tests.made.paper_belt import BEAD, paper_point, velocity
from tests.made.results import letters, verdict_of

SHEAR = (0, 10, 20, 50, 100)


#: Velocities (m/s) that rise fast up to 10g, and gently from there on.
GENTLE = (0.0, 0.1, 0.102, 0.105, 0.108)


def damped(velocities=None, values=SHEAR, frequencies=(20, 50), **rest):
    """Return points along the shear friction coefficient, with velocities (m/s) if given."""
    scalars_by_value = (
        [None] * len(values) if velocities is None else [{"velocity": v} for v in velocities]
    )
    return [
        paper_point(scalars, frequency=frequency, shear_damping=shear, **rest)
        for frequency in frequencies
        for shear, scalars in zip(values, scalars_by_value, strict=True)
    ]


@pytest.mark.parametrize(("half_width", "verdict"), [(1e-6, REPRODUCED), (2e-3, INCONCLUSIVE)])
def test_converged_velocities_must_be_known_not_to_drift(half_width, verdict):
    steady = {"acceleration": 0.0, "acceleration_half_width": half_width}
    points = [
        paper_point(
            {"velocity": velocity} | steady, frequency=f, shear_damping=shear, protocol=protocol
        )
        for protocol in ("converged", "published")
        for f in (20, 50)
        for shear, velocity in zip(SHEAR, GENTLE, strict=True)
    ]
    assert verdict_of(g9, points, protocol="converged") == verdict
    assert verdict_of(g9, points) == REPRODUCED


def still(velocities, frequencies=(20, 50)):
    """Return points without shear friction, velocities (m/s) per bed, and the usual points."""
    free = [
        paper_point({"velocity": velocities}, frequency=frequency, shear_damping=0)
        for frequency in frequencies
    ]
    return [*free, *(paper_point(frequency=frequency) for frequency in (20, 50))]


def scattered(ratio, **rest):
    """Return points whose relative scatter below g is ``ratio`` times that at 50g."""
    usual = damped(values=(50,), scatter=0.01, **rest)
    return usual + damped(values=(0.2, 0.5), scatter=0.01 * ratio, **rest)


SIZES = (0, 0.5, 1.5, 2.5)


def behind(velocities=None, sizes=SIZES, **rest):
    """Return points at two frequencies and several diameters, with velocities (m/s) if given."""
    scalars_by_size = (
        [None] * len(sizes) if velocities is None else [{"velocity": v} for v in velocities]
    )
    return [
        paper_point(scalars, frequency=frequency, obstacle=size, **rest)
        for frequency in (20, 80)
        for size, scalars in zip(sizes, scalars_by_size, strict=True)
    ]


def turbulent(share):
    """Return points behind two obstacles with a share of beads that move backwards."""
    return [paper_point({"backflow": share}, frequency=80, obstacle=size) for size in (1.5, 2.5)]


def slowed(local, scatter=1e-3, far_height=1.2):
    """Return beds with and without an obstacle, slowed everywhere or only close to it.

    Behind it the paths are 1.2 times as high as without it, and ``far_height`` times as high far
    away.
    """
    points = []
    for frequency in (20, 80):
        free = paper_point(frequency=frequency)
        speed = velocity(free.parameters)

        def along(column, speed=speed):
            near = np.abs(column - 10 * BEAD) < 4 * BEAD
            return speed * np.where(near, 0.4, 1.0 if local else 0.5)

        height = free.scalars["path_vertical"].mean()
        scalars = {"path_vertical": 1.2 * height, "path_vertical_far": far_height * height}
        profiles = {"column_velocity": along}
        stopped = paper_point(scalars, profiles, frequency=frequency, obstacle=1.5, scatter=scatter)
        points += [free, stopped]
    return points


PANELS = {
    "a": {"frequency": 10},
    "steeper": {"frequency": 10, "vibration_angle": 60},
    "b": {"frequency": 10, "shear_damping": 1},
    "c": {"frequency": 20},
    "d": {"frequency": 80},
    "e": {"frequency": 80, "shear_damping": 0},
}


def panels(changed="", scalars=None, **rest):
    """Return the points of Fig. 4; that of one panel has other measures."""
    return [
        paper_point(scalars if name == changed else None, **parameters, **rest)
        for name, parameters in PANELS.items()
    ]


STREAMS = (
    {"vibration_angle": 30},
    {},
    {"vibration_angle": 60},
    {"damping": 10, "shear_damping": 10},
)


def streams(changed=None, **rest):
    """Return points at 80 Hz; those named by their place have paths of that height (m)."""
    return [
        paper_point(
            {"path_vertical": changed[index]} if index in (changed or {}) else None,
            frequency=80,
            **parameters,
            **rest,
        )
        for index, parameters in enumerate(STREAMS)
    ]


def blocked(scalars=None, **rest):
    """Return points at 80 Hz with an obstacle, and without it at 80 and 20 Hz."""
    return [
        paper_point(scalars, frequency=80, obstacle=1.5, **rest),
        paper_point(frequency=80, **rest),
        paper_point(frequency=20, **rest),
    ]


#: Judges, the verdicts of their parts, and worlds that make them.
WORLDS = [
    (g9, "aR bR", lambda: damped()),
    (g9, "aN bN", lambda: damped([0, 0.05, 0.06, 0.08, 0.1])),
    (g9, "aR bN", lambda: damped([0, 0.1, 0.1, 0.095, 0.09], replicates=8)),
    # It falls by less than orders forgive.
    (g9, "aR bI", lambda: damped([0, 0.1, 0.1, 0.099, 0.097], replicates=8)),
    (g9, "aI bI", lambda: damped(scatter=0.4)),
    # More beds make a small velocity no larger.
    (g10, "R", lambda: still([0.001, 0.0011, 0.0009, 0.001, 0.001])),
    (g10, "N", lambda: still([0.05, 0.051, 0.049, 0.05, 0.05])),
    (g10, "I", lambda: still([0.05, -0.05, 0.04, -0.06, 0.02])),
    (g11, "R", lambda: scattered(20)),
    (g11, "N", lambda: scattered(0.8)),
    (g11, "I", lambda: scattered(2)),
    (g12, "R", lambda: damped([0.25, 0.25], (50, 100), (80,))),
    (g12, "N", lambda: damped([0.25, 0.4], (50, 100), (80,))),
    (g12, "I", lambda: damped([0.25, 0.25], (50, 100), (80,), scatter=0.2)),
    (g36, "R", lambda: damped(values=(20, 50, 100), frequencies=(20, 80))),
    # A fast flow that γ_s slows is changed as well.
    (
        g36,
        "N",
        lambda: (
            damped([0.1] * 3, (20, 50, 100), (20,)) + damped([0.3, 0.25, 0.2], (20, 50, 100), (80,))
        ),
    ),
    (g36, "I", lambda: damped(values=(20, 50, 100), frequencies=(20, 80), scatter=0.1)),
    (g31, "R", lambda: behind()),
    (g31, "N", lambda: behind([0.3, 0.25, 0.1, 0.05])),
    (g31, "I", lambda: behind(scatter=0.5)),
    (g33, "R", lambda: turbulent(0.001)),
    (g33, "N", lambda: turbulent(0.05)),
    (g33, "I", lambda: turbulent([0.0, 0.02, 0.005, 0.03, 0.001])),
    (g34, "R", lambda: slowed(local=False)),
    # The shape changes nowhere but close to the obstacle.
    (g34, "N", lambda: slowed(local=True, far_height=1.0)),
    (g34, "I", lambda: slowed(local=False, scatter=1.5)),
    (g24, "aR bR cR dR", lambda: panels()),
    (g24, "aN bR cR dR", lambda: panels("a", {"path_drift": 3e-4})),
    (g24, "aR bN cR dR", lambda: panels("b", {"path_tilt": np.radians(45)})),
    (g24, "aR bR cN dR", lambda: panels("c", {"path_drift": -1e-3})),
    (g24, "aR bR cR dN", lambda: panels("e", {"path_drift": 1e-3})),
    (g24, "aI bI cI dI", lambda: panels(scatter=1)),
    (g24, "bR cR dR", lambda: panels()[:1] + panels()[2:]),
    (g25, "aR bR", lambda: streams()),
    (g25, "aN bR", lambda: streams({0: 1e-2, 2: 1e-6})),
    (g25, "aR bN", lambda: streams({3: 1e-6})),
    (g25, "aR bI", lambda: streams({3: 3e-4}, replicates=2)),
    (g32, "R", lambda: blocked()),
    (g32, "N", lambda: blocked({"path_vertical": 1e-4, "path_drift": 1e-3})),
    (g32, "I", lambda: blocked({"path_vertical": 0.84e-3, "path_drift": 3.6e-3}, scatter=0.2)),
]


@pytest.mark.parametrize(("judge", "verdicts", "world"), WORLDS)
def test_right_wrong_and_undecided_worlds(judge, verdicts, world):
    assert letters(judge, world()) == verdicts
