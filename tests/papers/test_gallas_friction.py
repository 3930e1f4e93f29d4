"""Judges of claims about the shear friction coefficient."""

import pytest

from sim.claims.verdict import INCONCLUSIVE, REPRODUCED
from sim.papers.gallas.judges.friction import g9, g10, g11, g12, g36
from tests.made.judging import letters, verdict_of
from tests.made.paper_belt import paper_point

SHEAR = (0, 10, 20, 50, 100)


#: Velocities (m/s) that rise fast up to 10g, and gently from there on.
GENTLE = (0.0, 0.1, 0.102, 0.105, 0.108)


def line(velocities=None, values=SHEAR, frequencies=(20, 50), **rest):
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
    usual = line(values=(50,), scatter=0.01, **rest)
    return usual + line(values=(0.2, 0.5), scatter=0.01 * ratio, **rest)


#: Judges, the verdicts of their parts, and worlds that make them.
WORLDS = [
    (g9, "R", lambda: line()),
    (g9, "N", lambda: line([0, 0.05, 0.06, 0.08, 0.1])),
    (g9, "N", lambda: line([0, 0.1, 0.1, 0.095, 0.09])),
    (g9, "I", lambda: line(scatter=0.4)),
    (g9, "-", lambda: line(values=(0, 10, 50, 100))),
    # More beds make a small velocity no larger.
    (g10, "R", lambda: still([0.001, 0.0011, 0.0009, 0.001, 0.001])),
    (g10, "N", lambda: still([0.05, 0.051, 0.049, 0.05, 0.05])),
    (g10, "I", lambda: still([0.05, -0.05, 0.04, -0.06, 0.02])),
    (g10, "-", lambda: still([0.0, 0.001], frequencies=(20,))),
    (g11, "R", lambda: scattered(20)),
    (g11, "N", lambda: scattered(0.8)),
    (g11, "I", lambda: scattered(2)),
    (g11, "-", lambda: scattered(5, replicates=1)),
    (g12, "R", lambda: line([0.25, 0.25], (50, 100), (80,))),
    (g12, "N", lambda: line([0.25, 0.4], (50, 100), (80,))),
    (g12, "I", lambda: line([0.25, 0.25], (50, 100), (80,), scatter=0.2)),
    (g12, "-", lambda: line([0.25], (50,), (80,))),
    (g36, "R", lambda: line(values=(20, 50, 100), frequencies=(20, 80))),
    (
        g36,
        "N",
        lambda: (
            line([0.1] * 3, (20, 50, 100), (20,)) + line([0.2, 0.25, 0.3], (20, 50, 100), (80,))
        ),
    ),
    # A fast flow that γ_s slows is changed as well.
    (
        g36,
        "N",
        lambda: (
            line([0.1] * 3, (20, 50, 100), (20,)) + line([0.3, 0.25, 0.2], (20, 50, 100), (80,))
        ),
    ),
    (g36, "I", lambda: line(values=(20, 50, 100), frequencies=(20, 80), scatter=0.1)),
    (g36, "-", lambda: line(values=(20, 50, 100), frequencies=(20,))),
]


@pytest.mark.parametrize(("judge", "verdicts", "world"), WORLDS)
def test_right_wrong_and_undecided_worlds(judge, verdicts, world):
    assert letters(judge, world()) == verdicts
