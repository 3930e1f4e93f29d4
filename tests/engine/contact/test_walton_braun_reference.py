"""Every variant of the compiled law against the slow reference, along random histories."""

import numpy as np
import pytest

from sim.claims.contacts import contact_path
from tests.engine.reference.walton_braun import Contact, ContactLaw, update
from tests.engine_motion.helpers import CAPS, EXPONENTS, MEMORIES, SLIDINGS, sphere_law

STEPS = 400


def history(seed: int, slip_size: float):
    """Overlaps (n,), normals (n, 3) and slips (n, 3) of a contact that opens now and then."""
    rng = np.random.default_rng(seed)
    overlap = 1e-5 * (0.8 + 0.9 * np.sin(rng.normal(0, 0.15, STEPS).cumsum()))
    normal = rng.normal(0, 0.02, (STEPS, 3)).cumsum(axis=0)
    normal[:, 2] += 1.0
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    slip = slip_size * np.sin(rng.normal(0, 0.3, (STEPS, 3)).cumsum(axis=0))
    slip -= (slip * normal).sum(axis=1)[:, None] * normal
    return overlap, normal, slip


def closed_stretches(overlap):
    """Slices of the history during which the contact is closed."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], overlap > 0, [0]])))
    return [slice(a, b) for a, b in edges.reshape(-1, 2)]


@pytest.mark.parametrize("slip_size", [1e-8, 2e-7, 2e-6])
@pytest.mark.parametrize("memory", MEMORIES)
@pytest.mark.parametrize("exponent", EXPONENTS)
@pytest.mark.parametrize("cap", CAPS)
@pytest.mark.parametrize("sliding", SLIDINGS)
def test_law_equals_the_reference(sliding, cap, exponent, memory, slip_size):
    readings = {
        "tangential_exponent": exponent,
        "overlap_memory": memory,
        "friction_cap": cap,
        "sliding_direction": sliding,
    }
    law, slow = sphere_law(**readings), ContactLaw(100.0, 0.85, 0.4, **readings)
    scale = 0.4 * law.loading * 1e-5
    for seed in range(3):
        overlap, normal, slip = history(seed, slip_size)
        for closed in closed_stretches(overlap):
            path = contact_path(law, overlap[closed], normal[closed], slip[closed])
            contact = Contact()
            steps = zip(overlap[closed], normal[closed], slip[closed], *path, strict=True)
            for gap, k_hat, ds, force, friction, memory_now in steps:
                expected, shear, contact = update(contact, gap, k_hat, ds, slow)
                assert abs(force - expected) < 1e-12 * scale
                assert np.abs(friction - shear).max() < 1e-10 * scale
                assert abs(memory_now[3] - np.linalg.norm(shear)) < 1e-10 * scale
                assert abs(memory_now[4] * force - contact.turning_point) < 1e-10 * scale
                assert memory_now[5] == (contact.sense < 0)
                assert abs(memory_now[6] - contact.largest_overlap) < 1e-12 * 1e-5


def test_histories_visit_sticking_sliding_reversal_and_forceless_contact():
    """What the comparison above is worth: the branches of the law that its paths reach."""
    law, sliding_steps, sticking_steps, falling_steps, forceless_steps, open_steps = (
        sphere_law(),
        0,
        0,
        0,
        0,
        0,
    )
    for slip_size in (1e-8, 2e-7, 2e-6):
        overlap, normal, slip = history(0, slip_size)
        open_steps += (overlap <= 0).sum()
        for closed in closed_stretches(overlap):
            force, friction, memory_now = contact_path(
                law, overlap[closed], normal[closed], slip[closed]
            )
            size = np.linalg.norm(friction, axis=1)
            sliding_steps += ((size > 0.4 * force * (1 - 1e-9)) & (force > 0)).sum()
            sticking_steps += (size < 0.39 * force).sum()
            falling_steps += (memory_now[:, 5] == 1).sum()
            forceless_steps += (force == 0).sum()
    assert min(sliding_steps, sticking_steps, falling_steps, forceless_steps, open_steps) > 20
