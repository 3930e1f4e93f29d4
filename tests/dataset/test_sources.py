"""An earlier dataset, run files, processes and clusters all give the same rows."""

import random
import shutil
import subprocess
import sys
import threading
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from sim.base.errors import InputError
from sim.base.seals import seal
from sim.dataset import gather, sources
from sim.dataset.results import load_results
from sim.dataset.rows import Row
from sim.dataset.sources import File, read_files
from sim.parameters import amounts, parse_point
from tests.made import mixed
from tests.made.mixed import PATHS, POINTS, SHOWN, STATES, Mixed, ids
from tests.made.netcdf import store
from tests.made.processes import ROOT, is_alive, wait_until
from tests.made.runs import write_run

#: Numbers of the points in the dataset.
STORED = (0, 3)

#: Number of the point with the most replicates.
WIDE = 5


@pytest.fixture(scope="module")
def original(tmp_path_factory) -> Path:
    """Return a folder with run files of all points and a dataset of some."""
    folder = tmp_path_factory.mktemp("made")
    study = Mixed(folder)
    for number in range(len(POINTS)):
        study.write(number)
    study.build(*STORED)
    return folder


@pytest.fixture
def study(original, tmp_path) -> Mixed:
    shutil.copytree(original, tmp_path, dirs_exist_ok=True)
    return Mixed(tmp_path)


@pytest.fixture
def points_read(monkeypatch) -> list[str]:
    """Return a list of the ids of points whose run files are read."""
    ids_read: list[str] = []

    def read_run(path: Path, amounts=None, need=gather.SCALARS_ALONE):
        ids_read.append(path.stem)
        return gather.read_run(path, amounts, need)

    monkeypatch.setattr(sources, "read_run", read_run)
    return ids_read


def test_only_points_that_come_are_read_and_those_that_go_leave_no_trace(study, points_read):
    steps, held = random.Random(1), set(STORED)
    for numbers in (STORED, *(steps.sample(range(6), steps.randrange(1, 7)) for _ in range(4))):
        points_read.clear()
        found = study.build(*numbers)
        assert set(points_read) == set(ids(study, *set(numbers) - held))
        assert found == study.build_afresh(*numbers)
        held = set(numbers)


def test_a_run_file_that_was_made_anew_is_read(study, points_read):
    before = study.output.read_bytes()
    study.write(3, velocity=0.7)
    found = study.build(*STORED)
    assert points_read == ids(study, 3)
    assert found != before and found == study.build_afresh(*STORED)


def test_a_point_of_which_less_is_wanted_is_read_again(study, points_read, monkeypatch):
    study.write(WIDE)
    study.build(WIDE)
    points_read.clear()
    fewer = [*POINTS[:WIDE], POINTS[WIDE] | {"replicates": 2}]
    monkeypatch.setattr(mixed, "POINTS", fewer)
    content = study.build(WIDE)
    assert points_read == ids(study, WIDE) and content == study.build_afresh(WIDE)
    with xr.open_dataset(study.output) as dataset:
        assert dataset.sizes["replicate"] == 2


def test_particles_are_kept_for_as_long_as_a_figure_shows_them(study, points_read):
    paths, states = (study.build_afresh(3, SHOWN, shown=figure) for figure in (PATHS, STATES))
    hidden = study.build_afresh(3, SHOWN)
    assert len({paths, states, hidden}) == 3
    for figure, content, is_read in (
        (STATES, states, True),
        (PATHS, paths, True),
        (PATHS, paths, False),
        (STATES, states, False),
        ("", hidden, False),
    ):
        points_read.clear()
        assert study.build(3, SHOWN, shown=figure) == content
        assert points_read == ids(study, SHOWN) * is_read


def test_profiles_are_kept_for_as_long_as_a_series_wants_them(study, points_read):
    whole, bare = study.build_afresh(*STORED), study.build_afresh(*STORED, bare=STORED[:1])
    results = load_results(study.output)
    first, second = ids(study, *STORED)
    assert len(results.profile(second, "velocity_profile")[0]) == 1
    with pytest.raises(InputError, match=f"{first}: no velocity_profile in the dataset"):
        results.profile(first, "velocity_profile")
    assert np.isfinite(results.dataset["velocity"].sel(point=first)).any()
    for chosen, content, is_read in (((), whole, True), (STORED[:1], bare, False)):
        points_read.clear()
        assert study.build(*STORED, bare=chosen) == content
        assert points_read == ids(study, *STORED[:1]) * is_read
    study.build(*STORED, bare=STORED)
    assert not set(load_results(study.output).profiles)


def test_what_other_code_has_read_is_read_again(study, points_read, monkeypatch):
    monkeypatch.setattr(sources, "reader_hash", lambda: "other")
    study.build(*STORED)
    assert points_read == ids(study, *STORED)


def test_a_dataset_that_is_damaged_or_none_is_not_used(study, points_read):
    whole = study.output.read_bytes()
    store(xr.Dataset({"depth": 1.0}), study.path.with_name("other.nc"))
    other = study.path.with_name("other.nc")
    seal(other)
    half = len(whole) // 2
    flipped = whole[:half] + bytes([whole[half] ^ 1]) + whole[half + 1 :]
    for content in (b"", whole[:half], flipped, other.read_bytes()):
        (study.output.parent / sources.EARLIER_FILE).write_bytes(content)
        points_read.clear()
        assert study.build(*STORED) == whole
        assert points_read == ids(study, *STORED)


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
    return [(write_run(runs, point), amounts(point), gather.SCALARS_ALONE) for point in points]


@pytest.fixture
def small_batches(monkeypatch) -> None:
    """Let processes start for two files, each of them a batch."""
    monkeypatch.setattr(sources, "MIN_FILES", 2)
    monkeypatch.setattr(sources, "BATCH", 1)


def assert_equal(rows: list[Row], expected: list[Row]) -> None:
    for one, other in zip(rows, expected, strict=True):
        assert (one.point, one.origin) == (other.point, other.origin)
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
        read_files([files[0], (broken, {}, gather.SCALARS_ALONE), *missing], processes)
    assert (tmp_path / "broken.nc.damaged").exists()


def test_processes_end_with_their_parent(files, small_batches):
    """A killed parent cannot tell them to end."""
    lines = (
        "import os, signal, time\n"
        "from pathlib import Path\n"
        "from sim.dataset import sources\n"
        "parent = os.getpid()\n"
        "def kill_parent(part):\n"
        "    os.write(1, b'%d ' % os.getpid())\n"
        "    time.sleep(0.5)\n"
        "    os.kill(parent, signal.SIGKILL)\n"
        "    time.sleep(3600)\n"
        "sources.read_batch, sources.MIN_FILES = kill_parent, 2\n"
        "sources.read_files([(Path('none'), {}, None)] * 2, processes=2)\n"
    )
    done = subprocess.run([sys.executable, "-c", lines], cwd=ROOT, capture_output=True, text=True)
    children = list(map(int, done.stdout.split()))
    assert len(children) == 2, done.stderr
    wait_until(lambda: not any(map(is_alive, children)))


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
    with pytest.raises(InputError, match="--dask-scheduler: its workers do not have this program"):
        read_files(files, scheduler=cluster.scheduler_address)


def test_a_cluster_without_workers_is_told_and_not_waited_for(files, monkeypatch, capsys):
    distributed = pytest.importorskip("distributed")
    monkeypatch.setattr(sources, "WORKER_TIMEOUT", 0.1)
    options = {"n_workers": 0, "processes": False, "protocol": "tcp://", "dashboard_address": None}
    told = r"a cluster with a worker \(none for 0.1 s\)"
    with distributed.LocalCluster(**options) as cluster, pytest.raises(InputError, match=told):
        read_files(files, scheduler=cluster.scheduler_address)
    assert "has no worker; waiting for one" in capsys.readouterr().err


IS_READING, GO_ON = threading.Event(), threading.Event()


def wait_to_read(part: object) -> None:
    """Stand for the reading of files by a worker that is told to end."""
    IS_READING.set()
    GO_ON.wait()


def test_workers_that_end_while_they_read_are_told(files, monkeypatch):
    distributed = pytest.importorskip("distributed")
    monkeypatch.setattr(sources, "WORKER_TIMEOUT", 0.1)
    monkeypatch.setattr(sources, "read_batch", wait_to_read)
    options = {"n_workers": 1, "threads_per_worker": 1, "processes": False}
    options |= {"protocol": "tcp://", "dashboard_address": None}
    with distributed.LocalCluster(**options) as cluster:

        def end_workers() -> None:
            IS_READING.wait()
            cluster.scale(0)
            GO_ON.set()

        ending = threading.Thread(target=end_workers)
        ending.start()
        with pytest.raises(InputError, match="--dask-scheduler: got"):
            read_files(files, processes=len(files), scheduler=cluster.scheduler_address)
        ending.join()


def test_what_is_no_address_or_has_no_package_is_refused(files, monkeypatch):
    pytest.importorskip("distributed")
    assert read_files([], scheduler="nonsense") == []
    with pytest.raises(InputError, match="--dask-scheduler: got 'nonsense'; allowed: the address"):
        read_files(files, scheduler="nonsense")
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(InputError, match="pip install distributed"):
        read_files(files, scheduler="tcp://127.0.0.1:8786")
