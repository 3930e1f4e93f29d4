"""Files appear complete or not at all."""

import errno
import fcntl
import os
import subprocess
import sys

import pytest

from sim.base.files import atomic_write, file_lock, open_regular, read_regular


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
