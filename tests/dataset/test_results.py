"""Results of a study: groups are read once, at first access, and profiles lie on grids."""

from pathlib import Path

import netCDF4
import numpy as np
import pytest
import xarray as xr

from sim.base.errors import InputError
from sim.dataset import results
from sim.dataset.grids import GRIDS, regrid
from sim.dataset.results import added_columns, load_results
from sim.parameters import SYSTEMS, defaults_of_added
from tests.made.netcdf import store
from tests.made.results import made_point, made_results
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
    groups, load = [], results.open_group

    def record(file: netCDF4.Dataset, group: str | None) -> xr.Dataset:
        groups.append(group)
        return load(file, group)

    monkeypatch.setattr(results, "open_group", record)
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
    with pytest.raises(InputError, match=r"^c: no particles in the dataset$"):
        study_results.particles("c")
    with pytest.raises(KeyError):
        study_results.profiles["chute"]


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


BEAD = 1e-3
HALVES = (np.arange(12) + 0.5) * BEAD / 2

#: Heights (⟨d⟩) and velocities of beads above the belt.
BEADS = np.array([0.1, 0.4, 0.6, 0.6, 1.2, 1.6, 1.9, 2.1, 2.4, 5.9])
SPEEDS = np.array([1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0])


def count_beads(edges):
    """Number and mean velocity of the beads between edges (⟨d⟩)."""
    number = np.histogram(BEADS, edges)[0].astype(float)
    moved = np.histogram(BEADS, edges, weights=SPEEDS)[0]
    with np.errstate(invalid="ignore"):
        return number, moved / number


@pytest.fixture
def halves():
    """Number density per half slice, and the mean velocity there, of one replicate."""
    number, velocity = count_beads(np.arange(13) / 2)
    return number[None] / 0.5, velocity[None]


@pytest.mark.parametrize(
    ("grid", "edges", "places"),
    [
        ("centres", np.arange(7), np.arange(6) + 0.5),
        ("edges", np.arange(7), np.arange(6)),
        ("points", np.arange(-0.5, 6), np.arange(6)),
    ],
)
def test_halves_add_up_to_what_counting_on_the_grid_gives(halves, grid, edges, places):
    number, velocity = count_beads(edges)
    density, height = regrid(grid, BEAD, HALVES, "number_density", halves[0], None)
    assert density[0] == pytest.approx(number)
    assert height == pytest.approx(places * BEAD)
    found, height = regrid(grid, BEAD, HALVES, "velocity_profile", halves[1], halves[0])
    assert found[0] == pytest.approx(velocity, nan_ok=True)
    assert height == pytest.approx(places * BEAD)


def test_slices_of_a_diameter_are_two_of_the_grids_as_they_are():
    height, values = (np.arange(6) + 0.5) * BEAD, np.arange(6.0)[None]
    found, places = regrid("centres", BEAD, height, "packing_profile", values, None)
    assert found is values and places is height
    found, places = regrid("edges", BEAD, height, "packing_profile", values, None)
    assert np.array_equal(found, values) and places == pytest.approx(height - BEAD / 2)
    with pytest.raises(ValueError, match="grid of points: its slices are 1 ⟨d⟩"):
        regrid("points", BEAD, height, "packing_profile", values, None)


@pytest.mark.parametrize("thickness", [0.4, 2.0])
def test_slices_that_do_not_fill_the_cells_are_refused(thickness):
    height, values = (np.arange(6) + 0.5) * thickness * BEAD, np.ones((1, 6))
    for grid in GRIDS[:3]:
        with pytest.raises(ValueError, match=f"its slices are {thickness:g}"):
            regrid(grid, BEAD, height, "number_density", values, None)
    assert regrid("slices", BEAD, height, "number_density", values, None) == (values, height)


def test_what_is_not_known_stays_unknown():
    blank = np.full((2, 12), np.nan)
    for name in ("number_density_at_phase_0", "velocity_profile_at_phase_0"):
        assert np.isnan(regrid("points", BEAD, HALVES, name, blank, blank)[0]).all()
    with pytest.raises(ValueError, match="it needs the number density"):
        regrid("points", BEAD, HALVES, "velocity_profile", blank, None)


def test_results_give_any_run_on_the_grid_that_is_asked_for():
    thin = made_point(
        "belt",
        {"velocity": 0.1},
        {"number_density": lambda z: 1e6 * (z < 3e-3), "velocity_profile": lambda z: z},
        replicates=1,
        height=HALVES,
        slice_height=0.5,
    )
    usual = made_point(
        "belt",
        {"velocity": 0.1},
        {"number_density": lambda z: 1e6 * (z < 3e-3)},
        replicates=1,
        height=(np.arange(6) + 0.5) * BEAD,
    )
    results = made_results(thin, usual)
    for point in (thin, usual):
        density, height = results.profile(point.id, "number_density")
        assert height == pytest.approx((np.arange(6) + 0.5) * BEAD)
        assert density[0] == pytest.approx([1e6] * 3 + [0] * 3)
    density, height = results.profile(thin.id, "number_density", grid="points")
    assert density[0] == pytest.approx([5e5, 1e6, 1e6, 5e5, 0, 0])
    velocity, _ = results.profile(thin.id, "velocity_profile", grid="points")
    assert velocity[0, :4] == pytest.approx([0.25e-3, 1e-3, 2e-3, 2.75e-3])
    assert results.profile(thin.id, "number_density", grid="slices")[1] == pytest.approx(HALVES)
    with pytest.raises(InputError, match=f"{usual.id}: number_density is not known on the grid"):
        results.profile(usual.id, "number_density", grid="points")
