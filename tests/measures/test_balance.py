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


#: What a flow has, and the share that it lacks.
FLOWS = {
    "steady": ({}, 0.008),
    # 10 g at 2 m/s that gain 0.6 m/s² take up 12 mW beside the 4 mW dissipated.
    "gains": ({"acceleration": 0.6}, 0.008 / 4),
    "loses": ({"acceleration": -0.6}, 0.008),
    "rests": ({"velocity": 0.0, "frictional_power": 0.0, "normal_power": 0.0}, 0.008),
}


@pytest.mark.parametrize("case", FLOWS)
def test_what_a_flow_gains_is_turned_over_as_well_as_what_it_dissipates(case):
    scalars, expected = FLOWS[case]
    assert missing_energy(flow(**scalars)) == pytest.approx(expected)


def test_belts_turn_over_what_the_file_says_and_files_without_a_ledger_nothing():
    assert missing_energy(flow().drop_vars("frictional_power")) == pytest.approx(0.008)
    assert np.isnan(missing_energy(flow().drop_vars("energy_residual")))
