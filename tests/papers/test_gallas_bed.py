"""Judges of claims about the bed over height: density, velocity, agitation, snapshots."""

from functools import partial
from math import nan

import numpy as np
import pytest

from sim.claims.verdict import RISK
from sim.papers.gallas.judges.density import (
    ALL,
    compare_differences,
    g15,
    g16,
    g17,
    g18,
    g19,
    g20,
    plateau_end,
    width_of_beads,
)
from sim.papers.gallas.judges.snapshots import g26, g27, g28, g40
from sim.papers.gallas.judges.velocity import g21, g22, g23, g29, g30
from tests.made.paper_belt import BEAD, density, paper_point, temperature_profile, velocity_profile
from tests.made.results import by_part, checks_of, letters

FREQUENCIES = (10, 20, 40, 60, 80, 100)
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


@pytest.mark.parametrize("slices", [1, 2])
@pytest.mark.parametrize(("share", "width"), [(0.6, 6.0), (0.9, 9.0), (ALL, 10 / 12**0.5)])
def test_the_width_of_an_even_layer_is_its_share(share, width, slices):
    """The layer lies between 2 and 12⟨d⟩, whatever the slices."""
    height = (np.arange(20 * slices) + 0.5) / slices * BEAD
    number = 1.0 * (abs(height - 7 * BEAD) < 5 * BEAD)
    assert width_of_beads(share)(height, number) / BEAD == pytest.approx(width, rel=0.01)


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


def gaseous(height):
    """Return the density of the firmest bed with some beads far above it."""
    firm = density(paper_point(frequency=80, shear_damping=100).parameters)
    return firm(height) + 1e4 * (abs(height - 150 * BEAD) < 20 * BEAD)


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


#: Curves of Fig. 3 by their parameters.
FIGURE_3 = (
    *({"frequency": f} for f in (20, 60, 80)),
    *({"frequency": 60, "vibration_angle": angle} for angle in (30, 60)),
    *({"frequency": 80, "damping": g, "shear_damping": shear} for g, shear in PAIRS if g != shear),
    {"frequency": 80, "damping": 10, "shear_damping": 10},
)


def figure_3(velocity=None, which=-1, **rest):
    """Return the points of Fig. 3; that of one curve has another velocity over height."""
    changed = FIGURE_3[which]
    profiles = None if velocity is None else {"velocity_profile": velocity}
    return [
        paper_point(profiles=profiles if curve is changed else None, **curve, **rest)
        for curve in FIGURE_3
    ]


def test_the_fall_at_the_top_is_asked_of_runs_of_the_published_length_alone():
    relaxed = figure_3(protocol="converged")
    assert by_part(checks_of(g21, relaxed, protocol="converged")).keys() == {"a", "b"}


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


#: A bed at 20 Hz, and few beds that differ.
HOT = paper_point(frequency=20)
USUAL_HEAT = temperature_profile(HOT.parameters)(HOT.height)
FEW = {"scatter": 3, "replicates": 2}

#: Velocities that fall with the frequency.
EVEN = {f: {"velocity_profile": lambda z, v=v: v + 0 * z} for f, v in ((10, 1.0), (80, 1e-4))}

#: A wave of its own in the velocity of each bed.
WAVES = 0.2 + 0.2 * np.array([[0.2], [-0.2], [0.3], [-0.1], [0.05]]) * np.sin(
    2 * np.arange(200) + 1
)


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


def packed(factor):
    """Return the profiles of the firm bed with a factor on its packing."""
    number = density(paper_point(frequency=100).parameters)
    return {
        "number_density": number,
        "packing_profile": lambda height: factor * 0.8 * number(height) * BEAD**2,
    }


def firm_and_soft(profiles=None, **rest):
    """Return beds at two coefficients of damping; the softer one may have other profiles."""
    soft = paper_point(profiles=profiles, frequency=100, damping=1, **rest)
    return [paper_point(frequency=100, **rest), soft]


#: The reading of a void in the mean over the cycle, and what is none at the beginning.
mean_g27 = partial(g27, at_phase_0=0)
AT_PHASE_0 = {"base_occupancy_at_phase_0": 0.1}

#: Judges, the verdicts of their parts, and worlds that make them.
WORLDS = [
    (g15, "R", lambda: row((10,))),
    (g15, "N", lambda: row((10,), beads(10, leaning))),
    (g15, "I", lambda: [paper_point(profiles={"number_density": uneven()}, frequency=10)]),
    (g16, "R", lambda: row((20, 60, 80))),
    (g16, "N", lambda: row((20, 60, 80), beads(60, block))),
    (g16, "I", lambda: row((20, 60, 80), scatter=20)),
    (g17, "aR bR", lambda: row()),
    # Five beds are few for fifteen pairs of frequencies.
    (g17, "aN bR", lambda: row(profiles=beads(100, SMEARED["denser"]), replicates=8)),
    (g17, "aR bN", lambda: row(profiles=beads(100, SMEARED["thinner"]), replicates=8)),
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
    # A few beads high above widen the whole, and not the layer.
    (g20, "aR bR", lambda: friction({(50, 100): gaseous})),
    (partial(g20, share=ALL), "aR bR", lambda: friction()),
    (partial(g20, share=ALL), "aN bR", lambda: friction({(50, 100): gaseous})),
    (g20, "aR bI", lambda: friction(scatter=0.5)),
    (g21, "aR bR cR", lambda: figure_3()),
    # One curve refutes what all exhibit.
    (g21, "aN bR cN", lambda: figure_3(lambda z: 0.02 * z / BEAD)),
    (g21, "aR bN cN", lambda: figure_3(velocity_profile(row((80,))[0].parameters, lag=-0.3), 2)),
    (g21, "aI bI cI", lambda: figure_3(WAVES)),
    (g21, "-", lambda: figure_3()[:-1]),
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
    (partial(g26, at_phase_0=0), "aR bR cR", lambda: snapshots("c", AT_PHASE_0)),
    (g27, "R", lambda: occupied(0.1, 0.05, 0.05)),
    (g27, "N", lambda: occupied(0.1, 0.005, 0.001, phase=0.08)),
    (g27, "I", lambda: occupied(0.1, 0.005, 0.001, phase=None)),
    (mean_g27, "R", lambda: occupied(0.1, 0.005, 0.001, phase=0.08)),
    (mean_g27, "N", lambda: occupied(0.1, 0.05, 0.001)),
    (mean_g27, "I", lambda: occupied(0.1, [0.005, 0.05, 0.01, 0.02, 0.02], 0.001)),
    (g28, "R", lambda: firm_and_soft()),
    (
        g28,
        "N",
        lambda: firm_and_soft({"packing_profile": lambda height: 0.8 * (height < 20 * BEAD)}),
    ),
    # Less packed by 3 % is neither.
    (g28, "I", lambda: firm_and_soft(packed(1.03))),
    (g28, "N", lambda: firm_and_soft(packed(1.08))),
    (g28, "I", lambda: firm_and_soft(scatter=0.5)),
    (g40, "R", lambda: row(FREQUENCIES[1:])),
    (g40, "N", lambda: row(FREQUENCIES[1:], {100: {"packing_profile": lambda z: 0.8 + 0 * z}})),
    (g40, "I", lambda: row(FREQUENCIES[1:], scatter=0.5)),
]


@pytest.mark.parametrize(("judge", "verdicts", "world"), WORLDS)
def test_right_wrong_and_undecided_worlds(judge, verdicts, world):
    assert letters(judge, world()) == verdicts
