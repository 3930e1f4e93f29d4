"""The share of the energy turned over that the ledger of a replicate lacks."""

import numpy as np
import pytest
import xarray as xr

from sim.measures.layers import missing_energy


def flow(**scalars) -> xr.Dataset:
    """Return ten spheres of 1 g at 2 m/s whose ledger lacks 0.8 % of the dissipated energy."""
    usual = {"particles": 10, "mass": 1e-3, "velocity": 2.0, "acceleration": 0.0}
    powers = {"frictional_power": 0.003, "normal_power": 0.001, "energy_residual": -0.008}
    return xr.Dataset(usual | powers | scalars)


def test_steady_flows_turn_over_what_they_dissipate():
    assert missing_energy(flow()) == pytest.approx(0.008)


def test_what_a_flow_gains_is_turned_over_as_well():
    # 10 g at 2 m/s that gain 0.6 m/s² take up 12 mW beside the 4 mW dissipated.
    assert missing_energy(flow(acceleration=0.6)) == pytest.approx(0.008 / 4)


def test_what_a_flow_loses_does_not_count():
    assert missing_energy(flow(acceleration=-0.6)) == pytest.approx(0.008)


def test_flows_at_rest_keep_the_ledger_of_their_whole_run():
    still = {"velocity": 0.0, "frictional_power": 0.0, "normal_power": 0.0}
    assert missing_energy(flow(**still)) == pytest.approx(0.008)


def test_belts_turn_over_what_the_file_says():
    belt = flow().drop_vars("frictional_power")
    assert missing_energy(belt) == pytest.approx(0.008)


def test_files_without_a_ledger_have_no_measure():
    assert np.isnan(missing_energy(flow().drop_vars("energy_residual")))
