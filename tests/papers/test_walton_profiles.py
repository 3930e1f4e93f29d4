"""Judges of profiles: verdicts on correct, wrong, few or scattered synthetic flows."""

import numpy as np
import pytest

from sim.claims.place import replicate_mean
from sim.claims.verdict import INCONCLUSIVE, NOT_REPRODUCED, REPORTED, REPRODUCED, Untestable
from sim.papers.walton.judges.profiles import _densest_inner, w10, w11, w12, w13, w14, w17, w18
from tests.made.chute_flows import (
    PACKING,
    PAPER,
    SIZE,
    SLOPE,
    SPEEDS,
    UNIT,
    base_flows,
    flow,
    kinked_profile,
)
from tests.made.judging import checks_of, failed_quantities, verdict_of
from tests.made.results import SCATTER


def shaped(depth, velocity=lambda z: UNIT * z, packing=None, scalars=None, **options):
    """Return a flow of the base case with profiles: functions of height/diameter, or arrays."""

    def profile(shape):
        return (lambda height: shape(height / SIZE)) if callable(shape) else shape

    packing = packing or filled_to(depth / 0.9)
    profiles = {"velocity_profile": profile(velocity), "packing_profile": profile(packing)}
    return flow(SPEEDS[depth], scalars, profiles, depth=depth, **options)


def filled_to(depth: float):
    """Return the packing of a bed that is filled evenly up to a height in diameters."""
    return lambda z: PACKING * (z < depth)


def wavy(z, dip: float):
    """Return a velocity that rises but for a dip of its slope at one diameter."""
    return UNIT * (z - dip * np.clip(z - 1, 0, 0.5))


@pytest.mark.parametrize(
    ("dip", "scatter", "verdict"),
    [
        (0.0, SCATTER, REPRODUCED),
        (0.8, SCATTER, REPRODUCED),
        (1.2, SCATTER, NOT_REPRODUCED),
        (0.8, 1.5, INCONCLUSIVE),
    ],
)
def test_monotone_shear(dip, scatter, verdict):
    flows = [shaped(n, lambda z: wavy(z, dip), replicates=8, scatter=scatter) for n in (1.24, 2.5)]
    # Deeper flows may do as they like.
    flows.append(shaped(10, lambda z: -UNIT * z, replicates=8))
    assert verdict_of(w10, flows) == verdict


@pytest.mark.parametrize("judge", [w10, w12])
def test_statements_on_all_bins_need_many_replicates(judge):
    with pytest.raises(Untestable, match="6 replicates"):
        checks_of(judge, [shaped(1.24, replicates=5)])


@pytest.mark.parametrize(
    ("knee", "rest", "verdict"),
    [(2.0, 0.0, REPRODUCED), (2.0, 0.1, NOT_REPRODUCED), (9.0, 0.0, NOT_REPRODUCED)],
)
def test_plug_over_a_shear_layer(knee, rest, verdict):
    flows = [shaped(n, kinked_profile(n / 10 * knee, n, rest)) for n in (10, 20, 40)]
    assert verdict_of(w11, flows) == verdict


def test_plugs_are_counted_over_all_starts_and_cells():
    plug, sheared = kinked_profile(2, 10), kinked_profile(2, 10, 0.2)
    points = [
        *(shaped(10, plug, cell=5, initial_velocity=v) for v in (8, 16, 30)),
        shaped(10, sheared),
    ]
    checks = checks_of(w11, points)
    assert checks[0].value == 0.75 and checks[0].verdict == REPRODUCED
    # Shares of 15 and of 5 runs, with Wilson's intervals.
    assert [check.value for check in checks[1:]] == pytest.approx([0.898, 0.217], abs=1e-3)
    ends = [
        check.value + check.half_width * sign
        for check, sign in zip(checks[1:], (1, -1), strict=True)
    ]
    assert ends == pytest.approx([1, 0], abs=1e-9)
    # Half of few runs is not often, and not seldom.
    assert verdict_of(w11, points[-2:]) == INCONCLUSIVE


def test_runs_that_accelerate_are_no_plugs():
    runs = {"regime": ["accelerating", "steady", "steady", "steady", "steady"]}
    points = [shaped(10, kinked_profile(2, 10), scalars=runs), shaped(20, kinked_profile(2, 20))]
    assert "10 runs" not in checks_of(w11, points)[0].what
    assert checks_of(w11, points)[1].what.endswith("cells of 5 σ, 5 runs")
    assert checks_of(w11, points)[2].what.endswith("cells of 10 σ, 4 runs")


def test_plugs_need_cells_of_two_widths():
    with pytest.raises(Untestable, match="two widths"):
        checks_of(w11, [shaped(20, kinked_profile(2, 20))])


@pytest.mark.parametrize("judge", [w14, w17])
def test_deep_flows_must_be_there(judge):
    with pytest.raises(Untestable, match=r"depth|three depths"):
        checks_of(judge, base_flows({1.24: 4, 5: 8}))


def thinning(z, bump: float):
    """Return a packing that falls with height, but for a bump in the upper half of layer two."""
    return np.clip(0.5 - 0.15 * z + bump * ((z > 1.5) & (z < 2)), 0, None)


@pytest.mark.parametrize(
    ("bump", "scatter", "verdict"),
    [
        (0.0, SCATTER, REPRODUCED),
        # A rise between slices, not between layers.
        (0.2, SCATTER, REPRODUCED),
        (0.4, SCATTER, NOT_REPRODUCED),
        (0.0, 1.5, INCONCLUSIVE),
    ],
)
def test_packing_that_falls_from_layer_to_layer(bump, scatter, verdict):
    options = {"replicates": 8, "scatter": scatter}
    flows = [
        shaped(1.24, packing=lambda z: thinning(z, bump), **options),
        shaped(2.5, packing=lambda z: thinning(z, 0.5), **options),
    ]
    assert verdict_of(w12, flows) == verdict


def test_rises_of_the_packing_between_slices_are_reported():
    _, sliced = (
        check
        for check in checks_of(
            w12, [shaped(1.24, packing=lambda z: thinning(z, 0.2), replicates=8)]
        )
        if check.verdict == REPORTED
    )
    assert sliced.value == pytest.approx(0.2 - 0.15 / 4, abs=0.01)


def test_a_single_layer_cannot_thin_out():
    with pytest.raises(Untestable, match="two layers"):
        checks_of(w12, [shaped(1.24, packing=filled_to(1.5), replicates=8)])


def domed(z, peak: float, depth: float):
    """Return a packing with its maximum at half the depth, or its minimum if ``peak`` < 0."""
    inside = 0.5 + peak * np.sin(np.pi * z / depth)
    layers = 1 + 0.2 * np.cos(2 * np.pi * z)
    return np.where(z < depth, inside * layers, 0)


@pytest.mark.parametrize(
    ("peak", "scatter", "verdict"),
    [
        (0.1, SCATTER, REPRODUCED),
        (-0.1, SCATTER, NOT_REPRODUCED),
        (0.1, 1.5, INCONCLUSIVE),
    ],
)
def test_maximum_of_the_packing_inside(peak, scatter, verdict):
    flows = [
        shaped(n, packing=lambda z, n=n: domed(z, peak, 1.8 * n), scatter=scatter)
        for n in (3.5, 5, 10)
    ]
    assert verdict_of(w13, flows) == verdict


def test_the_densest_of_even_layers_is_not_clear_of_them():
    rng = np.random.default_rng(2)
    gained = []
    for _ in range(2000):
        rows = rng.normal(size=(3, 8))
        differences = _densest_inner(rows) - rows[:, 0]
        gained.append(
            replicate_mean(differences).nominal_value > 1.96 * replicate_mean(differences).std_dev
        )
    assert np.mean(gained) == pytest.approx(0.025, abs=0.012)


def test_a_maximum_inside_needs_three_layers():
    flat = np.where(np.arange(200) < 6, 0.5, 0.0)
    flows = [shaped(n, packing=lambda z: flat) for n in (3.5, 5, 10)]
    with pytest.raises(Untestable, match="three layers"):
        checks_of(w13, flows)


@pytest.mark.parametrize("missing", [3.5, 5, 10])
def test_maximum_inside_needs_all_intermediate_flows_with_replicates(missing):
    flows = [shaped(n, replicates=1 if n == missing else 5) for n in (3.5, 5, 10)]
    with pytest.raises(Untestable, match="replicates"):
        checks_of(w13, flows)


def block(plug: float = 0.62, sheared: float = 0.5, ripple: float = 0.0, gap: float = 1, **options):
    """Return a flow at depth 40 with a shear layer of four diameters under a plug.

    ``gap`` is the packing under the lowest centres over that of the shear layer.
    """

    def packing(z):
        rippled = plug * (1 + ripple * np.sign(np.sin(np.pi * z / 2)))
        layer = sheared * np.where(z < 0.5, gap, 1)
        return np.where(z < 4, layer, np.where(z < 60, rippled, 0))

    velocity = np.tile(kinked_profile(4.2, 40, replicates=1), (5, 1))
    return [shaped(40, velocity, packing, **{"transient": 2000} | options)]


@pytest.mark.parametrize(
    ("options", "wrong"),
    [
        ({}, []),
        ({"plug": 0.58}, ["packing of the plug"]),
        ({"sheared": 0.6}, ["packing of the plug less that of the shear layer"]),
        ({"sheared": 0.6, "gap": 0}, ["packing of the plug less that of the shear layer"]),
        # Densest and loosest layer lie 6 % apart, their standard deviation is 3 %.
        ({"plug": 0.7, "ripple": 0.03}, []),
        ({"plug": 0.7, "ripple": 0.07}, ["standard deviation of its packing over its mean"]),
    ],
)
def test_block_over_a_looser_layer(options, wrong):
    checks = checks_of(w14, block(**options))
    assert [quantity.removesuffix(", n = 40") for quantity in failed_quantities(checks)] == wrong
    assert verdict_of(w14, block(**options)) == (NOT_REPRODUCED if wrong else REPRODUCED)


def test_block_of_uncertain_packing_decides_nothing():
    assert verdict_of(w14, block(scatter=0.2)) == INCONCLUSIVE


def test_a_young_block_and_one_that_still_changes_decide_nothing():
    (check, *_) = checks_of(w14, block(transient=300))
    assert check.verdict == INCONCLUSIVE
    assert check.withheld == "averaged from 300 √(σ/g) on: runs of 2,000 and more"
    assert verdict_of(w14, block(scalars={"acceleration": -0.1 * SLOPE})) == INCONCLUSIVE


def test_an_age_may_be_rounded_to_whole_samples_and_the_oldest_flow_counts():
    # As a run with transient: 2000 has it, which ends with a whole sample.
    rounded = {"average_start": np.full(5, 1999.947 * PAPER.time_unit)}
    old = block(scalars=rounded, transient=2000)
    assert verdict_of(w14, old) == REPRODUCED
    assert verdict_of(w14, [*block(transient=300, replicates=9), *old]) == REPRODUCED


def test_a_block_of_stiffer_spheres_counts_where_the_softest_does_not_last():
    loose = block(plug=0.58, stiffness=1000)
    assert verdict_of(w14, [*block(), *loose]) == REPRODUCED
    running = block(scalars={"acceleration": np.full(5, 0.1 * SLOPE)})
    assert next(check.what for check in checks_of(w14, [*running, *loose])).endswith("1000 N/m")
    assert verdict_of(w14, [*running, *loose]) == NOT_REPRODUCED
    assert verdict_of(w14, loose) == NOT_REPRODUCED


def with_depths(*depths, scatter=SCATTER, **options):
    """Return flows at four depths in cells of 5 diameters, with given shear depths."""
    return [
        shaped(n, scalars={"shear_depth": depth * SIZE}, scatter=scatter, cell=5, **options)
        for n, depth in zip((5, 10, 20, 40), depths, strict=True)
    ]


def test_shear_depth_falls_with_the_depth():
    assert verdict_of(w17, with_depths(3.2, 3, 2, 1.5)) == REPRODUCED
    assert verdict_of(w17, with_depths(3, 4, 9, 30)) == NOT_REPRODUCED
    # A thicker layer may be a smaller fraction.
    thickness, fraction = checks_of(w17, with_depths(2, 2.2, 2.4, 2.6))
    assert (thickness.verdict, fraction.verdict) == (NOT_REPRODUCED, REPRODUCED)
    assert verdict_of(w17, with_depths(3, 2.9, 3.1, 2.8, scatter=0.5)) == INCONCLUSIVE


def test_shear_depths_of_stiffer_spheres_count_where_the_softest_do_not_last():
    hard = with_depths(3, 4, 9, 30, stiffness=1000)
    assert verdict_of(w17, [*with_depths(3.2, 3, 2, 1.5), *hard]) == REPRODUCED
    assert verdict_of(w17, [*with_depths(3.2, 3, 2, 1.5)[:3], *hard]) == NOT_REPRODUCED


def test_flows_of_unlike_cells_ages_or_too_few_depths_are_not_compared():
    points = with_depths(3.2, 3, 2, 1.5)
    young = shaped(40, scalars={"shear_depth": SIZE}, cell=5, transient=40)
    reasons = [checks_of(w17, flows)[0].withheld for flows in (points[1:], [*points[:3], young])]
    assert reasons[0] == "n = 10, 20, 40 alone in one cell"
    # A young flow is left out, not compared.
    assert reasons[1] == "n = 5, 10, 20 alone in one cell"


@pytest.mark.parametrize(
    ("rest", "scatter", "verdict"),
    [(0.5, SCATTER, REPRODUCED), (0.1, SCATTER, REPRODUCED), (0.0, SCATTER, NOT_REPRODUCED)],
)
def test_slowest_flow_shears_throughout(rest, scatter, verdict):
    slowest = shaped(1, kinked_profile(1.5, 10, rest, scatter=scatter), filled_to(4))
    assert verdict_of(w18, [slowest, shaped(1.24), shaped(2.5)]) == verdict


def test_slowest_flow_of_uncertain_shape_decides_nothing():
    rests = np.array([0.0, 0.01, 0.05, 0.2, 0.6])
    rows = np.vstack([kinked_profile(1.5, 10, rest, replicates=1) for rest in rests])
    slowest = shaped(1, rows, filled_to(4))
    assert verdict_of(w18, [slowest, shaped(1.24), shaped(2.5)]) == INCONCLUSIVE
    with pytest.raises(Untestable, match="three flows"):
        checks_of(w18, [slowest, shaped(1.24)])


@pytest.mark.parametrize("judge", [w10, w12, w13, w18])
def test_a_flow_that_drifts_decides_nothing_on_profiles(judge):
    drift = {"acceleration": 0.1 * SLOPE}
    flows = [
        shaped(n, packing=filled_to(n + 3), replicates=8, scalars=drift)
        for n in (1, 1.24, 2, 3.5, 5, 10)
    ]
    verdicts = {check.verdict for check in checks_of(judge, flows)}
    assert verdicts - {REPORTED} == {INCONCLUSIVE}


def test_a_flow_slower_with_height_everywhere_does_not_shear_evenly():
    falling = shaped(1, lambda z: UNIT * (30 - z), filled_to(4))
    assert verdict_of(w18, [falling, shaped(1.24), shaped(2.5)]) == INCONCLUSIVE


def test_flows_without_profiles_are_untestable():
    with pytest.raises(Untestable, match="no packing_profile"):
        checks_of(w13, base_flows())
