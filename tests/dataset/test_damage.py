"""Full disks, holes and flipped bits: one clear line, nothing lost, no wrong number read."""

import errno
import json
import os
import resource
import subprocess
from functools import partial
from pathlib import Path
from unittest.mock import Mock

import pytest

from sim.base.errors import InputError
from sim.base.files import file_lock
from sim.base.seals import DamagedError
from sim.dataset.gather import read_run
from sim.engine.command import warm
from sim.engine.run import run_point
from sim.engine.run_file import read_stored_run
from sim.engine.stored_run import current_status
from sim.parameters import canonical_values, point_id
from tests.engine.test_states import assert_same
from tests.engine_motion.points import belt_point
from tests.figures.drawing import draw
from tests.made.figures import make_figures
from tests.made.processes import ROOT, program, start_run

POINT = belt_point(beads=20, width=5, transient=1, average=3)
LONG = belt_point(beads=200, transient=2, average=10)


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


def test_a_file_of_another_length_is_never_read(content, path):
    """Flipped bits are tried in `tests/drills/test_bit_flips.py`."""
    end = content.rindex(b'\n{"attributes":')
    last = {len(content) - cut for cut in (*range(1, 83), 100, 1000)}
    lengths = {0, 1, 7, 8, 100, end - 26, end // 2, end // 3} | last
    aside = path.with_name(f"{path.name}.damaged")
    for damaged in (*(content[:length] for length in lengths), content + b"\n"):
        path.write_bytes(damaged)
        with pytest.raises(DamagedError, match=f"^{path}: damaged"):
            read_run(path)
        assert not path.exists() and aside.read_bytes() == damaged
        aside.unlink()


def test_an_error_of_the_system_is_no_damage(content, path, monkeypatch):
    path.write_bytes(content)

    def fail(*_: object, **__: object) -> int:
        raise OSError(errno.ESTALE, "the system says no", str(path))

    with monkeypatch.context() as patch:
        patch.setattr("sim.base.files.os.open", fail)
        readers = (
            partial(current_status, parameters=POINT),
            partial(read_stored_run, parameters=POINT),
        )
        for read in (read_run, *readers):
            with pytest.raises(OSError, match="the system says no"):
                read(path)
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
