"""Judges of Walton's claims about the model: small experiments that need no study."""

from collections.abc import Callable, Mapping
from itertools import pairwise
from typing import Any

import numpy as np
from uncertainties import ufloat

from sim.claims.checks import Numbers, Pair, above, below, within
from sim.claims.experiments import contact_path, random_curve, vector_spring
from sim.claims.verdict import Check
from sim.engine.boundary.drive import Gravity
from sim.engine.contact import Partners, law_of
from sim.engine.contact.walton_braun import WaltonBraun
from sim.engine.systems.chute import Chute
from sim.parameters import ChuteParameters

#: Speeds of the impacts (m/s), and numbers of steps from their start to the contact.
SPEEDS = np.geomspace(1e-3, 1.0, 8)
PHASES = np.array([0.1, 0.3, 0.6, 0.9])

#: Distance of impact sites in diameters, and their number in a row.
SPACING, WIDTH = 4.0, 6

#: Exponents of the tangential stiffness; the law softens with all of them.
EXPONENTS = (1 / 3, 1.0, 2.0)

#: Overlap (m) of single contacts, steps of a leg of a loop, and small slips over μF_N/K0.
OVERLAP, LEG, SLIP = 1e-5, 20_000, 1e-3

#: For each kind of normal force: steps of a random path and swing of ln F_N. Where the force falls,
#: the engine also cuts the friction before the slip; the error of that is of first order in the
#: step.
FORCES = (("constant", 2000, 0.0), ("varying", 24_000, 0.7))

#: Samples of the two flows that are compared bit by bit.
SAMPLES = 40

Change = Callable[[Chute], None]
Path = Callable[..., tuple[np.ndarray, ...]]
Reading = Mapping[str, Any]

#: The defaults of all readings.
NO_READING: Reading = {}


def w1(
    reading: Reading = NO_READING,
    change: Change | None = None,
    *,
    max_error: float,
    restitutions: Numbers,
) -> list[Check]:
    """Impacts of pairs and on the plane at three decades of speed: error and trend of e.

    Both must be below ``max_error`` at all ``restitutions``. ``reading`` holds parameters of the
    law that differ from their defaults, as for all judges of this module. ``change`` modifies the
    chute in which the impacts happen.
    """
    checks = []
    for partner in ("pairs", "plane"):
        errors = np.array([_restitutions(e, partner, reading, change) - e for e in restitutions])
        largest = float(np.abs(errors).max())
        checks.append(below(f"largest |e - √(K1/K2)|, {partner}", largest, max_error))
        decades = np.broadcast_to(np.log10(SPEEDS)[:, None], errors.shape)
        line, covariance = np.polyfit(decades.ravel(), errors.ravel(), 1, cov=True)
        trend = ufloat(line[0], covariance[0, 0] ** 0.5) * np.ptp(np.log10(SPEEDS))
        quantity = f"change of e over three decades of speed, {partner}"
        checks.append(within(quantity, trend, -max_error, max_error))
    return checks


def w2(
    reading: Reading = NO_READING,
    path: Path = contact_path,
    *,
    max_error: float,
    peak: float,
    max_jump: float,
) -> list[Check]:
    """Friction of one contact under a fixed normal force: first slip to sliding, then loops.

    ``path`` follows a contact along a path as `sim.claims.experiments.contact_path` does. Loops
    reach ``peak`` (μF_N) either way, and ``max_jump`` is the largest jump of K_T/K0 within them.
    """
    checks = []
    for exponent in EXPONENTS:
        law, label = _law(reading, tangential_exponent=exponent), f"γ = {exponent:.3g}"
        friction, stiffness = _first_slip(law, path)
        error = np.abs(stiffness - (1 - friction) ** exponent).max()
        checks.append(below(f"largest |K_T/K0 - (1 - T/μF_N)^γ|, {label}", float(error), max_error))
        sliding = float(_straight_path(law, np.array([1e3, 1e3 + 1e-3]), path)[1])
        checks.append(
            within(f"T/μF_N at full sliding, {label}", sliding, 1 - max_error, 1 + max_error)
        )
        gap, jump = _loop(law, path, peak)
        checks.append(below(f"opening of a loop over μF_N, {label}", gap, max_error))
        checks.append(below(f"largest jump of K_T/K0 between its turns, {label}", jump, max_jump))
    return checks


def w3(
    reading: Reading = NO_READING, path: Path = contact_path, *, paths: int, max_error: float
) -> list[Check]:
    """Compare γ = 0 and Cundall and Strack's spring on random paths; ``path`` as for `w2`."""
    checks = []
    for force, steps, swing in FORCES:
        differences = [
            _spring_difference((seed, seed + paths), steps, swing, reading, path)
            for seed in range(paths)
        ]
        quantity = f"largest difference over μF_N on {paths} paths, {force} F_N"
        checks.append(below(quantity, max(differences), max_error))
    return checks


def w4(
    reading: Reading = NO_READING, chute: Callable[[ChuteParameters, int], Chute] = Chute
) -> list[Check]:
    """One flow with and without orientations: numbers of its last state, and distance travelled.

    ``chute`` creates the system.
    """
    states = []
    for orientations in (True, False):
        p = ChuteParameters(depth=2.5, cell=5, orientations=orientations, **reading)
        flow = chute(p, 0)
        for _ in range(SAMPLES):
            flow.advance()
        states.append(flow.snapshot())
    names = ("position", "particle_velocity", "particle_spin")
    unequal = sum(int((states[0][name] != states[1][name]).sum()) for name in names)
    return [
        below("numbers of the last state that differ", unequal, 0.5),
        above(
            "mean distance travelled meanwhile",
            flow.travelled / flow.parameters.diameter,
            10,
            unit="σ",
        ),
    ]


def _restitutions(
    restitution: float, partner: str, reading: Reading, change: Change | None
) -> np.ndarray:
    """Return the restitutions (speed, phase) of impacts, all in one cell without weight."""
    speed, phase = (grid.ravel() for grid in np.meshgrid(SPEEDS, PHASES, indexing="ij"))
    number, cell = speed.size, WIDTH * SPACING
    particles = 2 * number if partner == "pairs" else number
    depth = particles / cell**2
    p = ChuteParameters(depth=depth, cell=cell, restitution=restitution, **reading)
    chute = Chute(p, 0)
    chute.drive = Gravity((0.0, 0.0, 0.0))
    if change:
        change(chute)
    axis, position, velocity = _before_impact(partner, speed, phase * speed * chute.time_step)
    chute.spheres.position[:], chute.spheres.velocity[:] = position.T, velocity.T
    chute.sample_steps = 3 * chute.parameters.steps_per_collision
    chute.advance()
    after = chute.snapshot()["particle_velocity"]
    separation = after[number:] - after[:number] if partner == "pairs" else after
    return -((separation * axis).sum(axis=1) / speed).reshape(SPEEDS.size, PHASES.size)


def _before_impact(partner: str, speed: np.ndarray, gap: np.ndarray) -> tuple[np.ndarray, ...]:
    """Return unit vectors of approach (M, 3), positions and velocities of the spheres (N, 3).

    Pairs meet high above the plane. All first spheres come before all second ones.
    """
    size, site = ChuteParameters().diameter, np.arange(speed.size)
    center = SPACING * size * np.column_stack([site % WIDTH, site // WIDTH, 0 * site])
    speed, gap = speed[:, None], gap[:, None]
    if partner == "plane":
        axis = np.tile([0.0, 0.0, -1.0], (len(speed), 1))
        return axis, center - (0.5 * size + gap) * axis, speed * axis
    axis = np.random.default_rng(1).normal(size=center.shape)
    axis /= np.linalg.norm(axis, axis=1)[:, None]
    center[:, 2] = SPACING * size
    half, velocity = 0.5 * (size + gap) * axis, 0.5 * speed * axis
    return axis, np.vstack([center + half, center - half]), np.vstack([-velocity, velocity])


def _law(reading: Reading, **changes: float) -> WaltonBraun:
    values: dict[str, Any] = {**changes, **reading}
    p = ChuteParameters(**values)
    return law_of(p, Partners(p.friction, 0.5 * p.mass, p.time_step))


def _straight_path(law: WaltonBraun, position: np.ndarray, path: Path) -> np.ndarray:
    """Return T/μF_N (n,) along a straight path of positions (n,) in μF_N/K0, from 0."""
    limit = law.limit.friction * law.loading * OVERLAP
    slip = np.zeros((position.size, 3))
    slip[:, 0] = np.diff(position, prepend=0.0) * limit / law.tangential
    normal = np.tile([0.0, 0.0, 1.0], (position.size, 1))
    return path(law, np.full(position.size, OVERLAP), normal, slip)[1][:, 0] / limit


def _first_slip(law: WaltonBraun, path: Path) -> tuple[np.ndarray, np.ndarray]:
    """Return T/μF_N before each of many small slips until sliding, and K_T/K0 during it."""
    step = SLIP
    friction = _straight_path(law, step * np.arange(1, 20 * LEG // 4), path)
    sticking = friction[:-1] < 1 - 2 * step
    return friction[:-1][sticking], (np.diff(friction) / step)[sticking]


def _loop(law: WaltonBraun, path: Path, peak: float) -> Pair:
    """Return the largest opening of loops between ±peak μF_N, and the largest jump of K_T/K0."""
    rise, width = _path_length(law, peak, 1.0), _path_length(law, 2 * peak, 1.0 + peak)
    corners = np.array([0.0, rise, rise - width, rise, rise - width])
    legs = [np.linspace(*ends, LEG + 1)[1:] for ends in pairwise(corners)]
    friction = _straight_path(law, np.concatenate(legs), path).reshape(len(legs), LEG)
    opening = max(np.abs(friction[1] - friction[3]).max(), np.abs(friction[1] + friction[2]).max())
    half_loops = np.column_stack([friction[:-1, -1], friction[1:]])
    stiffness = np.abs(np.diff(half_loops, axis=1)) * LEG / width
    deviation = np.abs(stiffness[:, 0] - 1).max()
    return float(opening), float(max(np.abs(np.diff(stiffness, axis=1)).max(), deviation))


def _path_length(law: WaltonBraun, drop: float, available: float) -> float:
    """Return the path (μF_N/K0) on which T/μF_N changes by ``drop``, ``available`` from sliding."""
    power = 1.0 - law.stiffening.exponent
    rest = 1.0 - drop / available
    return -available * np.log(rest) if power == 0 else available / power * (1 - rest**power)


def _spring_difference(
    seeds: tuple[int, int], steps: int, swing: float, reading: Reading, path: Path
) -> float:
    """Return the largest difference from the spring over μF_N along a random path.

    The seeds are those of the path and of the normal force. An elastic law makes the normal force
    proportional to the overlap, so any F_N can be prescribed.
    """
    law = _law(reading, restitution=1.0, tangential_exponent=0.0)
    force, friction = law.loading * OVERLAP, law.limit.friction
    position = 3.0 * friction * force / law.tangential * random_curve(seeds[0], steps)
    slip = np.zeros((steps, 3))
    slip[:, :2] = np.diff(position, axis=0)
    normal_force = force * np.exp(swing * random_curve(seeds[1], steps)[1:, 0])
    normal = np.tile([0.0, 0.0, 1.0], (steps, 1))
    tangential = path(law, normal_force / law.loading, normal, slip)[1][:, :2]
    expected = vector_spring(slip[:, :2].copy(), normal_force, law.tangential, friction)
    return float((np.linalg.norm(tangential - expected, axis=1) / (friction * normal_force)).max())
