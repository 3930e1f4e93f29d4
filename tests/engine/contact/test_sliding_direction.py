"""Which way the friction of a sliding contact points: the equation that both readings solve.

Where T = μ F_N slides, the printed recipe turns it by dφ/ds = -K0 sin φ/(μ F_N), φ its angle with
the slip s, so tan(φ/2) falls as exp(-K0 s/(μ F_N)).
"""

import numpy as np
import pytest

from sim.claims.contacts import contact_path
from tests.engine_motion.helpers import SLIDINGS, sphere_law
from tests.engine_motion.points import chute_point, series_of

OVERLAP, START = 1e-5, np.radians(60.0)
Z = np.array([0.0, 0.0, 1.0])


def angles(sliding: str, step: float, steps: int, exponent: float = 1 / 3) -> np.ndarray:
    """Angles (S,) of the friction with a slip along x, of ``step`` μ F_N/K0 each.

    Before it the contact has slipped far at the angle START.
    """
    law = sphere_law(sliding_direction=sliding, tangential_exponent=exponent)
    scale = law.limit.friction * law.loading * OVERLAP / law.tangential
    earlier_slip = np.tile([np.cos(START), np.sin(START), 0.0], (40, 1))
    slip = scale * np.concatenate([0.5 * earlier_slip, np.tile([step, 0.0, 0.0], (steps, 1))])
    normal = np.tile(Z, (len(slip), 1))
    _, friction, _ = contact_path(law, np.full(len(slip), OVERLAP), normal, slip)
    return np.arctan2(friction[40:, 1], friction[40:, 0])


@pytest.mark.parametrize("sliding", SLIDINGS)
def test_short_slips_turn_it_as_the_equation_says(sliding):
    errors = []
    for step in (0.1, 0.05, 0.025):
        slips = step * np.arange(1, round(2 / step) + 1)
        expected = 2 * np.arctan(np.tan(START / 2) * np.exp(-slips))
        errors.append(np.abs(angles(sliding, step, len(slips)) - expected).max())
    assert errors[0] < 0.05
    assert errors[1:] == pytest.approx([errors[0] / 2, errors[0] / 4], rel=0.1)


@pytest.mark.parametrize("step", [3.0, 30.0, 3000.0])
def test_it_settles_along_long_slips_but_as_printed(step):
    assert np.abs(angles("slip", step, 20)[-1]) < 1e-6
    assert np.abs(angles("printed", step, 20)[-5:]).min() > 0.1


@pytest.mark.parametrize("sliding", SLIDINGS)
def test_a_linear_spring_settles_in_both_readings(sliding):
    assert np.abs(angles(sliding, 3.0, 20, exponent=0.0)[-1]) < 1e-6


@pytest.mark.parametrize(("sliding", "ratio"), [("slip", 0.1), ("printed", 0.08)])
def test_what_a_flow_that_slides_feels_at_the_plane(sliding, ratio):
    """The coefficient of friction; as printed about three quarters of it."""
    point = chute_point(
        depth=2, cell=4, angle=20, friction_plane=0.1, sliding_direction=sliding,
        transient=60, average=20, steps_per_collision=20,
    )  # fmt: skip
    series = {name: values[-60:] for name, values in series_of(point).items()}
    coefficient = series["base_shear_force"].mean() / series["base_normal_force"].mean()
    assert coefficient == pytest.approx(ratio, rel=0.03 if sliding == "slip" else 0.15)
