"""Several points in one process: each has its own run file and log, and its own misfortune."""

import json
import os

import pytest

from sim.parameters import canonical_values, parse_point, point_id
from tests.golden import digest
from tests.made.processes import program, run_command

BELT = {"system": "belt", "beads": 10, "width": 5, "transient": 1, "average": 2}
POINTS = [BELT, BELT | {"seed": 2}, BELT | {"overlap_limit": 1e-6}]
IDS = [point_id(parse_point(point, "test")) for point in POINTS]


def batch(folder, points, **options):
    return program("batch", str(folder), input=json.dumps(points), **options)


def complete(points):
    return [canonical_values(parse_point(point, "test")) for point in points]


@pytest.fixture(scope="module")
def finished_batch(tmp_path_factory):
    folder = tmp_path_factory.mktemp("batch")
    return folder, batch(folder, complete(POINTS))


def test_each_point_has_its_run_file_and_log(finished_batch):
    folder, process = finished_batch
    assert (process.returncode, process.stdout, process.stderr) == (0, "", "")
    for name, ending in zip(IDS, ("undetermined", "undetermined", "failed"), strict=True):
        log = (folder / "logs" / "runs" / f"{name}.log").read_text()
        assert log.startswith(f"{name}: 10 particles") and ending in log
        assert log.endswith(f"runs/{name}.nc: written\n")
        assert not any(other in log for other in IDS if other != name)
    expected = {file for name in IDS for file in (f"{name}.nc", f".{name}.nc.state")}
    assert {path.name for path in (folder / "runs").iterdir()} == expected


def test_a_point_in_a_batch_has_the_bits_of_one_alone(finished_batch, tmp_path):
    folder, _ = finished_batch
    output = tmp_path / f"{IDS[1]}.nc"
    alone = program(*run_command(output)[3:], input=json.dumps(complete(POINTS)[1]))
    assert alone.returncode == 0, alone.stderr
    assert digest(output) == digest(folder / "runs" / output.name)


def test_what_is_current_is_left_and_the_rest_is_run(finished_batch):
    folder, _ = finished_batch
    files = [folder / "runs" / f"{name}.nc" for name in IDS]
    files[1].unlink()
    before = files[0].stat().st_mtime_ns
    assert batch(folder, complete(POINTS)).returncode == 0
    assert files[0].stat().st_mtime_ns == before
    assert files[1].exists()
    assert "already there" in (folder / "logs" / "runs" / f"{IDS[0]}.log").read_text()


def test_one_that_no_machine_can_compute_keeps_no_other_from_it(tmp_path):
    points = complete([BELT | {"width": 1e13}, BELT])
    process = batch(tmp_path, points)
    assert process.returncode == 1
    assert (tmp_path / "runs" / f"{IDS[0]}.nc").exists()
    (log,) = (path for path in (tmp_path / "logs" / "runs").iterdir() if path.stem != IDS[0])
    assert "cannot be computed" in log.read_text()
    assert process.stderr.startswith("error: ") and "cannot be computed" in process.stderr


def test_an_error_of_the_program_is_in_the_log(tmp_path):
    (tmp_path / "runs" / f"{IDS[0]}.nc").mkdir(parents=True)
    process = batch(tmp_path, complete([BELT]), env=os.environ | {"TALUS_CHECKPOINT_SECONDS": "60"})
    assert process.returncode == 1
    log = tmp_path / "logs" / "runs" / f"{IDS[0]}.log"
    assert "Traceback" in log.read_text()
    assert str(log) in process.stderr
