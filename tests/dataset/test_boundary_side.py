"""The side of a run: regimes, velocities, replicates that fail or disagree."""

from math import nan

import numpy as np
import pytest
import xarray as xr

from sim.base.errors import InputError
from sim.dataset.rounds import side_of_run
from sim.parameters import BeltParameters, ChuteParameters
from tests.made.netcdf import store
from tests.made.runs import write_run

CHUTE = ChuteParameters(replicates=2)
BELT = BeltParameters(replicates=2, frequency=20)


@pytest.mark.parametrize(
    ("regime", "flow", "acceleration"),
    [
        ("arrested", "arrested", "not accelerating"),
        ("steady", "flowing", "not accelerating"),
        ("accelerating", "flowing", "accelerating"),
        ("undetermined", None, None),
    ],
)
def test_regimes_tell_the_side(regime, flow, acceleration, tmp_path):
    path = write_run(tmp_path, CHUTE, 0.0, regime=regime)
    assert side_of_run(path, "flow", CHUTE) == flow
    assert side_of_run(path, "acceleration", CHUTE) == acceleration


@pytest.mark.parametrize(
    ("velocity", "gain", "side"),
    [(0.1, 0.0, "flowing"), (0.1, 1.0, "flowing"), (0.1, -3.0, None), (5e-4, 0.0, None)],
)
def test_an_undetermined_flow_flows_if_it_surely_moves_and_does_not_slow_down(
    velocity, gain, side, tmp_path
):
    path = write_run(tmp_path, CHUTE, velocity, regime="undetermined")
    with xr.open_dataset(path) as opened:
        run = opened.load()
    run["acceleration"][:] = gain
    store(run, path)
    assert side_of_run(path, "flow", CHUTE) == side
    assert side_of_run(path, "acceleration", CHUTE) is None


def test_replicates_must_agree_on_the_side_not_on_the_regime(tmp_path):
    path = write_run(tmp_path, CHUTE)
    with xr.open_dataset(path) as opened:
        run = opened.load()
    run["regime"] = ("replicate", np.array(["steady", "accelerating"], dtype=object))
    store(run, path)
    assert side_of_run(path, "flow", CHUTE) == "flowing"
    assert side_of_run(path, "acceleration", CHUTE) is None


def test_failed_replicates_are_left_out(tmp_path):
    path = write_run(tmp_path, CHUTE, failed=[0])
    assert side_of_run(path, "flow", CHUTE) == "flowing"
    path = write_run(tmp_path, CHUTE, failed=[0, 1])
    assert side_of_run(path, "flow", CHUTE) is None


# A tenth of the belt's velocity amplitude is 12.6 mm/s, the half width is 0.9 mm/s.
@pytest.mark.parametrize(
    ("velocity", "side"),
    [
        ((0.03, 0.04), "transport"),
        ((0.001, 0.0115), "no transport"),
        ((-0.03, 0.001), "no transport"),
        ((0.012, 0.013), None),
        ((0.001, 0.03), None),
    ],
)
def test_transport_is_a_velocity_that_counts(velocity, side, tmp_path):
    path = write_run(tmp_path, BELT, velocity, regime="undetermined")
    assert side_of_run(path, "transport", BELT) == side


def test_a_velocity_without_an_error_tells_nothing(tmp_path):
    path = write_run(tmp_path, BELT, 0.03)
    with xr.open_dataset(path) as opened:
        run = opened.load()
    run["velocity_half_width"][:] = nan
    store(run, path)
    assert side_of_run(path, "transport", BELT) is None


def test_a_belt_that_shakes_upright_moves_nothing_along(tmp_path):
    upright = BeltParameters(vibration_angle=90)
    path = write_run(tmp_path, upright, 0.0)
    assert side_of_run(path, "transport", upright) == "no transport"


def test_a_missing_and_a_broken_run_are_named(tmp_path):
    path = tmp_path / "run.nc"
    with pytest.raises(InputError, match=r"run\.nc: no such run file"):
        side_of_run(path, "flow", CHUTE)
    path.write_text("not netCDF")
    with pytest.raises(InputError, match=r"run\.nc: damaged or not a run file"):
        side_of_run(path, "flow", CHUTE)
