"""The damping that gives a restitution, against equations of motion of springs and dashpots."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from sim.parameters.dashpot import contact_time, damping_fraction, restitution_of, time_of

RESTITUTIONS = [0.99, 0.8, 0.5, 0.2, np.exp(-2.0), 0.1, 0.01]


def rebound(ratio: float, attraction: str, power: float) -> tuple[float, float]:
    """Return restitution and duration of x'' = -x^power - c x^((power - 1)/2) x' in its own units.

    ``power`` is 1 of a linear spring, 3/2 of Hertz's; c is 2 ζ and √5 ζ. The force acts until it is
    zero, or until the overlap is.
    """
    damping = (2.0 if power == 1 else np.sqrt(5.0)) * ratio

    def force(x, v):
        depth = max(x, 0.0)
        return depth**power + damping * depth ** ((power - 1) / 2) * v

    def ends(_, y):
        return force(*y) if attraction == "clipped" else y[0]

    ends.terminal, ends.direction = True, -1
    options = {"method": "LSODA", "events": ends, "rtol": 1e-10, "atol": 1e-13}
    found = solve_ivp(lambda _, y: [y[1], -force(*y)], (0, 1e3), [1e-9, 1.0], **options)
    return -found.y[1, -1], found.t[-1]


@pytest.mark.parametrize("attraction", ["kept", "clipped"])
@pytest.mark.parametrize("power", [1, 1.5])
@pytest.mark.parametrize("restitution", RESTITUTIONS)
def test_damping_gives_the_restitution_asked_for(restitution, power, attraction):
    share, whole = damping_fraction(restitution, attraction)
    found, time = rebound(share / whole, attraction, power)
    assert found == pytest.approx(restitution, rel=1e-5)
    assert restitution_of(share / whole, attraction) == pytest.approx(restitution, rel=1e-12)
    if power == 1:
        for said in (contact_time(restitution, attraction), time_of(share / whole, attraction)):
            assert time == pytest.approx(np.pi * said, rel=1e-5)


def test_without_loss_there_is_no_damping_and_clipping_takes_more():
    names = "kept", "clipped"
    for name in names:
        assert damping_fraction(1.0, name)[0] == 0.0 and contact_time(1.0, name) == 1.0
    for restitution in RESTITUTIONS:
        kept, clipped = (np.divide(*damping_fraction(restitution, name)) for name in names)
        assert clipped > kept > 0.0
