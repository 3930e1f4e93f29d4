"""The dataset of a study: all scalars and profiles, labelled, padded and opened by anyone."""

from pathlib import Path

import netCDF4
import numpy as np
import pytest
import xarray as xr

from sim.base.errors import InputError
from sim.dataset.build import build, profiles
from sim.dataset.gather import column_means, read_run
from sim.dataset.results import load_results
from sim.dataset.rows import OF_PROFILES, STATE_VARIABLES, Row, tabulate_rows
from sim.parameters import BeltParameters, ChuteParameters, point_id
from sim.parameters.variables import variables_of
from sim.study.load import load_study
from tests.made.figures import make_built_study
from tests.made.netcdf import ROUNDING, store
from tests.made.runs import FAILURE, HEIGHTS, is_hurt, is_lost, made_velocity, write_run


@pytest.fixture(scope="module")
def study_results(tmp_path_factory) -> tuple[Path, Path]:
    return make_built_study(tmp_path_factory.mktemp("made"))


@pytest.fixture(scope="module")
def dataset_path(study_results) -> Path:
    return study_results[1] / "made" / "dataset.nc"


@pytest.fixture(scope="module")
def dataset(dataset_path) -> xr.Dataset:
    with xr.open_dataset(dataset_path) as opened:
        return opened.load()


def test_scalars_are_those_of_the_runs_and_replicates_are_told_together_too(study_results, dataset):
    for point in load_study(*study_results).points.values():
        if is_lost(point.parameters) or is_hurt(point.parameters):
            continue
        mean, regime = made_velocity(point.parameters)
        row = dataset.sel(point=point.id)
        assert float(row["velocity"].mean()) == pytest.approx(mean, rel=2**-24)
        assert np.float32(row["velocity"]).tolist()[0] == row["velocity"].values[0]
        assert set(row["regime"].values[: point.parameters.replicates]) == {regime}
        assert float(row["point_velocity"]) == pytest.approx(mean, rel=2**-24)
        assert row["point_regime"].item() == regime
        # A velocity that grows is that of the window alone.
        quality = "drifting" if regime == "accelerating" else "reliable"
        assert row["point_quality"].item() == quality
        assert float(row["point_half_width"]) > 0.0


def test_failures_keep_their_whole_reason(study_results, dataset):
    lost = [p.id for p in load_study(*study_results).points.values() if is_lost(p.parameters)]
    assert len(lost) == 1
    row = dataset.sel(point=lost[0])
    assert list(row["status"].values[:2]) == ["failed", "failed"]
    assert list(row["reason"].values[:2]) == [FAILURE, FAILURE]
    assert np.isnan(row["velocity"].values).all()


def test_parameters_are_coordinates_with_units(dataset):
    chute, belt = dataset["system"] == "chute", dataset["system"] == "belt"
    assert set(ChuteParameters.model_fields) | set(BeltParameters.model_fields) <= {*dataset.coords}
    assert dataset["angle"].attrs["units"] == "degree"
    assert dataset["frequency"].attrs["units"] == "Hz"
    assert "units" not in dataset["stiffness"].attrs
    comment = "chute: N m-1; belt: 1; belt: multiple of g⟨m⟩/⟨d⟩"
    assert dataset["stiffness"].attrs["comment"] == comment
    assert np.isnan(dataset["frequency"].values[chute]).all()
    assert set(dataset["frequency"].values[belt]) == {10, 20, 50, 80}
    assert set(dataset["integrator"].values[belt]) == {"gear"}
    assert set(dataset["integrator"].values[chute]) == {""}
    assert dataset["velocity"].attrs["units"] == "m s-1"


def test_a_point_of_two_series_is_one_row_with_both(dataset):
    both = [series for series in dataset["series"].values if series == "depths rough"]
    assert len(both) == 2
    assert dataset.attrs["source_hash"] == "0123456789ab"


def test_a_file_that_is_not_the_run_of_its_name_is_refused(tmp_path):
    other = tmp_path / f"{point_id(ChuteParameters(depth=2))}.nc"
    write_run(tmp_path, ChuteParameters()).rename(other)
    with pytest.raises(InputError, match="holds point chute-depth5"):
        read_run(other)
    store(xr.Dataset({"depth": 1.0}), other)
    with pytest.raises(InputError, match=f"{other.name}: damaged or not a run file"):
        read_run(other)


def test_profiles_of_both_systems_lie_in_groups(study_results, dataset_path):
    results = load_results(dataset_path)
    study = load_study(*study_results)
    for point in study.points.values():
        if is_lost(point.parameters):
            continue
        values, height = results.profile(point.id, "velocity_profile")
        row = results.dataset.sel(point=point.id)
        lost = is_hurt(point.parameters)
        assert values.shape == (point.parameters.replicates - lost, HEIGHTS)
        assert height == pytest.approx((np.arange(HEIGHTS) + 0.5) * 1e-3)
        velocities = row["velocity"].values[np.isfinite(row["velocity"].values)]
        assert values.mean(axis=1) == pytest.approx(velocities, rel=ROUNDING)


def test_profiles_have_nine_binary_digits(dataset_path):
    values = xr.load_dataset(dataset_path, group="chute").velocity_profile.values
    mantissas = np.frexp(values[np.isfinite(values)])[0]
    assert mantissas.size > 0
    # The first of the digits is not stored, being a one.
    assert np.all(mantissas * 2**10 % 1 == 0)
    assert not np.all(mantissas * 2**8 % 1 == 0)


def test_columns_of_many_points_are_compressed_and_hold_the_same(
    study_results, dataset_path, tmp_path, monkeypatch
):
    monkeypatch.setattr("sim.dataset.build.LONG_COLUMN", 2)
    path = build(*study_results, finished=tmp_path / "dataset.nc")
    with netCDF4.Dataset(path) as stored:
        assert all(
            stored[name].filters()["zlib"] for name in ("friction", "series", "point_regime")
        )
    with xr.open_datatree(path) as one, xr.open_datatree(dataset_path) as other:
        xr.testing.assert_identical(one, other)


def test_belts_of_different_lengths_are_filled_up():
    rows = {}
    for name, width, slices, replicates in (("short", 3, 5, 2), ("long", 6, 4, 3)):
        squares = np.arange(width) + 0.5
        field = np.broadcast_to(squares[:, None], (replicates, width, 2))
        run = {"field_velocity": field, "field_density": np.ones_like(field)}
        run |= {"column": 1e-3 * squares, "level": [0.0, 1e-3]}
        arrays = {
            "height": 1e-3 * np.arange(slices),
            "number_density": np.ones((replicates, slices)),
        }
        rows[name] = Row(name, {}, arrays | column_means(run))
    dataset = profiles(tabulate_rows(rows, ["long", "short"], OF_PROFILES, 3))
    assert dataset.sizes == {"run": 2, "replicate": 3, "slice": 5, "square": 6}
    short = dataset.sel(run="short")
    assert short["column"].values[:3] == pytest.approx([0.5e-3, 1.5e-3, 2.5e-3])
    assert np.isnan(short["column"].values[3:]).all()
    assert short["column_velocity"].values[1, :3] == pytest.approx([0.5, 1.5, 2.5])
    assert np.isnan(short["column_velocity"].values[2]).all()
    assert np.isnan(dataset.sel(run="long")["height"].values[4:]).all()


def test_every_profile_and_what_pictures_show_of_particles_is_kept():
    rows = variables_of("profile").values()
    unread = {row.name for row in rows if not row.in_datasets}
    parts = ("number_density", "granular_temperature_profile", "vertical_temperature_profile")
    assert {name for name in unread if not name.endswith("_history")} == {
        f"{name}_instantaneous" for name in parts
    }
    assert variables_of("particle").keys() - set(STATE_VARIABLES) == {
        "particle_spin",
        "orientation",
    }
