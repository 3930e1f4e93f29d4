"""First stage: single impacts and a few particles, the same trajectories in both engines."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from benchmarks.crosscheck.engines import synchronised
from benchmarks.crosscheck.impact import LAMMPS, TALUS, Convention, impact
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

IMPACTS = [(e, slope) for e in RESTITUTIONS for slope in SLOPES]

#: Depth of the flow, of which the particles are what collides, and the spread of their diameters.
PARTNERS = {"plane": (0.01, 0.0), "pair": (0.02, 0.0), "unlike pair": (0.02, 0.5)}

#: Commands of LAMMPS, changed for a point.
Edit = Callable[[ChuteParameters, str], str]

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


def both(
    client: Client, p: ChuteParameters, position=None, velocity=None, edit: Edit | None = None
) -> list[Motion]:
    """Return the state after one sample interval in Talus and in LAMMPS.

    The random packing may be replaced by positions and velocities (N, 3) in natural units. No
    particles may touch at first; velocities are right for those that touch no other at the end.
    """
    system = build(p, 0)
    if position is not None:
        place = np.argsort(system.spheres.label[0])
        system.spheres.position[:, place] = position.T * p.diameter
        system.spheres.velocity[:, place] = velocity.T * p.velocity_unit
    snapshot, settings = synchronised(p, system.snapshot()), Settings(every=1)
    request = chute_request(p, snapshot, settings)
    if edit is not None:
        request["after"] = edit(p, "\n".join(request["after"])).split("\n")
    client.setup(request, chute_state(p, snapshot, settings))
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


def rebound(
    client: Client, partner: str, slope: float, edit: Edit | None = None, **values
) -> Apart:
    """Let a sphere hit its partner, moving ``slope`` times as fast across the normal as along."""
    depth, spread = PARTNERS[partner]
    collisions = 3 * values.get("steps_per_collision", 40)
    p = parameters(collisions, depth=depth, diameter_spread=spread, gravity=GRAVITY, **values)
    radii = build(p, 0).snapshot()["radius"] / p.diameter
    # How much of the motion relative to the partner is whose, in the frame of the centre of mass.
    share = np.array([1.0, -((radii[0] / radii[1]) ** 3)]) if len(radii) == 2 else np.ones(1)
    share /= share[0] - share[1:].sum()
    velocity = SPEED * np.array([0.8 * slope, 0.6 * slope, -1.0])
    above = np.array([0.0, 0.0, radii.sum() + 0.1 * SPEED * p.time_step / p.time_unit])
    centre = np.array([5.0, 5.0, 5.0 if len(radii) == 2 else 0.0])
    motions = both(client, p, centre + share[:, None] * above, share[:, None] * velocity, edit)
    ours, theirs = (_outgoing(motion, radii) for motion in motions)
    whole, part = (
        _plain(p, radii, share[0] * above, share[0] * velocity, convention)
        for convention in (TALUS, LAMMPS[p.law])
    )
    return Apart(
        _largest(ours - theirs),
        _largest(ours - whole),
        _largest(theirs - part),
        abs(ours[2] / (share[0] * SPEED) - p.restitution),
    )


def _outgoing(motion: Motion, radii: np.ndarray) -> np.ndarray:
    """Return the first sphere's velocity, for a pair in its own frame, and rims' velocities."""
    mean = radii**3 @ motion.velocity / (radii**3).sum() if len(radii) == 2 else 0.0
    return np.concatenate([motion.velocity[0] - mean, (radii[:, None] * motion.spin).ravel()])


def _plain(p: ChuteParameters, radii, position, velocity, convention: Convention) -> np.ndarray:
    position, velocity = position * p.diameter, velocity * p.velocity_unit
    velocity, spin = impact(p, radii * p.diameter, position, velocity, p.sample_steps, convention)
    rims = (radii[:, None] * spin).ravel()
    return np.concatenate([velocity / p.velocity_unit, rims * p.time_unit])


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


def rebound_checks(
    client: Client, partner: str, allowed: float, impacts: list[tuple[float, float]], **values
) -> list[Check]:
    """Return what impacts with these restitutions and slopes give at most."""
    every = [rebound(client, partner, slope, restitution=e, **values) for e, slope in impacts]
    head_on = max(
        apart.restitution for apart, (_, slope) in zip(every, impacts, strict=True) if not slope
    )
    worst = Apart(*(max(values) for values in zip(*every, strict=True)))
    name = f"{values['law']}, {partner}" if "law" in values else partner
    return [
        Check(f"{name}: restitution, from the one asked for", head_on, RESTITUTION),
        Check(f"{name}: rebound, Talus from LAMMPS", worst.engines, allowed),
        Check(f"{name}: rebound, Talus from plain Python", worst.ours, ROUNDING),
        Check(f"{name}: rebound, LAMMPS from plain Python", worst.theirs, ROUNDING),
    ]


def checks(client: Client) -> list[Check]:
    """Return what single impacts and a few particles give with ``spring_dashpot``."""
    smooth = drift_apart(client, friction=0, friction_plane=0.4)
    return [
        *rebound_checks(client, "pair", TURNING, IMPACTS),
        *rebound_checks(client, "plane", ROUNDING, IMPACTS),
        Check(f"50 particles, {STEPS} steps, friction with the plane only", smooth, ROUNDING),
        Check(f"50 particles, {STEPS} steps, friction", drift_apart(client), TURNING),
    ]
