"""Full disks, holes and flipped bits: one clear line, nothing lost, no wrong number read."""

import errno
import json
import os
import random
import resource
import subprocess
import threading
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from unittest.mock import Mock

import numpy as np
import pytest

from sim.base.errors import InputError
from sim.base.files import file_lock
from sim.base.seals import DamagedError
from sim.dataset.gather import read_run
from sim.engine.command import warm
from sim.engine.run import run_point
from sim.engine.run_file import read_stages
from sim.engine.stored_run import current_status
from sim.parameters import canonical_values, point_id
from tests.engine.test_states import assert_same
from tests.engine_motion.points import belt_point
from tests.figures.drawing import draw
from tests.made.figures import make_figures
from tests.made.processes import ROOT, program, refusal, start_run, wait_until

POINT = belt_point(beads=20, width=5, transient=1, average=3)
LONG = belt_point(beads=200, transient=2, average=10)
OFFSETS = 120


@pytest.fixture(scope="module")
def content(tmp_path_factory) -> bytes:
    """The bytes of a run file."""
    path = tmp_path_factory.mktemp("run") / "run.nc"
    assert run_point(POINT, path, quiet=True) == 0
    return path.read_bytes()


@pytest.fixture
def path(tmp_path) -> Path:
    """The name that the run file has in a study."""
    return tmp_path / f"{point_id(POINT)}.nc"


def assert_refused_or_true(path: Path, content: bytes, expected) -> bool:
    """Assert that a file is set aside or read correctly; return whether it was refused."""
    path.write_bytes(content)
    aside = path.with_name(f"{path.name}.damaged")
    try:
        row = read_run(path)
    except DamagedError as error:
        assert str(error).startswith(f"{path}: damaged") and "\n" not in str(error)
        assert not path.exists() and aside.read_bytes() == content
        aside.unlink()
        return True
    assert path.exists() and row.values.keys() == expected.values.keys()
    for name, values in row.values.items():
        np.testing.assert_array_equal(values, expected.values[name])
    return False


def flipped_bits(content: bytes) -> Iterator[bytes]:
    flips = random.Random(1)
    for _ in range(OFFSETS):
        changed = bytearray(content)
        changed[flips.randrange(len(content))] ^= 1 << flips.randrange(8)
        yield bytes(changed)


def holes(content: bytes) -> Iterator[bytes]:
    for share in (0.05, 0.3, 0.5, 0.9):
        begin = int(share * len(content))
        yield content[:begin] + bytes(512) + content[begin + 512 :]


def other_lengths(content: bytes) -> Iterator[bytes]:
    end = content.rindex(b'\n{"attributes":')
    last = {len(content) - cut for cut in (*range(1, 83), 100, 1000)}
    for length in {0, 1, 7, 8, 100, end - 26, end // 2, end // 3} | last:
        yield content[:length]
    yield content + b"\n"


@pytest.mark.parametrize(("damage", "spared"), [(flipped_bits, 1), (holes, 4), (other_lengths, 0)])
def test_damage_is_never_read(damage, spared, content, path):
    """A flip in the few letters that announce the checksum does no harm, nor a hole in zeros."""
    path.write_bytes(content)
    expected = read_run(path)
    refused = [assert_refused_or_true(path, damaged, expected) for damaged in damage(content)]
    assert refused.count(False) <= spared


@pytest.mark.parametrize("name", ["EACCES", "EIO", "ESTALE", "EMFILE", "ENOMEM"])
def test_an_error_of_the_system_is_no_damage(name, content, path, monkeypatch):
    path.write_bytes(content)

    def fail(*_: object, **__: object) -> int:
        raise OSError(getattr(errno, name), "the system says no", str(path))

    with monkeypatch.context() as patch:
        patch.setattr("sim.base.files.os.open", fail)
        for read in (read_run, partial(current_status, parameters=POINT)):
            with pytest.raises(OSError, match="the system says no"):
                read(path)
        with pytest.raises(OSError, match="the system says no"):
            read_stages(path, POINT)
    assert path.read_bytes() == content and len(list(path.parent.iterdir())) == 1
    read_run(path)


def test_what_a_library_cannot_read_of_a_whole_file_stays(content, path, monkeypatch):
    path.write_bytes(content)
    failing = Mock(side_effect=RuntimeError("NetCDF: HDF error"))
    with monkeypatch.context() as patch, pytest.raises(OSError, match="its checksum is right"):
        patch.setattr("sim.dataset.gather.netCDF4.Dataset", failing)
        read_run(path)
    assert path.read_bytes() == content and len(list(path.parent.iterdir())) == 1


@pytest.fixture
def study_results(tmp_path) -> tuple[Path, Path]:
    """A study with its run files, dataset and figures."""
    return make_figures(tmp_path)


def test_all_damaged_runs_of_a_study_are_set_aside_at_once(study_results, monkeypatch, capsys):
    study, results = study_results
    monkeypatch.chdir(results.parent)
    runs = sorted((results / "made" / "runs").iterdir())
    before = (results / "made" / "dataset.nc").read_bytes()
    runs[0].write_bytes(runs[0].read_bytes()[:1000])
    runs[3].write_bytes(b"")
    line = refusal(capsys, "dataset", study)
    assert "rerun the study" in line and "1 more" in line
    assert not runs[0].exists() and not runs[3].exists()
    assert all(run.exists() for run in (*runs[1:3], *runs[4:]))
    assert (results / "made" / "dataset.nc").read_bytes() == before


def test_a_file_named_by_mistake_is_left_where_it_is(tmp_path, content):
    half = content[: len(content) // 2]
    for name, text in (("notes.txt", b"mine"), ("run.nc", content), ("dataset.nc", half)):
        (tmp_path / name).write_bytes(text)
        with pytest.raises(InputError, match="not "):
            draw("walton_2", tmp_path / name, tmp_path)
        assert (tmp_path / name).read_bytes() == text


def run_with_limit(output: Path, size: int | None) -> subprocess.CompletedProcess:
    """Run LONG in a process that cannot write files longer than ``size`` bytes: a full disk."""
    limit = (size, size) if size else (resource.RLIM_INFINITY, resource.RLIM_INFINITY)
    return program(
        *("run", "-", "--output", str(output), "--quiet"),
        input=json.dumps(canonical_values(LONG)),
        env=os.environ | {"TALUS_CHECKPOINT_SECONDS": "0", "PYTHONDONTWRITEBYTECODE": "1"},
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, limit) if size else None,
    )


def test_a_full_disk_ends_in_one_line_and_a_rerun_repairs_it(tmp_path):
    warm([LONG])
    output = tmp_path / "run.nc"
    done = run_with_limit(output, 20_000)
    assert done.returncode == 1, done.stderr
    lines = done.stderr.splitlines()
    assert (
        all("no states are kept: File too large" in line for line in lines[:-1]) and len(lines) > 1
    )
    assert lines[-1].startswith("error: ") and "Traceback" not in done.stderr
    assert not list(tmp_path.iterdir())
    again = run_with_limit(output, None)
    assert (again.returncode, again.stderr) == (0, "")
    assert {path.name for path in tmp_path.iterdir()} == {"run.nc", ".run.nc.state"}


@pytest.mark.parametrize(
    ("command", "name", "size"),
    [("dataset", "dataset.nc", 20_000), ("figure", "figures/walton_2", 3000)],
)
def test_a_full_disk_is_told_with_the_name_of_the_file(study_results, command, name, size):
    study, results = study_results
    path = results / "made" / name
    words = {
        "dataset": [str(study)],
        "figure": ["walton_2", str(results / "made/dataset.nc"), "--output", str(path.parent)],
    }
    before = {file: file.read_bytes() for file in results.rglob("*") if file.is_file()}
    done = program(
        *(command, *words[command]),
        # Compiled modules would be cut off, too, and stay so.
        env=os.environ | {"PYTHONDONTWRITEBYTECODE": "1", "PYTHONPATH": str(ROOT)},
        cwd=results.parent,
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (size, size)),
    )
    assert done.returncode == 1
    assert done.stderr.splitlines()[-1].startswith("error: ")
    assert f"made/{name}" in done.stderr.splitlines()[-1], done.stderr
    assert {file: file.read_bytes() for file in results.rglob("*") if file.is_file()} == before


def test_two_processes_of_one_run_do_not_meet(tmp_path):
    warm([LONG])
    output = tmp_path / "run.nc"
    with file_lock(output):
        pair = [start_run(LONG, output) for _ in range(2)]
        for process in pair:
            while "waiting for another process" not in (said := process.stderr.readline()):
                assert said, "ended without waiting"
    errors = [process.stderr.read() for process in pair]
    assert [process.wait() for process in pair] == [0, 0], errors
    assert sum(f"{output}: written" in text for text in errors) == 1
    assert {path.name for path in tmp_path.iterdir()} == {"run.nc", ".run.nc.state"}
    assert run_point(LONG, tmp_path / "alone.nc", quiet=True) == 0
    assert_same(output, tmp_path / "alone.nc")


def test_who_waits_computes_what_the_other_did_not_finish(tmp_path, caplog):
    warm([POINT])
    output = tmp_path / "run.nc"
    with file_lock(output):
        waiting = threading.Thread(target=run_point, args=(POINT, output, True))
        waiting.start()
        wait_until(lambda: "waiting for another" in caplog.text or not waiting.is_alive())
        assert waiting.is_alive() and not output.exists()
    waiting.join()
    assert output.exists()
