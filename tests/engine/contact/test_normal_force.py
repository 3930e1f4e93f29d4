"""The hysteretic normal force of one contact along prescribed overlaps."""

import numpy as np
import pytest

from sim.claims.contacts import contact_path
from tests.engine_motion.helpers import MEMORIES, dissipated_energy, sphere_law

PEAK = 1e-5


def normal_forces(law, overlaps) -> np.ndarray:
    """Normal force (n,) along overlaps (n,) > 0, without slip."""
    overlap = np.array(overlaps, float)
    normal = np.tile([0.0, 0.0, 1.0], (overlap.size, 1))
    return contact_path(law, overlap, normal, np.zeros_like(normal))[0]


def rest_overlap(law) -> float:
    """Overlap at which the force falls to zero after a peak overlap of PEAK."""
    return (1.0 - law.loading / law.unloading) * PEAK


@pytest.mark.parametrize("restitution", [0.3, 0.7, 0.85, 1.0])
@pytest.mark.parametrize("memory", MEMORIES)
def test_force_loads_along_k1_and_unloads_and_reloads_along_k2(memory, restitution):
    law = sphere_law(restitution=restitution, overlap_memory=memory)
    rest = rest_overlap(law)
    rising = np.linspace(0.01, 1.0, 50) * PEAK
    falling = np.linspace(PEAK, 1.001 * rest + 1e-3 * PEAK, 50)
    again = np.linspace(falling[-1], 1.5 * PEAK, 80)
    force = normal_forces(law, np.concatenate([rising, falling, again]))
    assert force[:50] == pytest.approx(law.loading * rising, rel=1e-12)
    assert force[50:100] == pytest.approx(law.unloading * (falling - rest), rel=1e-9)
    expected = np.minimum(law.unloading * (again - rest), law.loading * again)
    assert force[100:] == pytest.approx(expected, rel=1e-9)
    assert law.loading / law.unloading == pytest.approx(restitution**2, rel=1e-14)


def test_work_lost_in_a_cycle_is_the_share_of_one_minus_restitution_squared():
    law = sphere_law(restitution=0.7)
    path = np.concatenate([np.linspace(0, PEAK, 20_001)[1:], np.linspace(PEAK, 0, 20_001)[1:-1]])
    force = normal_forces(law, path)
    loss = np.trapezoid(force, path)
    expected = 0.5 * law.loading * PEAK**2 * (1 - 0.7**2)
    assert loss == pytest.approx(expected, rel=1e-3)
    assert dissipated_energy(law, path) == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("memory", MEMORIES)
def test_a_contact_without_force_loads_again_as_its_memory_says(memory):
    """Below the dent, separation stays without force, shrink pushes along K2, reset along K1."""
    law = sphere_law(overlap_memory=memory)
    low, rise = 0.5 * rest_overlap(law), 0.01 * PEAK
    force = normal_forces(law, [PEAK, low, low + rise])
    assert force[1] == 0.0
    expected = {
        "separation": 0.0,
        "shrink": law.unloading * rise,
        "reset": law.loading * (low + rise),
    }
    assert force[2] == pytest.approx(expected[memory], rel=1e-9, abs=1e-18)


@pytest.mark.parametrize("memory", MEMORIES)
def test_force_never_pulls_nor_exceeds_the_loading_line(memory):
    law = sphere_law(overlap_memory=memory, restitution=0.5)
    overlap = PEAK * np.random.default_rng(3).uniform(1e-6, 1.0, 20_000)
    force = normal_forces(law, overlap)
    assert force.min() == 0.0
    assert (force <= law.loading * overlap * (1 + 1e-14)).all()
