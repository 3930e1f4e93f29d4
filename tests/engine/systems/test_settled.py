"""Beds that settle once: the same bits as those that settle anew, whatever a point changes."""

from typing import get_args

import numpy as np
import pytest

from sim.engine.dynamics.cells import BlowUp
from sim.engine.states import flatten
from sim.engine.systems import belt, build, start
from sim.parameters import BeltParameters
from tests.engine_motion.points import belt_point

SMALL = {"beads": 6, "width": 8.0, "settle_velocity_squared": 1e-4, "prior_cycles": 1}

#: Other values where three quarters of the usual one is none.
OTHER = {"corrector_order": 4, "corrections": 2, "prior_frequency": 30.0, "samples_per_cycle": 10}
OTHER |= dict.fromkeys(("obstacle", "initial_velocity", "trajectory", "phase"), 1.5)
OTHER |= dict.fromkeys(("seed", "replicates", "prior_cycles", "slice_height"), 2)

#: What a point has beside the parameter that it changes; only laws that golden points have, too.
REDUCED = {"damping_mass": "reduced", "attraction": "clipped", "integrator": "verlet"}
BESIDE = {"ghost_mass": REDUCED, "stiffness_keeps": {"stiffness": 500.0}}
BESIDE |= {"trajectory_contacts": {"trajectory": 1.5}, "attraction": {"integrator": "verlet"}}

#: Parameters that change together.
TOGETHER = {"attraction": REDUCED}

#: Parameters that the bed does not know, as their effect begins with the shaking.
SHAKING = {"frequency", "vibration_angle", "initial_velocity", "prior_frequency", "prior_cycles"}
SHAKING |= {"steps_per_cycle", "samples_per_cycle", "slice_height", "transient", "average", "limit"}
SHAKING |= {"phase_0_profiles", "fluctuation_profiles", "belt_forces", "trajectory"}
SHAKING |= {"protocol", "target", "replicates", "trajectory_contacts"}

NAMES = [*BeltParameters.model_fields.keys() - {"system", "start_from", "damping_mass"}]


@pytest.fixture(autouse=True)
def _no_beds():
    start.beds.clear()


def other_value(name):
    """Return a value of a parameter that its points usually do not have."""
    field = BeltParameters.model_fields[name]
    usual = SMALL.get(name, field.default)
    if choices := get_args(field.annotation):
        return next(choice for choice in choices if choice != usual)
    if isinstance(usual, bool):
        return not usual
    return OTHER.get(name) or type(usual)(0.75 * usual)


def settled_state(**values):
    """Return all that moves in a point, by name, when the shaking starts."""
    system = build(belt_point(**SMALL | values), 0)
    system.settle()
    return flatten({name: getattr(system, name) for name in system.state_names})


@pytest.mark.parametrize("name", sorted(NAMES))
def test_a_bed_is_shared_where_it_would_be_the_same_to_the_bit(name):
    beside = BESIDE.get(name, {})
    changed = beside | TOGETHER.get(name, {name: other_value(name)})
    anew = settled_state(**changed)
    start.beds.clear()
    first = settled_state(**beside)
    for values, expected in ((changed, anew), (beside, first)):
        state = settled_state(**values)
        assert state.keys() == expected.keys()
        for path, value in state.items():
            assert np.array_equal(value, expected[path], equal_nan=True), path
    assert len(start.beds) == (1 if name in SHAKING else 2)


def test_beds_of_replicates_and_time_steps_are_their_own():
    beds = [build(belt_point(**SMALL), *which) for which in ((0,), (1,), (0, 2))]
    for bed in beds:
        bed.settle()
    assert len(start.beds) == 3


def test_a_shared_bed_moves_alone():
    first, second = (build(belt_point(**SMALL), 0) for _ in range(2))
    first.settle()
    first.sample(5)
    second.settle()
    assert np.array_equal(settled_state()["disks.taylor"], flatten(second.disks)["taylor"])


def test_memory_is_bounded_and_the_oldest_bed_goes(monkeypatch):
    settled_state(seed=1)
    monkeypatch.setattr(start, "ROOM", int(2.5 * start._size(*start.beds.values())))
    settled_state(seed=2)
    kept = set(start.beds)
    settled_state(seed=1)
    settled_state(seed=3)
    assert len(start.beds) == 2 and len(kept & set(start.beds)) == 1


def test_a_bed_that_fails_is_not_kept(monkeypatch):
    monkeypatch.setattr(belt, "SETTLING_LIMIT", 0.0)
    for _ in range(2):
        with pytest.raises(BlowUp, match="the bed is not at rest"):
            settled_state()
    assert not start.beds
