"""Files appear complete or not at all, and have times by which Snakemake decides what is old."""

import errno
import fcntl
import os
import subprocess
import sys
import time

import pytest

from sim.base.files import (
    YEAR_2000,
    age,
    atomic_write,
    correct_future_times,
    file_lock,
    open_regular,
    read_regular,
    write_start,
)


def test_a_finished_file_takes_its_name(tmp_path):
    path = tmp_path / "made.txt"
    with atomic_write(path) as temporary:
        temporary.write_text("new")
        assert not path.exists()
    assert path.read_text() == "new"
    assert list(tmp_path.iterdir()) == [path]


def test_an_error_leaves_the_old_file_alone(tmp_path):
    path = tmp_path / "made.txt"
    path.write_text("old")
    with pytest.raises(ZeroDivisionError), atomic_write(path) as temporary:
        temporary.write_text("half")
        raise ZeroDivisionError
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_what_a_killed_process_left_is_removed_and_what_a_living_one_writes_is_not(tmp_path):
    path = tmp_path / "made.txt"
    dead = subprocess.Popen([sys.executable, "-c", ""])
    dead.wait()
    leftover = tmp_path / f".made.txt.{dead.pid}.part"
    in_progress = tmp_path / f".made.txt.{os.getppid()}.part"
    other = tmp_path / f".other.txt.{dead.pid}.part"
    for file in (leftover, in_progress, other):
        file.write_text("half")
    with atomic_write(path) as temporary:
        temporary.write_text("new")
    assert sorted(tmp_path.iterdir()) == sorted([path, in_progress, other])


@pytest.mark.parametrize("name", [None, "temporary", "other"])
def test_what_keeps_a_file_from_being_written_names_it(name, tmp_path):
    path = tmp_path / "made.txt"
    with pytest.raises(OSError) as caught, atomic_write(path) as temporary:
        names = {None: (), "temporary": (str(temporary),), "other": ("other",)}
        raise OSError(errno.ENOSPC, "No space left on device", *names[name])
    assert (caught.value.errno, caught.value.strerror) == (errno.ENOSPC, "No space left on device")
    assert caught.value.filename == ("other" if name == "other" else str(path))


@pytest.mark.parametrize("number", [errno.ENOLCK, errno.ENOSYS, errno.EOPNOTSUPP])
def test_nobody_waits_where_the_file_system_knows_no_locks(number, tmp_path, monkeypatch):
    def flock(*_):
        raise OSError(number, "no locks")

    monkeypatch.setattr("fcntl.flock", flock)
    with file_lock(tmp_path / "made.txt") as first, file_lock(tmp_path / "made.txt") as second:
        assert (first, second) == (False, False)
    assert not list(tmp_path.iterdir())


def test_who_gives_up_waiting_leaves_the_lock_to_its_holder(tmp_path, monkeypatch, caplog):
    def interrupted(_):
        raise KeyboardInterrupt

    monkeypatch.setattr("time.sleep", interrupted)
    lock = tmp_path / ".made.txt.lock"
    with lock.open("w") as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        with pytest.raises(KeyboardInterrupt), file_lock(tmp_path / "made.txt"):
            pass
    assert list(tmp_path.iterdir()) == [lock]
    assert "waiting for another process that makes the same file" in caplog.text


def test_a_folder_that_takes_no_files_is_no_lack_of_locks(tmp_path):
    with pytest.raises(FileNotFoundError), file_lock(tmp_path / "nowhere" / "made.txt"):
        pass


def test_a_link_in_the_place_of_the_lock_leads_to_nothing_that_is_changed(tmp_path):
    precious = tmp_path / "precious"
    precious.write_text("kept")
    (tmp_path / ".made.txt.lock").symlink_to(precious)
    with file_lock(tmp_path / "made.txt"):
        assert precious.read_text() == "kept"
    assert precious.read_text() == "kept"


@pytest.mark.parametrize("kind", ["pipe", "device", "folder"])
def test_only_files_are_opened(kind, tmp_path):
    path = tmp_path / kind
    if kind == "pipe":
        os.mkfifo(path)
        # With an open other end, opening the pipe would not even wait.
        end = os.open(path, os.O_RDWR)
    elif kind == "device":
        path.symlink_to(os.devnull)
    else:
        path.mkdir()
    with pytest.raises(OSError, match=f"not a regular file.*{kind}"):
        open_regular(path)
    if kind == "pipe":
        os.close(end)


def test_a_link_to_a_file_is_read(tmp_path):
    (tmp_path / "file").write_bytes(b"some")
    (tmp_path / "link").symlink_to("file")
    assert read_regular(tmp_path / "link") == b"some"


def test_the_start_file_is_old_and_never_the_same(tmp_path):
    path = tmp_path / "new" / "start"
    write_start(path)
    first = path.read_text()
    write_start(path)
    assert path.read_text() != first
    assert path.stat().st_mtime == YEAR_2000


def test_a_file_is_dated_before_the_start_file_and_back(tmp_path):
    path = tmp_path / "run.nc"
    age(path, True)
    assert not path.exists()
    path.touch()
    changed = path.stat().st_mtime
    for is_old in (True, True, False, False):
        age(path, is_old)
        assert (path.stat().st_mtime < YEAR_2000) == is_old
    assert abs(path.stat().st_mtime - changed) < 1e-3


@pytest.fixture
def future_files(tmp_path):
    """A run file, a dataset and somebody's notes that are dated in the future."""
    files = [tmp_path / "runs" / "a.nc", tmp_path / "dataset.nc", tmp_path / "notes.txt"]
    for path in files:
        path.parent.mkdir(exist_ok=True)
        path.touch()
        os.utime(path, (time.time() + 1e6,) * 2)
    return files


def test_times_in_the_future_are_corrected_by_kind_of_file(future_files, tmp_path, capsys):
    now, (run, dataset, notes) = time.time(), future_files
    table = tmp_path / "claims.csv"
    table.touch()
    correct_future_times(tmp_path)
    assert abs(run.stat().st_mtime - now) < 60
    assert dataset.stat().st_mtime < YEAR_2000
    assert abs(table.stat().st_mtime - now) < 60
    # Files that are no outputs may belong to somebody else.
    assert notes.stat().st_mtime > now + 1e5
    assert not capsys.readouterr().err


@pytest.mark.parametrize(("code", "count"), [(errno.EPERM, 1), (errno.EROFS, 1), (errno.ENOENT, 0)])
def test_a_time_that_cannot_be_corrected_is_told_in_one_line(
    code, count, future_files, tmp_path, monkeypatch, capsys
):
    utime, (run, dataset, _) = os.utime, future_files

    def refuse(path, times):
        if path == run:
            raise OSError(code, os.strerror(code), str(path))
        utime(path, times)

    monkeypatch.setattr(os, "utime", refuse)
    correct_future_times(tmp_path)
    assert dataset.stat().st_mtime < YEAR_2000
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == count and all(str(run) in line for line in lines)
