"""Datasets older than some parameters have all parameters when they are read."""

import numpy as np
import pytest
import xarray as xr

from sim.dataset.results import added_columns, load_results
from sim.parameters import SYSTEMS, defaults_of_added
from tests.test_published import STUDIES


def test_rows_without_a_value_get_the_default_of_their_system():
    columns = added_columns(
        {
            "system": np.array(["belt", "chute", "belt"], object),
            "slice_height": np.array([np.nan, 0.25, 0.5]),
            "ghost_mass": np.array(["", "", "mean"], object),
        }
    )
    assert columns["slice_height"].tolist() == [1.0, 0.25, 0.5]
    assert columns["ghost_mass"].tolist() == ["infinite", "", "mean"]
    assert columns["corrector_order"][[0, 2]].tolist() == [5.0, 5.0]
    assert np.isnan(columns["corrector_order"][1])


@pytest.mark.parametrize("system", SYSTEMS)
def test_rows_of_one_system_from_before_all_get_its_own_defaults_alone(system):
    columns = added_columns({"system": np.array([system] * 2)})
    assert {name: values.tolist() for name, values in columns.items()} == {
        name: [default] * 2 for name, default in defaults_of_added(system).items()
    }


def test_what_is_published_has_every_parameter_of_today():
    for study in STUDIES:
        with xr.open_dataset(study / "dataset.nc") as held:
            before = set(held.coords)
        dataset = load_results(study / "dataset.nc").dataset
        for system in set(dataset["system"].values):
            assert set(SYSTEMS[system].model_fields) <= set(dataset.coords)
            for name, default in defaults_of_added(system).items():
                if name not in before:
                    assert (dataset[name].values == default).all()
