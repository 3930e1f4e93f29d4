"""Beads without rotation in motion: impacts, momentum, neighbor list, integrators, how it stops."""

import numpy as np
import pytest

from sim.engine.boundary.belt import Belt
from sim.engine.dynamics.cells import NOT_FINITE, OK, OVERLAP
from sim.engine.dynamics.disks import Gear, Verlet
from sim.engine.systems import shaking
from tests.engine_motion.disks import DiskMotion
from tests.engine_motion.helpers import (
    BEAD,
    BEAD_GRAVITY,
    BEAD_MASS,
    DAMPING,
    YOUNG,
    bead_law,
    lattice,
    wrapped,
)
from tests.engine_motion.points import belt_point

INTEGRATORS = [Gear, Verlet]
REDUCED = {"damping_mass": "reduced", "attraction": "clipped"}
SPEED = 0.1
FAR = 30 * BEAD


def impact_restitution(
    law, integrator, time_step=1e-6, sizes=(1.0, 1.0), gap=0.3, corrections=1
) -> float:
    """Restitution of two beads that meet head-on, ``gap`` steps after the start."""
    diameter = BEAD * np.array(sizes)
    distance = diameter.mean() + gap * SPEED * time_step
    place = [[5 * BEAD, FAR], [5 * BEAD + distance, FAR]]
    mass = BEAD_MASS * np.array(sizes) ** 2
    options = {"radius": 0.5 * diameter, "mass": mass, "time_step": time_step}
    options |= {"law": law, "integrator": integrator, "corrections": corrections}
    motion = DiskMotion(place, [[SPEED / 2, 0], [-SPEED / 2, 0]], **options)
    motion.run(int(1.5e-3 / time_step))
    return float(motion.velocity[1, 0] - motion.velocity[0, 0]) / SPEED


def damped_restitution(rate: float, frequency_squared: float) -> float:
    return float(np.exp(-np.pi * rate / np.sqrt(frequency_squared - rate**2)))


def clipped_restitution(rate: float, frequency_squared: float) -> float:
    """Restitution of a contact that ends where spring and damping cancel.

    x = sin(wt) exp(-eta t) lets go where w0^2 x + 2 eta x' = 0; from there the beads fly free. That
    is at w t = pi - atan2(2 eta w, w^2 - eta^2), with the speed exp(-eta t).
    """
    frequency = np.sqrt(frequency_squared - rate**2)
    release = np.pi - np.arctan2(2 * rate * frequency, frequency**2 - rate**2)
    return float(np.exp(-rate / frequency * release))


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_pair_restitution_is_that_of_a_damped_oscillator(integrator):
    """eta = gamma with the own mass of equal beads."""
    expected = damped_restitution(DAMPING, 2 * YOUNG / BEAD_MASS)
    assert impact_restitution(bead_law(), integrator) == pytest.approx(expected, abs=1e-3)
    assert expected == pytest.approx(0.70, abs=5e-3)


@pytest.mark.parametrize("sizes", [(1.0, 1.0), (0.6, 1.4)])
def test_with_the_reduced_mass_half_the_rate_damps_and_a_clipped_contact_ends_earlier(sizes):
    """The relative motion has the spring's frequency Y/m* and the rate gamma/2."""
    masses = BEAD_MASS * np.array(sizes) ** 2
    oscillator = DAMPING / 2, YOUNG * (1 / masses).sum()
    assert impact_restitution(bead_law(**REDUCED), Verlet, sizes=sizes) == pytest.approx(
        clipped_restitution(*oscillator), abs=1e-3
    )
    assert clipped_restitution(*oscillator) > damped_restitution(*oscillator) + 2e-3


def test_damping_that_goes_with_the_root_of_the_stiffness_keeps_the_restitution():
    """Of all pairs, as rate over frequency stays; at a fixed rate it rises with the stiffness."""
    for sizes in ((1.0, 1.0), (0.6, 1.4)):
        usual = impact_restitution(bead_law(), Gear, sizes=sizes)
        for factor in (0.7, 5.0):
            p = belt_point(stiffness=1e3 * factor, stiffness_keeps="restitution")
            law = bead_law(stiffness=factor * YOUNG, damping=p.normal_damping)
            assert impact_restitution(law, Gear, sizes=sizes) == pytest.approx(usual, abs=1e-3)
        assert impact_restitution(bead_law(stiffness=5 * YOUNG), Gear, sizes=sizes) > usual + 0.1


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_restitution_at_the_published_step_is_within_two_percent(integrator):
    """Damping jumps where contacts begin and end: an error of first order for any integrator."""
    exact = damped_restitution(DAMPING, 2 * YOUNG / BEAD_MASS)
    errors = []
    for time_step in (2.5e-5, 2.5e-6):
        gaps = np.linspace(0.05, 0.95, 12)
        errors.append(
            max(
                abs(impact_restitution(bead_law(), integrator, time_step, gap=g) - exact)
                for g in gaps
            )
        )
    assert errors[0] < 0.02
    assert errors[1] < 0.25 * errors[0]


def crowd(seed=8, base=FAR, shape=(5, 4), **options) -> DiskMotion:
    """A polydisperse cluster of touching beads in a cell as wide as it."""
    rng = np.random.default_rng(seed)
    position = lattice(shape, BEAD, 0.1, rng, base)
    radius = 0.5 * BEAD * rng.uniform(0.5, 1.5, len(position))
    mass = BEAD_MASS * (2 * radius / BEAD) ** 2
    velocity = rng.normal(0, SPEED, position.shape)
    options = {"width": shape[0] * BEAD, "radius": radius, "mass": mass} | options
    return DiskMotion(position, velocity, **options)


@pytest.mark.parametrize("shear", [0.0, DAMPING])
def test_reduced_mass_conserves_the_momentum_of_free_beads(shear):
    motion = crowd(law=bead_law(shear_damping=shear, **REDUCED), integrator=Verlet)
    before, scale = motion.mass @ motion.velocity, motion.mass.sum() * SPEED
    assert np.abs(motion.run(400).mass @ motion.velocity - before).max() < 1e-12 * scale
    own_mass = crowd(law=bead_law(shear_damping=shear), integrator=Verlet).run(400)
    assert np.abs(own_mass.mass @ own_mass.velocity - before).max() > 1e-3 * scale


def test_a_free_cluster_of_beads_loses_energy_with_the_reduced_mass():
    """With the own mass there is no such law: its forces do not even conserve momentum."""
    motion = crowd(law=bead_law(**REDUCED), integrator=Verlet)

    def energy():
        moving = 0.5 * (motion.mass[:, None] * motion.velocity**2).sum()
        difference = motion.position[None] - motion.position[:, None]
        distance = np.linalg.norm(wrapped(difference.reshape(-1, 2), 5 * BEAD, 0.0), axis=1)
        reach = np.add.outer(motion.radius, motion.radius).ravel()
        overlap = np.where(distance > 0, np.clip(reach - distance, 0, None), 0)
        return moving + 0.25 * YOUNG * (overlap**2).sum()

    levels = [energy()]
    for _ in range(30):
        motion.run(10)
        levels.append(energy())
    assert np.diff(levels).max() < 1e-4 * levels[0]
    assert levels[-1] < 0.6 * levels[0]


@pytest.mark.parametrize("base", [FAR, -0.4 * BEAD])
def test_skin_changes_the_trajectory_by_rounding_only(base):
    options = {"base": base, "gravity": BEAD_GRAVITY, "belt": Belt(BEAD, BEAD, 200.0, 0.3, 0.0)}
    thin, thick = (crowd(skin=skin, room=60, **options).run(300) for skin in (1e-6, 0.9e-3))
    difference = wrapped(thin.position - thick.position, 5 * BEAD, 0.0)
    assert np.abs(difference).max() < 1e-10 * BEAD
    assert thin.velocity == pytest.approx(thick.velocity, abs=1e-9 * SPEED)


def test_a_list_that_grows_gives_the_same_bits_as_one_with_room():
    options = {"shape": (7, 6), "gravity": BEAD_GRAVITY, "corrections": 2}
    tight, roomy = (crowd(base=0.0, room=room, **options) for room in (0, 60))
    capacity = tight.pairs.second.size
    tight.run(1500)
    roomy.run(1500)
    assert tight.pairs.second.size > capacity
    assert np.array_equal(tight.taylor, roomy.taylor)
    assert np.array_equal(tight.loop.sums, roomy.loop.sums)


def test_gear_and_verlet_agree_as_the_time_step_falls():
    belt = Belt(BEAD, BEAD, 2 * np.pi * 20, 0.0, 0.0)
    difference = []
    for time_step in (2e-5, 2e-6):
        options = {"time_step": time_step, "base": -0.4 * BEAD, "belt": belt}
        ends = [
            crowd(integrator=kind, gravity=BEAD_GRAVITY, **options).run(int(1e-3 / time_step))
            for kind in INTEGRATORS
        ]
        difference.append(np.abs(ends[0].position - ends[1].position).max())
    assert difference[0] < 1e-2 * BEAD
    assert difference[1] < 0.2 * difference[0]


def test_an_overlap_beyond_the_limit_and_what_is_not_finite_stop_a_run_at_their_step():
    limit = 0.999 * crowd().run(200).loop.sums[shaking.LARGEST]
    stopped_motion = crowd(overlap_limit=limit)
    assert stopped_motion.advance(200) == OVERLAP
    before = crowd(overlap_limit=limit)
    assert before.advance(stopped_motion.loop.step[0] - 1) == OK
    for bad, term in ((np.nan, 0), (np.inf, 1)):
        motion = crowd().run(5)
        motion.disks.taylor[term, 1, 7] = bad
        assert motion.advance(200) == NOT_FINITE and motion.loop.step[0] < 200
