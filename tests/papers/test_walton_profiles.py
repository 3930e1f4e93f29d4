"""Judges of profiles: verdicts on correct, wrong, few or scattered synthetic flows."""

import numpy as np
import pytest

from sim.claims.place import replicate_mean
from sim.claims.verdict import (
    INCONCLUSIVE,
    NOT_REPRODUCED,
    READING_DEPENDENT,
    REPORTED,
    REPRODUCED,
    Untestable,
)
from sim.papers.walton.judges.profiles import _densest_inner, w10, w11, w12, w13, w14, w17, w18
from tests.made.chute_flows import (
    PACKING,
    PAPER,
    RUNAWAY,
    SIZE,
    SLOPE,
    SPEEDS,
    UNIT,
    base_flows,
    flow,
    kinked_profile,
)
from tests.made.judging import by_part, checks_of, failed_quantities, judgement_of, verdict_of
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
    flows = [shaped(n, kinked_profile(n / 10 * knee, n, rest), cell=10) for n in (10, 20, 40)]
    assert verdict_of(w11, flows) == verdict


def test_plugs_are_counted_over_all_starts():
    plug, sheared = kinked_profile(2, 10), kinked_profile(2, 10, 0.2)
    points = [
        *(shaped(10, plug, initial_velocity=v) for v in (8, 16, 30)),
        shaped(10, sheared, initial_velocity=60),
    ]
    checks = checks_of(w11, points)
    assert checks[0].value == 0.75 and checks[0].verdict == REPRODUCED
    assert checks[0].text == "15 of 20 (0.53 to 0.89)"
    # One depth is the share of all.
    assert len(checks) == 1
    # Half of few runs is not often, and not seldom.
    assert verdict_of(w11, points[-2:]) == INCONCLUSIVE


def in_cells(*widths):
    """Return eight runs of depths 10 and 20 per width: plugs, but not in cells of 10."""
    return [
        shaped(n, kinked_profile(n / 5, n, 0.2 * (cell == 10), 8), cell=cell, replicates=8)
        for n in (10, 20)
        for cell in widths
    ]


def test_plugs_in_cells_of_other_widths_are_not_counted():
    alone, (share, *_) = checks_of(w11, in_cells(10)), checks_of(w11, in_cells(5, 10, 20))
    assert share == alone[0] and share.verdict == NOT_REPRODUCED
    assert share.what == "share of runs with a plug, n = 10, 20 in cells of 10 σ"
    with pytest.raises(Untestable, match="in cells of 10 σ"):
        checks_of(w11, in_cells(5, 20))


def test_the_width_of_the_cell_is_a_reading_of_plugs():
    judgement = judgement_of("W11", in_cells(5, 10))
    assert judgement.verdict == READING_DEPENDENT
    by_reading = {reading: judgement.verdict_under(reading) for reading in judgement.readings}
    assert by_reading == {"default": NOT_REPRODUCED, "L = 5 σ": REPRODUCED}
    assert judgement_of("W11", in_cells(10)).verdict == NOT_REPRODUCED


def test_runs_that_accelerate_are_no_plugs():
    runs = {"regime": ["accelerating", "steady", "steady", "steady", "steady"]}
    points = [
        shaped(10, kinked_profile(2, 10), scalars=runs),
        shaped(20, kinked_profile(4, 20), cell=10),
    ]
    share, *by_depth = checks_of(w11, points)
    # Of nine runs, all have a plug.
    assert (share.value, share.p_holds) == (1, pytest.approx(0.5**9))
    assert [check.text for check in by_depth] == ["4 of 4 (0.51 to 1)", "5 of 5 (0.57 to 1)"]
    assert all("alone" in check.what and not check.has_vote for check in by_depth)
    with pytest.raises(Untestable, match="do not accelerate"):
        gone = {"regime": "accelerating"}
        checks_of(w11, [shaped(10, kinked_profile(2, 10), scalars=gone)])


@pytest.mark.parametrize("judge", [w14, w17])
def test_deep_flows_of_stiff_spheres_must_be_there(judge):
    with pytest.raises(Untestable, match="at depth"):
        checks_of(judge, base_flows({1.24: 4, 5: 8, 10: 15, 20: 25, 40: 30}))


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


def test_rises_of_the_packing_between_slices_are_shown():
    flow_of_one = [shaped(1.24, packing=lambda z: thinning(z, 0.2), replicates=8)]
    layers, centres, plane, *single = checks_of(w12, flow_of_one)
    assert [check.text.split(" (")[0] for check in single] == ["8 of 8", "0 of 8"]
    assert layers.has_vote and not centres.votes and plane.verdict == REPORTED
    for sliced in (centres, plane):
        assert sliced.value == pytest.approx(0.2 - 0.15 / 4, abs=0.01)
    assert centres.p_fails < 0.05


def gap_at_the_plane(z):
    """Return a packing that falls with height, but for a gap under the first centres."""
    return np.clip(0.5 - 0.15 * z, 0, None) * np.where(z < 0.5, 0.9, 1)


@pytest.mark.parametrize(
    ("packing", "by_slices", "verdict"),
    [
        (lambda z: thinning(z, 0.2), NOT_REPRODUCED, READING_DEPENDENT),
        (lambda z: thinning(z, 0), REPRODUCED, REPRODUCED),
        # What lies under the first centres belongs to no sphere's middle.
        (gap_at_the_plane, REPRODUCED, REPRODUCED),
    ],
)
def test_the_thickness_of_the_slices_is_a_reading_of_the_packing(packing, by_slices, verdict):
    judgement = judgement_of("W12", [shaped(1.24, packing=packing, replicates=8)])
    by_reading = {reading: judgement.verdict_under(reading) for reading in judgement.readings}
    assert by_reading == {
        "default": REPRODUCED,
        "profiles by slices of a quarter diameter": by_slices,
    }
    assert judgement.verdict == verdict


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
    """Return a flow of stiff spheres at depth 40: a plug on a shear layer of four diameters.

    ``gap`` is the packing under the lowest centres over that of the shear layer.
    """

    def packing(z):
        rippled = plug * (1 + ripple * np.sign(np.sin(np.pi * z / 2)))
        layer = sheared * np.where(z < 0.5, gap, 1)
        return np.where(z < 4, layer, np.where(z < 60, rippled, 0))

    velocity = np.tile(kinked_profile(4.2, 40, replicates=1), (5, 1))
    return [shaped(40, velocity, packing, **{"transient": 2000, "stiffness": 1000} | options)]


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
    label = ", n = 40, K1 = 1000 N/m"
    assert [quantity.removesuffix(label) for quantity in failed_quantities(checks)] == wrong
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


@pytest.mark.parametrize("options", [{}, {"scalars": RUNAWAY}])
def test_a_block_is_one_of_stiff_spheres_whatever_the_softest_do(options):
    soft = block(stiffness=100, **options)
    assert verdict_of(w14, [*soft, *block(plug=0.58)]) == NOT_REPRODUCED
    assert verdict_of(w14, [*block(plug=0.58, stiffness=100), *block()]) == REPRODUCED
    with pytest.raises(Untestable, match="at depth 40"):
        checks_of(w14, soft)


def with_depths(*depths, scatter=SCATTER, **options):
    """Return flows of stiff spheres at three depths in cells of 5, with given shear depths."""
    options = {"stiffness": 1000, "cell": 5} | options
    return [
        shaped(n, scalars={"shear_depth": depth * SIZE}, scatter=scatter, **options)
        for n, depth in zip((10, 20, 40), depths, strict=True)
    ]


@pytest.mark.parametrize(
    ("depths", "verdicts"),
    [
        ((3, 2, 1.5), {"a": REPRODUCED, "b": REPRODUCED}),
        ((1, 4, 30), {"a": NOT_REPRODUCED, "b": NOT_REPRODUCED}),
        # A thicker layer may be a smaller fraction.
        ((2.2, 2.4, 2.6), {"a": NOT_REPRODUCED, "b": REPRODUCED}),
    ],
)
def test_shear_depth_and_its_share_fall_with_the_depth(depths, verdicts):
    assert by_part(checks_of(w17, with_depths(*depths))) == verdicts


def test_shear_depths_that_scatter_decide_nothing():
    checks = checks_of(w17, with_depths(3, 2.9, 3.1, scatter=0.5))
    assert by_part(checks)["a"] == INCONCLUSIVE


def test_shear_depths_are_those_of_stiff_spheres_and_of_deep_flows():
    usual = checks_of(w17, with_depths(3, 2, 1.5))
    assert usual[0].what.endswith("shear depth over n = 10, 20, 40, K1 = 1000 N/m")
    # Neither the softest spheres nor a flow that shears throughout change anything.
    others = [
        *with_depths(1, 4, 30, stiffness=100),
        shaped(5, scalars={"shear_depth": SIZE}, cell=5, stiffness=1000),
    ]
    assert checks_of(w17, [*others, *with_depths(3, 2, 1.5)]) == usual


def test_shear_depths_of_unlike_cells_or_ages_are_not_compared():
    points = with_depths(3, 2, 1.5)
    young = {"scalars": {"shear_depth": SIZE}, "cell": 5, "stiffness": 1000, "transient": 40}
    unlike = [*points[:2], shaped(40, **young)]
    assert {check.withheld for check in checks_of(w17, unlike)} == {
        "flows of ages 40 and 300 √(σ/g) are compared"
    }
    # Younger windows of the others make it comparable.
    alike = [*unlike, *(shaped(n, **young) for n in (10, 20))]
    assert not any(check.withheld for check in checks_of(w17, alike))
    with pytest.raises(Untestable, match="depth 40, cell 5"):
        checks_of(w17, [*points[:2], *with_depths(3, 2, 1.5, cell=10)])


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
