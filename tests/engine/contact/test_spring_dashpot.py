"""Spring and dashpot along prescribed paths: the tangential spring, the pull at the end."""

import numpy as np
import pytest

from sim.claims.contacts import contact_path
from sim.engine.contact.spring_dashpot import spring_dashpot
from tests.engine_motion.helpers import MASS


def test_friction_is_a_spring_up_to_its_limit():
    law = spring_dashpot(100.0, 1.0, 0.4, MASS, 1e-6)
    steps = 50
    overlap, normal = np.full(steps, 1e-5), np.tile([1.0, 0.0, 0.0], (steps, 1))
    slip = np.tile([0.0, 2e-7, 0.0], (steps, 1))
    force, tangential, _ = contact_path(law, overlap, normal, slip)
    assert force == pytest.approx(1e-3)
    expected = np.minimum(80.0 * 2e-7 * np.arange(1, steps + 1), 0.4 * 1e-3)
    assert tangential[:, 1] == pytest.approx(expected, rel=1e-12)


def test_the_pull_at_the_end_of_a_contact_is_kept():
    law = spring_dashpot(100.0, 0.5, 0.4, MASS, 1e-6)
    overlap = np.array([2e-6, 1e-6, 1e-8])
    normal, slip = np.tile([1.0, 0.0, 0.0], (3, 1)), np.zeros((3, 3))
    force, _, _ = contact_path(law, overlap, normal, slip)
    assert force[-1] < 0.0
