"""Writing a run file: all of it or nothing."""

from types import SimpleNamespace

import netCDF4
import numpy as np
import pytest

from sim.engine import run_file
from sim.engine.systems.recorder import Record
from sim.parameters.variables import variables_of
from tests.engine_motion.points import chute_point

SERIES = {"mean_velocity": variables_of("series")["mean_velocity"]}
INTERVAL = chute_point().sample_steps * chute_point().time_step
SYSTEM = SimpleNamespace(
    profile_height=np.arange(2.0), series=SERIES, axes=("x", "y", "z"), coordinates={}
)


def record() -> Record:
    snapshot = {"position": [np.zeros((1, 3))] * 2, "radius": [np.ones(1)] * 2}
    series, profiles = {"mean_velocity": np.arange(3.0)}, {"velocity_profile": np.ones(2)}
    scalars = {"regime": "steady", "velocity": 1.0}
    return Record(series, profiles, snapshots=snapshot, scalars=scalars)


def write(path, records=None, system=SYSTEM, title="t", point=None):
    run = run_file.StoredRun(point or chute_point(), records or [record()])
    run_file.write(path, run, system, {"title": title})


def test_a_file_holds_what_it_was_given_and_shorter_replicates_are_padded(tmp_path):
    short = record()
    short.series = {"mean_velocity": np.arange(2.0)}
    write(tmp_path / "run.nc", title="old")
    write(tmp_path / "run.nc", [record(), short])
    with netCDF4.Dataset(tmp_path / "run.nc") as file:
        assert file.title == "t"
        assert file["mean_velocity"].units == "m s-1"
        file.set_auto_mask(False)
        expected = [[0.0, 1.0, 2.0], [0.0, 1.0, np.nan]]
        assert np.array_equal(file["mean_velocity"][:], expected, equal_nan=True)
        assert file["time"][:] == pytest.approx(INTERVAL * np.arange(1, 4), rel=1e-14)
        assert file["regime"][0] == "steady" and file["overlap_memory"][...] == "separation"
        assert list(file["frame"][:]) == ["first", "last"]
    assert [path.name for path in tmp_path.iterdir()] == ["run.nc"]


def test_tables_and_paths_bring_their_own_dimensions(tmp_path):
    traced, failed = record(), record()
    traced.path = np.arange(6.0).reshape(2, 1, 3)
    coordinates = {
        "column": ("m", "", np.arange(4.0)),
        "level": ("m", "", np.arange(5.0)),
        "path_time": ("s", "", np.arange(2.0)),
    }
    for one in (traced, failed):
        one.tables = {"field_velocity": np.ones((4, 5))}
    system = SimpleNamespace(**vars(SYSTEM) | {"coordinates": coordinates})
    write(tmp_path / "run.nc", [traced, failed], system)
    with netCDF4.Dataset(tmp_path / "run.nc") as file:
        file.set_auto_mask(False)
        assert file["field_velocity"].dimensions == ("replicate", "column", "level")
        assert np.array_equal(file["path"][0], traced.path) and np.isnan(file["path"][1]).all()
        assert file["path"].dtype == np.float32
        assert np.array_equal(file["level"][:], np.arange(5.0))


def test_frames_that_a_replicate_lacks_are_no_numbers(tmp_path):
    whole, failed = record(), record()
    whole.frames = {"trajectory_position": np.full((3, 1, 3), np.arange(3)[:, None, None])}
    failed.frames = {"trajectory_position": np.ones((2, 1, 3))}
    point = chute_point(trajectory=0.25)
    write(tmp_path / "run.nc", [whole, failed, record()], point=point)
    with netCDF4.Dataset(tmp_path / "run.nc") as file:
        file.set_auto_mask(False)
        held = file["trajectory_position"]
        dimensions = ("replicate", "trajectory_time", "particle", "axis")
        assert (held.dimensions, held.units) == (dimensions, "m")
        nan = np.nan
        expected = [[0, 1, 2], [1, 1, nan], [nan, nan, nan]]
        assert np.array_equal(held[:, :, 0, 0], expected, equal_nan=True)
        assert held.chunking() == [1, 3, 1, 3] and held.filters()["zlib"]
        assert file["trajectory_time"][:] == pytest.approx(INTERVAL * np.arange(1, 4), rel=1e-14)
        assert "trajectory_spin" not in file.variables


def test_a_failing_write_leaves_no_file_and_an_old_one_alone(tmp_path):
    broken = record()
    broken.series = {}
    with pytest.raises(KeyError):
        write(tmp_path / "run.nc", [broken])
    assert not list(tmp_path.iterdir())
    write(tmp_path / "run.nc")
    before = (tmp_path / "run.nc").read_bytes()
    with pytest.raises(KeyError):
        write(tmp_path / "run.nc", [broken])
    assert (tmp_path / "run.nc").read_bytes() == before
    assert len(list(tmp_path.iterdir())) == 1
