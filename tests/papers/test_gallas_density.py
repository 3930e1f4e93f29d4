"""Judges of claims about the density over height."""

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
from tests.made.judging import letters
from tests.made.paper_belt import BEAD, density, paper_point

FREQUENCIES = (10, 20, 60, 80)
PAIRS = ((10, 10), (0, 50), (50, 50), (50, 100))


def row(frequencies=FREQUENCIES, **rest):
    """Return points at several frequencies."""
    return [paper_point(frequency=frequency, **rest) for frequency in frequencies]


def changed(points, profile, **parameters):
    """Return points, one of them with another density over height (m⁻²)."""
    new = paper_point(profiles={"number_density": profile}, **parameters)
    assert new.id in {point.id for point in points}
    return [new if point.id == new.id else point for point in points]


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


def angles(excess, noise=0.01, values=(30, 45, 60, 90)):
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


#: Judges, the verdicts of their parts, and worlds that make them.
WORLDS = [
    (g15, "R", lambda: row((10,))),
    (g15, "N", lambda: changed(row((10,)), leaning, frequency=10)),
    (g15, "I", lambda: [paper_point(profiles={"number_density": uneven()}, frequency=10)]),
    (g15, "-", lambda: row((20,))),
    (g16, "R", lambda: row((20, 60, 80))),
    (g16, "N", lambda: changed(row((20, 60, 80)), block, frequency=60)),
    (g16, "I", lambda: row((20, 60, 80), scatter=20)),
    (g16, "-", lambda: row((20, 60))),
    (g17, "aR bR", lambda: row()),
    (g17, "aN bR", lambda: changed(row(), SMEARED["denser"], frequency=80)),
    (g17, "aR bN", lambda: changed(row(), SMEARED["thinner"], frequency=80)),
    # Two beds cannot show that no pair of frequencies is the other way.
    (g17, "aI bI", lambda: row(replicates=2, scatter=0.5)),
    (g17, "-", lambda: row((10, 20, 80))),
    (g18, "R", lambda: row((10, 60, 80))),
    (g18, "N", lambda: changed(row((10, 60, 80)), block, frequency=60)),
    (g18, "N", lambda: changed(row((10, 60, 80)), USUAL, frequency=10)),
    (g18, "I", lambda: row((10, 60, 80), scatter=0.3, replicates=2)),
    (g18, "-", lambda: row((60, 80))),
    (g19, "R", lambda: angles(0.0, noise=0.003)),
    (g19, "N", lambda: angles(0.2)),
    # As large as the scatter of one bed.
    (g19, "I", lambda: angles(0.025)),
    (g19, "-", lambda: angles(0.0, values=(30, 45, 60))),
    (g20, "aR bR", lambda: friction()),
    (g20, "aN bN", lambda: friction({(10, 10): block})),
    # A thin layer with as many beads at the belt.
    (
        g20,
        "aN bR",
        lambda: friction(
            {(10, 10): density(paper_point(frequency=80, shear_damping=400).parameters)}
        ),
    ),
    (g20, "aR bI", lambda: friction(scatter=0.5)),
    (g20, "-", lambda: friction()[:-1]),
]


@pytest.mark.parametrize(("judge", "verdicts", "world"), WORLDS)
def test_right_wrong_and_undecided_worlds(judge, verdicts, world):
    assert letters(judge, world()) == verdicts
