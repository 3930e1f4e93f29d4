"""One point -> one run file: contract, averages, replicates, failures, bits, exit codes."""

import logging
from collections import Counter

import netCDF4
import numpy as np
import pytest

from sim.__main__ import main
from sim.engine.identity import NUMERICS, source_hash
from sim.engine.observe import regime
from sim.engine.run import BLOW_UP_CODE, run_point
from sim.parameters import as_yaml, canonical_values, field_info, parse_point, point_id
from sim.parameters.variables import recorded_by
from tests.engine_motion.points import belt_point, chute_point
from tests.golden import contents
from tests.made.netcdf import edit_file

CHUTE = {"depth": 1.24, "cell": 4, "transient": 3, "average": 5, "replicates": 2}
BELT = {"beads": 12, "width": 5, "transient": 1, "average": 4, "replicates": 2}
SOFT = {"depth": 5, "cell": 4, "stiffness": 0.2, "transient": 1, "average": 30}

ATTRIBUTES = {"Conventions", "title", "system", "point_id", "status", "reason", "command"}
ATTRIBUTES |= {"engine_version", "source_hash", "created", "versions", "steps", "wall_time"}


@pytest.fixture(scope="module", params=["chute", "belt"])
def ran(request, tmp_path_factory):
    """A point and its open run file."""
    point = chute_point(**CHUTE) if request.param == "chute" else belt_point(**BELT)
    path = tmp_path_factory.mktemp("run") / "run.nc"
    assert run_point(point, path, quiet=True) == 0
    with netCDF4.Dataset(path) as file:
        file.set_auto_mask(False)
        yield point, file


def test_variables_have_their_dimensions_and_units(ran):
    point, file = ran
    for name, row in recorded_by(point, "series", "profile", "scalar").items():
        assert file[name].dimensions == row.dims, name
        assert getattr(file[name], "units", "") == row.unit, name
    for name in recorded_by(point, "series"):
        assert np.isfinite(file[name][:]).all(), name
    assert (file["time"].units, file["height"].units) == ("s", "m")
    assert file["height"].positive == "up"
    for name, variable in file.variables.items():
        if variable.dtype not in (str, "S1") and name != "orientations":
            assert variable.units and variable.long_name, name


def test_sizes_are_those_of_the_point_and_replicates_independent_runs(ran):
    point, file = ran
    dimension = 3 if point.system == "chute" else 2
    assert file.dimensions["replicate"].size == 2
    assert file.dimensions["time"].size == point.transient_samples + point.average_samples
    assert file["position"].shape == (2, 2, point.particles, dimension)
    assert file["particle_velocity"].shape == file["position"].shape
    assert file["radius"].shape == (2, point.particles)
    assert "".join(file["axis"][:]) == ("xyz" if dimension == 3 else "xz")
    interval = point.sample_steps * point.time_step
    assert file["time"][:] == pytest.approx(interval * np.arange(1, file["time"].size + 1))
    assert file["average_start"][:] == pytest.approx(point.transient_samples * interval)
    assert (file["steps"][:] == point.steps).all()
    assert list(file["replicate_seed"][:]) == [0, 1]
    for name in ("mean_velocity", "position"):
        assert not np.allclose(file[name][0], file[name][1], rtol=1e-3)


def test_every_parameter_and_what_made_it_is_in_the_file(ran):
    point, file = ran
    rows, values = field_info(point), {}
    for name, value in canonical_values(point).items():
        found = file[name][...]
        values[name] = found if isinstance(value, str) else type(value)(found)
        assert file[name].long_name == rows[name].description
        assert getattr(file[name], "units", "") == rows[name].unit
    assert parse_point(values, "file") == point
    assert int(file["particles"][...]) == point.particles
    assert set(file.ncattrs()) >= ATTRIBUTES
    assert file.system == point.system and file.point_id == point_id(point)
    assert file.source_hash == source_hash()
    assert (file.status, file.reason, file.caveat) == ("completed", "", point.caveat)
    assert file.Conventions.startswith("CF-") and file.steps == 2 * point.steps


def test_scalars_are_the_averages_of_the_series(ran):
    point, file = ran
    velocity = file["mean_velocity"][:, point.transient_samples :]
    assert file["velocity"][:] == pytest.approx(velocity.mean(axis=1), rel=1e-12)
    assert file["max_overlap"][:] == pytest.approx(file["largest_overlap"][:].max(axis=1))
    period = point.samples_per_cycle if point.system == "belt" else 1
    interval = regime.mean(regime.cycle_means(velocity[0], period))
    for scalar in ("error", "half_width"):
        found = file[f"velocity_{scalar}"][0]
        assert found == pytest.approx(getattr(interval, scalar), rel=1e-9, nan_ok=True)
    if point.system == "chute":
        for scalar, series in (
            ("base_normal", "base_normal_force"),
            ("base_shear", "base_shear_force"),
        ):
            mean = file[series][:, point.transient_samples :].mean(axis=1)
            assert file[scalar][:] == pytest.approx(mean, rel=1e-12)


def test_snapshots_agree_with_series_and_radii(ran):
    """The last state is that at the end of the path, which begins after the last sample."""
    point, file = ran
    speed = 0.5 * (file["particle_velocity"][:, 1] ** 2).sum(axis=-1)
    mass = point.mass * (2 * file["radius"][:] / point.diameter) ** 2
    assert (mass * speed).sum(axis=1) == pytest.approx(file["kinetic_energy"][:, -1], rel=0.9)
    path, position = file["path"][:], file["position"][:, 1]
    side = (point.cell if point.system == "chute" else point.width) * point.diameter
    turns = (path[:, -1, :, 0] - position[..., 0]) / side
    assert turns == pytest.approx(np.round(turns), abs=1e-4)
    assert path[:, -1, :, -1] == pytest.approx(position[..., -1], abs=1e-6 * side)
    weight = mass / mass.sum(axis=1, keepdims=True)
    height = (weight * path[:, 0, :, -1]).sum(axis=1)
    last = file["height_of_mass"][:, -1]
    assert height == pytest.approx(last, rel=0.3 if point.system == "belt" else 1e-5)
    assert not np.array_equal(file["position"][:, 0], file["position"][:, 1])
    if point.system == "chute":
        norm = np.linalg.norm(file["orientation"][:], axis=-1)
        assert norm == pytest.approx(1.0, abs=1e-12)
        assert (file["orientation"][:, 0, :, 0] == 1.0).all()


def test_a_blow_up_is_recorded_with_its_reason_and_what_came_before(tmp_path):
    point = chute_point(**SOFT | {"replicates": 2})
    assert run_point(point, tmp_path / "run.nc", quiet=True) == BLOW_UP_CODE == 3
    assert run_point(point, tmp_path / "run.nc", quiet=True, record_failure=True) == 0
    held = contents(tmp_path / "run.nc")
    assert list(held["status"]) == ["failed"] * 2
    assert all("overlap exceeds overlap_limit at step" in text for text in held["reason"])
    assert np.isnan(held["velocity"]).all() and list(held["regime"]) == ["undetermined"] * 2
    taken = np.isfinite(held["mean_velocity"][0])
    assert (held["time_step_used"] == point.time_step / 2).all()
    steps = held["steps"][0] // (2 * point.sample_steps)
    assert taken.sum() == steps and taken[:steps].all()
    assert np.isfinite(held["position"]).all()
    bed = belt_point(**BELT | {"beads": 100, "stiffness": 1.0})
    assert run_point(bed, tmp_path / "bed.nc", quiet=True) == BLOW_UP_CODE
    held = contents(tmp_path / "bed.nc")
    for reason in held["reason"]:
        first, second = reason.split("; with half the time step: ")
        assert "while the bed settles" in first and "while the bed settles" in second
        assert first != second
    assert (held["steps"] == 0).all() and np.isnan(held["mean_velocity"]).all()


def test_the_command_gives_exit_code_three_or_none_if_the_failure_is_wanted(tmp_path, capsys):
    (tmp_path / "point.yaml").write_text(as_yaml(chute_point(**SOFT)))
    command = ["run", str(tmp_path / "point.yaml"), "-o", str(tmp_path / "run.nc"), "--quiet"]
    assert [main(command), main(command), main([*command, "--record-failure"])] == [3, 3, 0]


def test_the_last_line_counts_the_regimes_of_the_replicates(tmp_path, caplog):
    point = belt_point(beads=12, width=5, frequency=40, transient=1, average=12, replicates=6)
    caplog.set_level(logging.INFO)
    run_point(point, tmp_path / "run.nc", quiet=True)
    counts = Counter(contents(tmp_path / "run.nc")["regime"]).most_common()
    assert sum(count for _, count in counts) == 6 and len(counts) > 1
    told = ", ".join(f"{count} {regime}" for regime, count in counts)
    assert caplog.messages[-2].endswith(f" m/s; 6 replicates, each by itself: {told}")


def test_a_run_file_of_the_same_point_is_kept_and_no_other(tmp_path, capsys):
    point, other = (belt_point(**BELT | {"seed": seed}) for seed in (1, 2))
    output = tmp_path / "run.nc"

    def made_anew(point) -> bool:
        before = output.stat().st_ino if output.exists() else None
        (tmp_path / "point.yaml").write_text(as_yaml(point))
        assert main(["run", str(tmp_path / "point.yaml"), "-o", str(output), "--quiet"]) == 0
        return output.stat().st_ino != before

    assert made_anew(point)
    assert not made_anew(point)
    assert made_anew(other)
    whole = output.read_bytes()
    output.write_bytes(whole[: len(whole) // 2])
    assert made_anew(other)
    with edit_file(output) as file:
        file.source_hash = "0123456789ab"
        file.versions = "numpy 1.0"
    assert not made_anew(other)
    with edit_file(output) as file:
        file.numerics = NUMERICS + 1
    assert made_anew(other)
    # Engines before the first number are known by the hash of their sources.
    for source, anew in (("0b14a980090c", False), ("0123456789ab", True)):
        with edit_file(output) as file:
            if "numerics" in file.ncattrs():
                file.delncattr("numerics")
            file.source_hash = source
        assert made_anew(other) == anew
