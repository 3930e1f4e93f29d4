"""Several processes, or the workers of a cluster, read the same rows as one process."""

import subprocess
import sys
import threading
from pathlib import Path

import numpy as np
import psutil
import pytest

from sim.base.errors import InputError
from sim.dataset import sources
from sim.dataset.rows import Rows, merge_rows
from sim.dataset.sources import File, read_files
from sim.parameters import amounts, parse_point
from tests.made.processes import ROOT, wait_until
from tests.made.runs import write_run


@pytest.fixture(scope="module")
def files(tmp_path_factory) -> list[File]:
    """Run files of two systems and of different numbers of replicates."""
    runs = tmp_path_factory.mktemp("runs")
    given = [
        {"system": system, "replicates": count, "gravity": gravity}
        for system in ("chute", "belt")
        for count, gravity in ((1, 9), (2, 10), (3, 11))
    ]
    points = [parse_point(one, "test") for one in given]
    return [(write_run(runs, point), amounts(point), False) for point in points]


@pytest.fixture
def small_batches(monkeypatch) -> None:
    """Let processes start for two files, each of them a batch."""
    monkeypatch.setattr(sources, "MIN_FILES", 2)
    monkeypatch.setattr(sources, "BATCH", 1)


def assert_equal(rows: list[Rows], expected: list[Rows]) -> None:
    for one, other in zip(merge_rows(rows), merge_rows(expected), strict=True):
        assert (one.points, one.origin) == (other.points, other.origin)
        assert list(one.values) == list(other.values)
        for name, values in one.values.items():
            np.testing.assert_array_equal(values, other.values[name])


def test_processes_read_what_one_reads(files, small_batches):
    assert_equal(read_files(files, processes=2), read_files(files))


@pytest.mark.parametrize("processes", [1, 2])
def test_all_that_is_wrong_is_counted_and_the_first_is_named(
    files, small_batches, tmp_path, processes
):
    broken = tmp_path / "broken.nc"
    broken.write_text("not netCDF")
    missing = [(tmp_path / f"{name}.nc", {}, False) for name in "ab"]
    with pytest.raises(InputError, match=r"broken\.nc: damaged .* \(and 2 more\)$"):
        read_files([files[0], (broken, {}, False), *missing], processes)
    assert (tmp_path / "broken.nc.damaged").exists()


def test_processes_end_with_their_parent(files, small_batches):
    """A killed parent cannot tell them to end."""
    lines = (
        "import os, signal\n"
        "from sim.dataset import sources\n"
        "with sources._process_pool(2) as how:\n"
        "    children = {how['pool'].submit(os.getpid).result() for _ in range(9)}\n"
        "    children = [process.pid for process in how['pool']._processes.values()]\n"
        "    print(*children, flush=True)\n"
        "    os.kill(os.getpid(), signal.SIGKILL)\n"
    )
    done = subprocess.run([sys.executable, "-c", lines], cwd=ROOT, capture_output=True, text=True)
    children = list(map(int, done.stdout.split()))
    assert len(children) == 2, done.stderr
    wait_until(lambda: not any(map(is_alive, children)))


def is_alive(pid: int) -> bool:
    try:
        return psutil.Process(pid).status() != psutil.STATUS_ZOMBIE
    except psutil.NoSuchProcess:
        return False


@pytest.fixture(scope="module")
def cluster():
    """A dask cluster of one worker with two threads."""
    distributed = pytest.importorskip("distributed")
    options = {"n_workers": 1, "threads_per_worker": 2, "processes": False}
    with distributed.LocalCluster(**options, protocol="tcp://", dashboard_address=None) as cluster:
        yield cluster


def test_a_cluster_reads_what_one_process_reads(files, small_batches, cluster, monkeypatch):
    expected = read_files(files)
    monkeypatch.chdir(files[0][0].parent)
    relative = [(Path(path.name), *others) for path, *others in files]
    assert_equal(read_files(relative, scheduler=cluster.scheduler_address), expected)


def test_workers_with_other_code_are_refused(files, cluster, monkeypatch):
    monkeypatch.setattr(sources, "reader_hash", lambda: threading.current_thread().name)
    with pytest.raises(InputError, match="--dask-scheduler: its workers have not this program"):
        read_files(files, scheduler=cluster.scheduler_address)


@pytest.mark.parametrize("address", ["nonsense", "tcp://127.0.0.1"])
def test_what_is_no_address_is_refused(files, address):
    pytest.importorskip("distributed")
    with pytest.raises(
        InputError, match=f"--dask-scheduler: got '{address}'; allowed: the address"
    ):
        read_files(files, scheduler=address)


def test_a_missing_package_is_named(files, monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(InputError, match="pip install distributed"):
        read_files(files, scheduler="tcp://127.0.0.1:8786")


def test_nobody_is_asked_to_read_nothing():
    assert read_files([], scheduler="nonsense") == []
