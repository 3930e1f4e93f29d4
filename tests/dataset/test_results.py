"""Results of a study: groups are read once, at first access, and files are closed."""

from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from sim.base.errors import InputError
from sim.dataset import results
from sim.dataset.results import added_columns, load_results
from sim.parameters import SYSTEMS, defaults_of_added
from tests.made.netcdf import store
from tests.test_published import STUDIES


@pytest.fixture
def dataset(tmp_path) -> Path:
    path = tmp_path / "dataset.nc"
    points = {
        "point": ["a", "b"],
        "figures": ("point", ["", ""]),
        "system": ("point", ["belt"] * 2),
    }
    store(xr.Dataset({"status": ("point", ["completed"] * 2)}, points), path)
    for group in ("belt", "states/a", "states/b"):
        store(xr.Dataset({"x": ("i", [1.0, 2.0])}), path, mode="a", group=group)
    return path


@pytest.fixture
def groups_read(monkeypatch) -> list[str | None]:
    """Return the groups in the order in which they were read."""
    groups, load = [], results._load_group

    def record(path: Path, group: str | None) -> xr.Dataset:
        groups.append(group)
        return load(path, group)

    monkeypatch.setattr(results, "_load_group", record)
    return groups


def test_profiles_and_particles_are_read_when_they_are_asked_for_and_once(dataset, groups_read):
    study_results = load_results(dataset)
    assert (list(study_results.states), list(study_results.profiles)) == (["a", "b"], ["belt"])
    assert "a" in study_results.states
    assert "c" not in study_results.states
    assert groups_read == [None]
    assert study_results.particles("b") is study_results.particles("b")
    assert list(study_results.profiles["belt"]["x"]) == [1, 2]
    assert groups_read == [None, "states/b", "belt"]


def test_a_point_or_a_group_that_is_not_there_is_refused(dataset):
    study_results = load_results(dataset)
    with pytest.raises(InputError, match=r"^c: no particles in the dataset$"):
        study_results.particles("c")
    with pytest.raises(KeyError):
        study_results.profiles["chute"]


def test_a_system_that_is_none_is_refused(dataset):
    with pytest.raises(InputError, match=r"of: system: got 'blet'; allowed: one of chute, belt"):
        load_results(dataset).of("blet")


def test_a_dataset_that_is_gone_when_its_particles_are_asked_for_is_named(dataset):
    study_results = load_results(dataset)
    dataset.unlink()
    with pytest.raises(InputError, match=r"dataset\.nc: no such dataset"):
        study_results.particles("a")


def test_a_dataset_can_be_written_again_once_it_is_read(dataset):
    study_results = load_results(dataset)
    study_results.particles("a")
    store(xr.Dataset({"x": ("i", [3.0, 4.0])}), dataset, mode="a", group="states/b")
    assert list(study_results.particles("b")["x"]) == [3, 4]


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
