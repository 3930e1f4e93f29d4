"""Files appear complete or not at all, where nobody has put a link."""

import errno
import fcntl
import os
import subprocess
import sys

import pytest

from sim.base.files import (
    atomic_write,
    file_lock,
    open_regular,
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
    leftover = tmp_path / f".made.txt.{dead.pid}.a1b2_c3d.part"
    in_progress = tmp_path / f".made.txt.{os.getppid()}.a1b2_c3d.part"
    others = [tmp_path / f".{name}.{dead.pid}.a1b2_c3d.part" for name in ("other", "made.txt.x")]
    for folder in (leftover, in_progress, *others):
        folder.mkdir()
        (folder / "made.txt").write_text("half")
    with atomic_write(path) as temporary:
        temporary.write_text("new")
    assert sorted(tmp_path.iterdir()) == sorted([path, in_progress, *others])


def test_an_empty_folder_of_another_file_is_removed_a_day_later(tmp_path):
    """A process that is killed after its last rename leaves one, and does not write again."""
    old, young, full = (tmp_path / f".{name}.1.a1b2_c3d.part" for name in "abc")
    for folder in (old, young, full):
        folder.mkdir()
    (full / "c").write_text("half")
    for folder in (old, full):
        os.utime(folder, (0, 0))
    with atomic_write(tmp_path / "made.txt") as temporary:
        temporary.write_text("new")
    assert sorted(tmp_path.iterdir()) == [young, full, tmp_path / "made.txt"]


def test_a_file_has_the_rights_that_the_umask_leaves(tmp_path):
    path, plain = tmp_path / "made.txt", tmp_path / "plain.txt"
    plain.touch()
    with atomic_write(path) as temporary:
        temporary.touch()
    assert path.stat().st_mode == plain.stat().st_mode


@pytest.mark.parametrize(
    "error", [RuntimeError("NetCDF: HDF error"), PermissionError(errno.EACCES, "denied", "x.part")]
)
def test_a_full_disk_is_called_one_whatever_the_library_says(error, tmp_path, monkeypatch):
    """Libraries have other words for it."""

    def allocate(*_):
        raise OSError(errno.ENOSPC, "No space left on device")

    path = tmp_path / "made.nc"
    with pytest.raises(OSError, match=r"denied|cannot be written"), atomic_write(path):
        raise error
    monkeypatch.setattr("os.posix_fallocate", allocate)
    with pytest.raises(OSError, match=f"No space left on device: '{path}'"), atomic_write(path):
        raise error
    assert not list(tmp_path.iterdir())


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
