"""Judges of claims about the bed over height: density, velocity, agitation, snapshots."""

from math import nan

import numpy as np
import pytest

from sim.claims.verdict import RISK
from sim.papers.gallas.judges.density import (
    compare_differences,
    g15,
    g16,
    g17,
    g18,
    g19,
    g20,
    plateau_end,
)
from sim.papers.gallas.judges.snapshots import g26, g27, g28
from sim.papers.gallas.judges.velocity import g21, g22, g23, g29, g30
from tests.made.paper_belt import BEAD, density, paper_point, temperature_profile, velocity_profile
from tests.made.results import letters

FREQUENCIES = (10, 20, 60, 80)
PAIRS = ((10, 10), (0, 50), (50, 50), (50, 100))


def row(frequencies=FREQUENCIES, profiles=None, **rest):
    """Return points at several frequencies; ``profiles`` replaces profiles by frequency."""
    return [
        paper_point(profiles=(profiles or {}).get(frequency), frequency=frequency, **rest)
        for frequency in frequencies
    ]


def block(height, top=9 * BEAD):
    """Return a uniform density of 200 beads below a height."""
    inside = height < top
    return 10 * inside / inside.sum() / BEAD**2


def leaning(height):
    """Return a density that falls through the bed."""
    shape = np.clip(1 - height / (18 * BEAD), 0, 1) * (height < 9 * BEAD)
    return 10 * shape / shape.sum() / BEAD**2


@pytest.mark.parametrize("slices", [1, 2])
@pytest.mark.parametrize(("end", "fall"), [(9.0, 0.5), (8.6, 1.5), (9.4, 0.1)])
def test_a_plateau_ends_where_the_density_begins_to_fall(slices, end, fall):
    """The density is a constant that falls off linearly, averaged over whole or half diameters."""
    fine = (np.arange(20_000) + 0.5) / 1000
    exact = 1e6 * np.clip(1 - (fine - end) / fall, 0, 1)
    number = exact.reshape(20 * slices, -1).mean(axis=1)
    height = (np.arange(20 * slices) + 0.5) / slices * BEAD
    assert plateau_end(BEAD)(height, number) / BEAD == pytest.approx(end, abs=0.5 / slices)


#: Densities of the bed at 80 Hz: more beads of the usual shape, and a thin layer with a gas.
USUAL = density(paper_point(frequency=80).parameters)
SMEARED = {
    "denser": lambda height: 2 * USUAL(height),
    "thinner": lambda height: 0.2 * block(height, 4 * BEAD) + 0.05 * USUAL(height),
}


def dense_angles(excess, noise=0.01, values=(30, 45, 60, 90)):
    """Return noisy densities at several angles, one with ``excess`` more at half of its heights."""
    random = np.random.default_rng(7)
    points = []
    for angle in values:
        usual = paper_point(frequency=60, vibration_angle=angle)
        shape = density(usual.parameters)(usual.height)
        factor = 1 + (excess if angle == 30 else 0.0) * np.sign(usual.height - 8 * BEAD)
        # The beads of a bed are the same at all angles, and so is a part of its deviation.
        bed_factor = 1 + 0.05 * np.linspace(-1, 1, 5)[:, None]
        values = bed_factor * factor * shape + noise * shape.max() * random.normal(
            size=(5, shape.size)
        )
        points.append(
            paper_point(profiles={"number_density": values}, frequency=60, vibration_angle=angle)
        )
    return points


def test_chance_alone_makes_differences_neither_small_nor_large():
    random = np.random.default_rng(5)
    held, failed = 0, 0
    for _ in range(200):
        beds = random.normal(size=(4, 40, 30))
        failed += compare_differences(beds, 1.0)[1][1] <= RISK
        beds[0, :, 7] += 1.0
        held += compare_differences(beds, 1.0)[1][0] <= RISK
    assert held <= 0.08 * 200 and failed <= 0.08 * 200
    assert compare_differences(beds, 3.0)[1][0] <= RISK
    assert compare_differences(beds, 0.1)[1][1] <= RISK


def friction(profiles=None, **rest):
    """Return points at several pairs of damping, those of ``profiles`` with other densities."""
    return [
        paper_point(
            profiles={"number_density": profiles[pair]} if pair in (profiles or {}) else None,
            frequency=80,
            damping=pair[0],
            shear_damping=pair[1],
            **rest,
        )
        for pair in PAIRS
    ]


def uneven():
    """Return densities with a wave of its own in each bed."""
    height = (np.arange(200) + 0.5) * BEAD
    waves = np.array([[0.2], [-0.2], [0.25], [-0.1], [0.0]])
    return block(height) * (1 + waves * np.sin(height / BEAD * 2))


def started(fast_lag=0.0, long_lag=0.1, short_lag=0.4, initial=20.0, scatter=1e-3):
    """Return runs from rest under both protocols, and fast starts, with lags at the top."""
    points = []
    for damping in (10, 50):
        where = {"frequency": 80, "damping": damping, "shear_damping": damping, "scatter": scatter}
        for lag, rest in (
            (short_lag, {"protocol": "published"}),
            (long_lag, {"protocol": "converged"}),
            (fast_lag, {"protocol": "published", "initial_velocity": initial}),
        ):
            usual = paper_point(**where, **rest)
            profile = velocity_profile(usual.parameters, lag)
            points.append(paper_point(profiles={"velocity_profile": profile}, **where, **rest))
    return points


def angles(values=(30, 45, 60, 90), **rest):
    """Return points at several angles."""
    return [paper_point(frequency=60, vibration_angle=angle, **rest) for angle in values]


def waves(early, later=2.0, **rest):
    """Return points with a power of density waves in the first cycles, and another later."""
    usual = {"early_wave_power": early, "wave_power": later}
    loose = {"vibration_angle": 30, "damping": 10, "shear_damping": 10}
    return [
        paper_point(usual, frequency=40, **rest),
        paper_point(usual, frequency=40, **loose, **rest),
    ]


#: A bed that has not relaxed, one at 20 Hz, and few beds that differ.
YOUNG = paper_point(frequency=80, damping=10, shear_damping=10)
HOT = paper_point(frequency=20)
USUAL_HEAT = temperature_profile(HOT.parameters)(HOT.height)
FEW = {"scatter": 3, "replicates": 2}

#: Velocities that fall with the frequency.
EVEN = {f: {"velocity_profile": lambda z, v=v: v + 0 * z} for f, v in ((10, 1.0), (80, 1e-4))}

#: A wave of its own in the velocity of each bed.
WAVES = 0.2 + 0.2 * np.array([[0.2], [-0.2], [0.3], [-0.1], [0.05]]) * np.sin(
    2 * np.arange(200) + 1
)


def profile(velocity):
    """Return a velocity over height of the bed at 60 Hz."""
    return {60: {"velocity_profile": velocity}}


def beads(frequency, number):
    """Return a density over height (m⁻²) of the bed at a frequency."""
    return {frequency: {"number_density": number}}


def heat(temperature):
    """Return a temperature over height of the bed at 20 Hz."""
    return {20: {"fluctuation_temperature_profile": np.array(temperature)}}


LOOSE = {"frequency": 40, "vibration_angle": 30, "damping": 10, "shear_damping": 10}
SNAPSHOTS = {"a": {"frequency": 10, "vibration_angle": 60}, "b": LOOSE, "c": {"frequency": 100}}


def snapshots(changed="", scalars=None, profiles=None, **rest):
    """Return the points of Figs. 5a to 5c, the one of panel ``changed`` with other data."""
    return [
        paper_point(
            scalars if name == changed else None,
            profiles if name == changed else None,
            **parameters,
            **rest,
        )
        for name, parameters in SNAPSHOTS.items()
    ]


def occupied(*shares, frequencies=(20, 80, 100), phase=0.01):
    """Return points with shares of the beads near the mean belt position, and at phase 0."""
    early = {"base_occupancy_at_phase_0": nan if phase is None else phase}
    return [
        paper_point({"base_occupancy": share} | early, frequency=frequency)
        for frequency, share in zip(frequencies, shares, strict=True)
    ]


def firm_and_soft(profiles=None, **rest):
    """Return beds at two coefficients of damping; the softer one may have other profiles."""
    soft = paper_point(profiles=profiles, frequency=100, damping=1, **rest)
    return [paper_point(frequency=100, **rest), soft]


#: Judges, the verdicts of their parts, and worlds that make them.
WORLDS = [
    (g15, "R", lambda: row((10,))),
    (g15, "N", lambda: row((10,), beads(10, leaning))),
    (g15, "I", lambda: [paper_point(profiles={"number_density": uneven()}, frequency=10)]),
    (g16, "R", lambda: row((20, 60, 80))),
    (g16, "N", lambda: row((20, 60, 80), beads(60, block))),
    (g16, "I", lambda: row((20, 60, 80), scatter=20)),
    (g17, "aR bR", lambda: row()),
    (g17, "aN bR", lambda: row(profiles=beads(80, SMEARED["denser"]))),
    (g17, "aR bN", lambda: row(profiles=beads(80, SMEARED["thinner"]))),
    # Two beds cannot show that no pair of frequencies is the other way.
    (g17, "aI bI", lambda: row(replicates=2, scatter=0.5)),
    (g18, "R", lambda: row((10, 60, 80))),
    (g18, "N", lambda: row((10, 60, 80), beads(60, block))),
    (g18, "N", lambda: row((10, 60, 80), beads(10, USUAL))),
    (g18, "I", lambda: row((10, 60, 80), scatter=0.3, replicates=2)),
    (g19, "R", lambda: dense_angles(0.0, noise=0.003)),
    (g19, "N", lambda: dense_angles(0.2)),
    # As large as the scatter of one bed.
    (g19, "I", lambda: dense_angles(0.025)),
    (g19, "-", lambda: dense_angles(0.0, values=(30, 45, 60))),
    (g20, "aR bR", lambda: friction()),
    (g20, "aN bN", lambda: friction({(10, 10): block})),
    (g20, "aR bI", lambda: friction(scatter=0.5)),
    (g21, "aR bR cR", lambda: [*row(), YOUNG]),
    (g21, "aN bR cN", lambda: [*row(profiles=profile(lambda z: 0.02 * z / BEAD)), YOUNG]),
    (
        g21,
        "aR bN cN",
        lambda: [
            *row(profiles=profile(velocity_profile(row((60,))[0].parameters, lag=-0.3))),
            YOUNG,
        ],
    ),
    (g21, "aI bI", lambda: row(profiles=profile(WAVES))),
    # Of runs that have relaxed no fall is asked for.
    (g21, "aR bR", lambda: row()),
    (g22, "R", lambda: started()),
    (g22, "N", lambda: started(fast_lag=0.3)),
    (g22, "N", lambda: started(long_lag=0.6)),
    (g23, "R", lambda: [*row((10, 20, 80)), *angles()]),
    (g23, "N", lambda: [*row((10, 20, 80), EVEN), *angles()]),
    (g23, "I", lambda: [*row((10, 20, 80), **FEW), *angles(**FEW)]),
    (g29, "R", lambda: row((18, 20))),
    (g29, "N", lambda: row((18, 20), heat(0.05 * np.exp(-HOT.height / BEAD)))),
    (
        g29,
        "I",
        lambda: row((18, 20), heat([*[USUAL_HEAT] * 3, *[np.full_like(HOT.height, 0.02)] * 2])),
    ),
    (g30, "aR bR", lambda: waves(4.0, scatter=0.01)),
    (g30, "aN bN", lambda: waves(1.6, scatter=0.01)),
    (g30, "aI bI", lambda: waves(2.2, scatter=0.5)),
    (g26, "aR bR cR", lambda: snapshots()),
    (g26, "aN bR cR", lambda: snapshots("a", {"path_vertical": 2e-4})),
    (
        g26,
        "aR bN cR",
        lambda: snapshots("b", None, {"packing_profile": lambda height: 0.95 + 0 * height}),
    ),
    (g26, "aR bR cN", lambda: snapshots("c", {"base_occupancy_at_phase_0": 0.1})),
    (g26, "aR cR", lambda: snapshots()[::2]),
    (g27, "aR bR", lambda: occupied(0.1, 0.005, 0.001)),
    (g27, "aN bR", lambda: occupied(0.1, 0.05, 0.001)),
    (g27, "aI bR", lambda: occupied(0.1, [0.005, 0.05, 0.01, 0.02, 0.02], 0.001)),
    (g27, "aR bI", lambda: occupied(0.1, 0.005, 0.001, phase=None)),
    (g27, "aR bN", lambda: occupied(0.1, 0.005, 0.001, phase=0.08)),
    (g28, "R", lambda: firm_and_soft()),
    (
        g28,
        "N",
        lambda: firm_and_soft({"packing_profile": lambda height: 0.8 * (height < 20 * BEAD)}),
    ),
    (g28, "I", lambda: firm_and_soft(scatter=0.5)),
]


@pytest.mark.parametrize(("judge", "verdicts", "world"), WORLDS)
def test_right_wrong_and_undecided_worlds(judge, verdicts, world):
    assert letters(judge, world()) == verdicts
