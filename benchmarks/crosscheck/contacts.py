"""First stage: single impacts and a few particles, the same trajectories in both engines."""

from typing import NamedTuple

import numpy as np

from benchmarks.crosscheck.engines import synchronised
from benchmarks.crosscheck.impact import impact
from benchmarks.peers.chute_input import chute_request, chute_state
from benchmarks.peers.client import Client
from benchmarks.peers.settings import Settings
from sim.engine.systems import build
from sim.parameters import ChuteParameters, parse_point

#: Gravity (m/s²) and speed (√(gσ)) of the test impacts, for the weight to matter little.
GRAVITY, SPEED = 0.098, 50.0

#: Velocity across the normal over that along it: head-on first, then from sticking to sliding.
SLOPES = [0.0, 0.3, 1.0, 4.0]

RESTITUTIONS = [0.7, 0.85, 0.95]

#: Steps of the few particles, in which each collides several times.
STEPS = 600

#: Largest error of a single impact's restitution (the time step makes it: the drag acts in whole
#: steps), largest difference where both engines do the same arithmetic in another order, and where
#: pairs turn their friction in the one way or the other.
RESTITUTION, ROUNDING, TURNING = 0.01, 1e-9, 1e-4


class Motion(NamedTuple):
    """Positions, velocities and spins (N, 3) in natural units."""

    position: np.ndarray
    velocity: np.ndarray
    spin: np.ndarray


class Apart(NamedTuple):
    """Differences after an impact of velocity and rim velocity, over the speed.

    Between the engines; of each from the impact in plain Python, done its way; and of the
    restitution along the normal from the one asked for.
    """

    engines: float
    ours: float
    theirs: float
    restitution: float


class Check(NamedTuple):
    """A number that was found, and the largest that is allowed."""

    name: str
    found: float
    allowed: float

    @property
    def holds(self) -> bool:
        """Whether it is small enough."""
        return self.found <= self.allowed

    def __str__(self) -> str:
        return f"{self.name:62}{self.found:9.1e}, at most {self.allowed:.0e}"


def parameters(steps: int, **values) -> ChuteParameters:
    """Return a point of which one sample interval is ``steps`` long."""
    shared = {"system": "chute", "law": "spring_dashpot", "tangential_ratio": 2 / 7}
    p = parse_point({**shared, "angle": 0, "stiffness": 117, **values}, "contacts")
    return p.model_copy(update={"sample_interval": steps * p.time_step / p.time_unit})


def both(client: Client, p: ChuteParameters, position=None, velocity=None) -> list[Motion]:
    """Return the state after one sample interval in Talus and in LAMMPS.

    The random packing may be replaced by positions and velocities (N, 3) in natural units. No
    particles may touch at first; velocities are right for those that touch no other at the end.
    """
    system = build(p, 0)
    if position is not None:
        system.spheres.position[:] = position.T * p.diameter
        system.spheres.velocity[:] = velocity.T * p.velocity_unit
    snapshot, settings = synchronised(p, system.snapshot()), Settings(every=1)
    client.setup(chute_request(p, snapshot, settings), chute_state(p, snapshot, settings))
    client.ask("run", steps=p.sample_steps)
    theirs = {key: np.array(value) for key, value in client.ask("snapshot").items()}
    system.advance()
    ours = synchronised(p, system.snapshot())
    return [
        _natural(p, ours["position"], ours["particle_velocity"], ours["particle_spin"]),
        _natural(p, theirs["position"], theirs["velocity"], theirs["spin"]),
    ]


def _natural(p: ChuteParameters, position, velocity, spin) -> Motion:
    return Motion(position / p.diameter, velocity / p.velocity_unit, spin * p.time_unit)


def rebound(client: Client, partner: str, restitution: float, slope: float) -> Apart:
    """Let a sphere hit its partner, moving ``slope`` times as fast across the normal as along."""
    pair = partner == "pair"
    values = {"restitution": restitution, "depth": 0.02 if pair else 0.01, "gravity": GRAVITY}
    p = parameters(120, **values)
    speed, step = (0.5 if pair else 1.0) * SPEED, p.time_step / p.time_unit
    velocity = speed * np.array([0.8 * slope, 0.6 * slope, -1.0])
    above = np.array([0.0, 0.0, 0.5 + 0.1 * speed * step])
    sign = np.array([[1.0], [-1.0]]) if pair else np.array([[1.0]])
    centre = np.array([5.0, 5.0, 5.0 if pair else 0.0])
    motions = both(client, p, centre + sign * above, sign * velocity)
    ours, theirs = (_outgoing(motion, pair) for motion in motions)
    whole, part = (_plain(p, partner, above, velocity, rescaled) for rescaled in (True, False))
    return Apart(
        _largest(ours - theirs),
        _largest(ours - whole),
        _largest(theirs - part),
        abs(ours[2] / speed - restitution),
    )


def _outgoing(motion: Motion, pair: bool) -> np.ndarray:
    """Return velocity and rim velocity of the first sphere; those of a pair in its own frame."""
    velocity = motion.velocity[0] - (motion.velocity.mean(axis=0) if pair else 0.0)
    return np.concatenate([velocity, 0.5 * motion.spin[0]])


def _plain(p: ChuteParameters, partner: str, position, velocity, rescaled: bool) -> np.ndarray:
    position, velocity = position * p.diameter, velocity * p.velocity_unit
    velocity, spin = impact(p, partner, position, velocity, p.sample_steps, rescaled)
    return np.concatenate([velocity / p.velocity_unit, 0.5 * spin * p.time_unit])


def _largest(difference: np.ndarray) -> float:
    return float(np.abs(difference).max()) / SPEED


def drift_apart(client: Client, **values) -> float:
    """Return the largest distance (diameters) between the positions of 50 particles' two motions.

    A hot gas that falls onto the sloping plane, from one random packing.
    """
    steep = {"angle": 17, "depth": 2, "cell": 5, "initial_agitation": 4, "restitution": 0.85}
    p = parameters(STEPS, **steep, **values)
    ours, theirs = both(client, p)
    apart = ours.position - theirs.position
    apart[:, :2] -= p.cell * np.round(apart[:, :2] / p.cell)
    return float(np.abs(apart).max())


def rebound_checks(client: Client, partner: str, allowed: float) -> list[Check]:
    """Return what impacts at all restitutions and slopes give at most."""
    impacts = [(e, slope) for e in RESTITUTIONS for slope in SLOPES]
    every = [rebound(client, partner, *values) for values in impacts]
    head_on = max(apart.restitution for apart in every[:: len(SLOPES)])
    worst = Apart(*(max(values) for values in zip(*every, strict=True)))
    return [
        Check(f"{partner}: restitution, from the one asked for", head_on, RESTITUTION),
        Check(f"{partner}: rebound, Talus from LAMMPS", worst.engines, allowed),
        Check(f"{partner}: rebound, Talus from plain Python", worst.ours, ROUNDING),
        Check(f"{partner}: rebound, LAMMPS from plain Python", worst.theirs, ROUNDING),
    ]


def checks(client: Client) -> list[Check]:
    """Return what single impacts and a few particles give."""
    smooth = drift_apart(client, friction=0, friction_plane=0.4)
    return [
        *rebound_checks(client, "pair", TURNING),
        *rebound_checks(client, "plane", ROUNDING),
        Check(f"50 particles, {STEPS} steps, friction with the plane only", smooth, ROUNDING),
        Check(f"50 particles, {STEPS} steps, friction", drift_apart(client), TURNING),
    ]
