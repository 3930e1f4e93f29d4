"""Judges of claims about the density over height."""

from dataclasses import replace

import numpy as np
import pytest

from sim.base.errors import InputError
from sim.claims.evidence import Evidence
from sim.claims.verdict import (
    INCONCLUSIVE,
    NOT_REPRODUCED,
    REPORTED,
    REPRODUCED,
    RISK,
    Untestable,
)
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
from tests.made.judging import by_part, checks_of, headline_bounds, verdict_of
from tests.made.paper_belt import BEAD, density, paper_point
from tests.made.results import made_results

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


def test_a_plateau_of_density():
    assert verdict_of(g15, row((10,))) == REPRODUCED
    for profile in (leaning, lambda height: block(height, 12 * BEAD)):
        points = changed(row((10,)), profile, frequency=10)
        assert verdict_of(g15, points) == NOT_REPRODUCED
    with pytest.raises(Untestable, match="frequency 10"):
        checks_of(g15, row((20,)))


@pytest.mark.parametrize("slices", [1, 2])
@pytest.mark.parametrize(("end", "fall"), [(9.0, 0.5), (8.6, 1.5), (9.4, 0.1)])
def test_a_plateau_ends_where_the_density_begins_to_fall(slices, end, fall):
    """The density is a constant that falls off linearly, averaged over whole or half diameters."""
    fine = (np.arange(20_000) + 0.5) / 1000
    exact = 1e6 * np.clip(1 - (fine - end) / fall, 0, 1)
    number = exact.reshape(20 * slices, -1).mean(axis=1)
    height = (np.arange(20 * slices) + 0.5) / slices * BEAD
    assert plateau_end(BEAD)(height, number) / BEAD == pytest.approx(end, abs=0.5 / slices)


def test_grids_of_cells_and_of_points_count_other_beads():
    """Beads on the belt are at half a diameter: at no grid point, but in the first cell."""
    thin = {"height": (np.arange(60) + 0.5) * BEAD / 2, "slice_height": 0.5}
    place = np.arange(60)
    lying = np.where(place == 1, 2.0, 0) + np.where((place > 2) & (place < 20), 1.0, 0)
    profiles = {"number_density": lambda _: lying, "number_density_at_phase_0": lambda _: lying}
    results = made_results(
        *(paper_point(frequency=f, profiles=profiles, **thin) for f in (20, 60, 80))
    )
    for grid, share in (("centres", 1.0), ("points", 0.0)):
        checks = g16(Evidence(replace(results, grid=grid), "published"), **headline_bounds(g16))
        assert [check.value for check in checks] == pytest.approx([share] * 3 * 2)
    with pytest.raises(InputError, match="grid: got 'centers'; allowed: one of centres, "):
        results.profile(results.dataset.point.values[0], "number_density", "centers")
    assert len(checks_of(g16, row((20, 60, 80)))) == 3


def test_a_plateau_that_differs_from_bed_to_bed_decides_nothing():
    heights = (np.arange(200) + 0.5) * BEAD
    waves = [0.2, -0.2, 0.25, -0.1, 0.0]
    uneven = [block(heights) * (1 + wave * np.sin(heights / BEAD * 2)) for wave in waves]
    points = [paper_point(profiles={"number_density": np.array(uneven)}, frequency=10)]
    assert checks_of(g15, points)[0].verdict == INCONCLUSIVE


def test_hardly_a_bead_at_the_belt():
    points = row((20, 60, 80))
    assert verdict_of(g16, points) == REPRODUCED
    assert verdict_of(g16, changed(points, block, frequency=60)) == NOT_REPRODUCED
    with pytest.raises(Untestable, match="20, 60 and 80 Hz"):
        checks_of(g16, row((20, 60)))


def test_beads_at_the_belt_at_the_beginning_of_the_cycle_are_shown():
    """The paper's figure is one of a time mean."""
    early = {"number_density_at_phase_0": block}
    points = [paper_point(profiles=early, frequency=f) for f in (20, 60, 80)]
    checks = checks_of(g16, points)
    assert [(check.what.rpartition(", ")[2], check.votes) for check in checks] == [
        *[("time mean", True)] * 3,
        *[("phase 0", False)] * 3,
    ]
    assert all(check.value == pytest.approx(1) for check in checks[3:])
    assert verdict_of(g16, points) == REPRODUCED


def parts(judge, points) -> dict[str, str]:
    """Return the verdict on each part of a claim."""
    return by_part(checks_of(judge, points))


#: Densities of the bed at 80 Hz: more beads of the usual shape, and a thin layer with a gas.
USUAL = density(paper_point(frequency=80).parameters)
SMEARED = {
    "denser": lambda height: 2 * USUAL(height),
    "thinner": lambda height: 0.2 * block(height, 4 * BEAD) + 0.05 * USUAL(height),
}


@pytest.mark.parametrize(
    ("profile", "wrong"),
    [(USUAL, ""), (SMEARED["denser"], "a"), (SMEARED["thinner"], "b"), (block, "ab")],
)
def test_faster_shaking_smears_the_bed_and_one_sure_reversal_denies_it(profile, wrong):
    """Over the four frequencies there is a trend, but the last step goes the other way."""
    verdicts = parts(g17, changed(row(), profile, frequency=80))
    assert verdicts == {part: NOT_REPRODUCED if part in wrong else REPRODUCED for part in "ab"}


def test_beds_too_few_or_missing_are_not_known_to_smear():
    # Two beds cannot show that no pair of frequencies is the other way.
    verdicts = {"a": INCONCLUSIVE, "b": INCONCLUSIVE}
    assert parts(g17, row(replicates=2, scatter=0.5)) == verdicts
    with pytest.raises(Untestable, match="frequency 60"):
        checks_of(g17, row((10, 20, 80)))


def test_a_gas_above_the_bed():
    points = row((10, 60, 80))
    assert verdict_of(g18, points) == REPRODUCED
    assert verdict_of(g18, changed(points, block, frequency=60)) == NOT_REPRODUCED
    gas = paper_point(frequency=80).parameters
    assert verdict_of(g18, changed(points, density(gas), frequency=10)) == NOT_REPRODUCED
    with pytest.raises(Untestable, match="frequency 10"):
        checks_of(g18, row((60, 80)))


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


def test_density_whatever_the_angle():
    assert verdict_of(g19, angles(0.0, noise=0.003)) == REPRODUCED
    assert verdict_of(g19, angles(0.2)) == NOT_REPRODUCED
    # As large as the scatter of one bed.
    assert verdict_of(g19, angles(0.025)) == INCONCLUSIVE
    with pytest.raises(Untestable, match="vibration_angle 90"):
        checks_of(g19, angles(0.0, values=(30, 45, 60)))


def test_the_largest_difference_is_that_of_the_same_beds():
    random = np.random.default_rng(3)
    shift = np.zeros((4, 1, 30))
    shift[1, 0, 7] = 0.1
    difference, _ = compare_differences(random.normal(size=(1, 5, 1)) + shift, 1.0)
    assert difference.nominal_value == pytest.approx(0.1)
    assert difference.std_dev == pytest.approx(0, abs=1e-12)


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


def test_beds_are_compared_with_themselves_where_one_has_failed():
    points = angles(0.0, noise=1e-4)
    whole = checks_of(g19, points)
    values = points[1].profiles["number_density"].copy()
    status = ["completed"] * 5
    status[1], values[1] = "failed", np.nan
    points[1] = paper_point(
        {"status": status}, {"number_density": values}, frequency=60, vibration_angle=45
    )
    assert checks_of(g19, points)[0].verdict == whole[0].verdict == REPRODUCED


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


def test_less_friction_smears_the_bed():
    assert parts(g20, friction()) == {"a": REPRODUCED, "b": REPRODUCED}
    assert parts(g20, friction({(10, 10): block})) == dict.fromkeys("ab", NOT_REPRODUCED)
    # A thin layer with as many beads at the belt.
    thin = density(paper_point(frequency=80, shear_damping=400).parameters)
    assert parts(g20, friction({(10, 10): thin})) == {"a": NOT_REPRODUCED, "b": REPRODUCED}
    assert verdict_of(g20, friction(scatter=0.5)) == INCONCLUSIVE
    with pytest.raises(Untestable, match="damping 50, shear_damping 100"):
        checks_of(g20, friction()[:-1])


def test_fewer_beads_at_the_belt_are_not_the_claim():
    loose = density(friction()[0].parameters)
    fewer = {(10, 10): lambda height: loose(height) * np.where(height < 2 * BEAD, 0.5, 1)}
    checks = checks_of(g20, friction(fewer))
    verdicts = [check.verdict for check in checks]
    assert verdicts == [REPRODUCED, REPORTED] * 3 + [NOT_REPRODUCED, REPRODUCED]
    assert by_part(checks) == {"a": REPRODUCED, "b": NOT_REPRODUCED}


def test_a_gas_above_does_not_widen_the_layer():
    gas = {(50, 100): lambda height: block(height) + 5e4 * (height < 60 * BEAD)}
    checks = checks_of(g20, friction(gas))
    widths = [check for check in checks if check.what.startswith("width of the layer")]
    spreads = [check for check in checks if check.what.startswith("standard deviation")]
    assert all(check.value > 0 for check in widths)
    assert min(check.value for check in spreads) < 0
