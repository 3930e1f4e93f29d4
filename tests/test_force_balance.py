"""The force-balance check passes on balanced forces, fails on wrong ones, and can stay open."""

import numpy as np
import pytest
import xarray as xr

from sim.claims.force_balance import (
    INCONCLUSIVE,
    LIMITS,
    NOT_REPRODUCED,
    REPRODUCED,
    Deviation,
    judge,
    worst,
)
from sim.dataset import build
from sim.parameters import ChuteParameters
from tests.factories import write_run


def balance_of(tmp_path, point=None, **options):
    """Judge a study of one chute point whose run file is made with these options."""
    point = point or ChuteParameters()
    study = tmp_path / "one.yaml"
    base = f"{{replicates: {point.replicates}, angle: {point.angle}}}"
    study.write_text(f"study: one\nseries: [{{name: one, system: chute, base: {base}}}]")
    write_run(tmp_path / "results" / "one" / "runs", point, **options)
    with xr.open_dataset(build(study, tmp_path / "results")) as dataset:
        return judge(dataset.load())


def test_balanced_forces_are_reproduced(tmp_path):
    balance = balance_of(tmp_path)
    assert balance.verdict == REPRODUCED
    (point,) = balance.points
    assert abs(point.ratio.mean) + point.ratio.half_width < LIMITS["ratio"]
    assert abs(point.normal.mean) + point.normal.half_width < LIMITS["normal"]


@pytest.mark.parametrize(
    ("wrong", "ratio", "normal"),
    [
        ({"shear_excess": 0.02}, NOT_REPRODUCED, REPRODUCED),
        ({"shear_excess": -0.02}, NOT_REPRODUCED, REPRODUCED),
        ({"shear_excess": 0.01, "normal_excess": 0.01}, REPRODUCED, NOT_REPRODUCED),
    ],
)
def test_wrong_forces_are_not_reproduced(tmp_path, wrong, ratio, normal):
    balance = balance_of(tmp_path, **wrong)
    (point,) = balance.points
    assert (point.ratio.verdict, point.normal.verdict) == (ratio, normal)
    assert balance.verdict == NOT_REPRODUCED


@pytest.mark.parametrize("regime", ["accelerating", "arrested", "undetermined"])
def test_only_steady_flows_are_judged(tmp_path, regime):
    balance = balance_of(tmp_path, regime=regime)
    assert [point.steady for point in balance.points] == [False]
    assert balance.verdict == INCONCLUSIVE
    assert balance.budget_verdict == REPRODUCED


def test_the_budget_counts_the_change_of_momentum(tmp_path):
    # Ten units of velocity gained in the run take about a tenth of the weight along the slope.
    balance = balance_of(tmp_path, regime="accelerating", gain=10.0)
    (point,) = balance.points
    assert point.budget.verdict == REPRODUCED
    assert abs(point.budget.mean) < 1e-3
    wrong = balance_of(tmp_path, regime="accelerating", gain=10.0, shear_excess=0.02)
    assert wrong.budget_verdict == NOT_REPRODUCED


def test_a_level_plane_leaves_the_budget_open(tmp_path):
    balance = balance_of(tmp_path, ChuteParameters(angle=0), regime="arrested")
    assert balance.budget_verdict == INCONCLUSIVE


def test_a_study_of_failures_is_inconclusive(tmp_path):
    balance = balance_of(tmp_path, failed=[0])
    assert (balance.points, balance.verdict) == ((), INCONCLUSIVE)


def test_failed_replicates_do_not_count(tmp_path):
    balance = balance_of(tmp_path, ChuteParameters(replicates=3), failed=[1])
    assert [point.replicates for point in balance.points] == [2]


def test_three_replicates_give_students_interval(tmp_path):
    balance = balance_of(tmp_path, ChuteParameters(replicates=3))
    # The made replicates have the same forces: no scatter over them.
    assert balance.points[0].ratio.half_width == pytest.approx(0, abs=1e-12)


@pytest.mark.parametrize(
    ("mean", "half_width", "verdict"),
    [
        (0.001, 0.001, REPRODUCED),
        (-0.004, 0.0005, REPRODUCED),
        (0.004, 0.002, INCONCLUSIVE),
        (0.006, 0.002, INCONCLUSIVE),
        (0.008, 0.002, NOT_REPRODUCED),
        (-0.008, 0.002, NOT_REPRODUCED),
        (0.0, np.nan, INCONCLUSIVE),
    ],
)
def test_verdict_follows_the_interval(mean, half_width, verdict):
    assert Deviation(mean, half_width, LIMITS["ratio"]).verdict == verdict


def test_one_failure_fails_all_and_nothing_is_inconclusive():
    assert worst([REPRODUCED, INCONCLUSIVE, NOT_REPRODUCED]) == NOT_REPRODUCED
    assert worst([REPRODUCED, INCONCLUSIVE]) == INCONCLUSIVE
    assert worst([REPRODUCED, REPRODUCED]) == REPRODUCED
    assert worst([]) == INCONCLUSIVE
