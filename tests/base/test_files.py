"""Files appear complete or not at all, with times that Snakemake goes by; YAML is that of 1.2."""

import errno
import fcntl
import os
import subprocess
import sys

import pytest

from sim.base.errors import InputError
from sim.base.files import (
    YEAR_2000,
    age,
    atomic_write,
    date_back_readers,
    file_lock,
    open_regular,
    write_start,
)
from sim.parameters import load_point


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


@pytest.mark.parametrize(
    ("text", "depth"),
    [
        ("system: chute\ndepth: 1e1\n", 10),
        ("system: chute\ndepth: 2.5E+1\n", 25),
        ("system: chute\ndepth: .5\n", 0.5),
        ("{'system': 'chute', 'depth': 1_0}", None),
        ("system: chute\ndepth: 010\n", 10),
        ("system: chute\ndepth: 1:30\n", None),
        ("system: chute\ndepth: yes\n", None),
    ],
)
def test_numbers_are_read_by_yaml_1_2(tmp_path, text, depth):
    path = tmp_path / "point.yaml"
    path.write_text(text)
    if depth is None:
        with pytest.raises(InputError, match=r"depth: got '.*'; allowed: a number > 0"):
            load_point(path)
    else:
        assert load_point(path).depth == depth


def test_anchors_and_merge_keys_are_no_duplicates(tmp_path):
    path = tmp_path / "point.yaml"
    path.write_text("<<: &base {system: chute, depth: 2}\ndepth: 3\n")
    assert load_point(path).depth == 3


@pytest.mark.parametrize("text", ["system: chute\n\tdepth: 1\n", "system: chute\n  \tdepth: 1\n"])
def test_a_tab_before_a_key_is_named(tmp_path, text):
    path = tmp_path / "point.yaml"
    path.write_text(text)
    with pytest.raises(InputError) as error:
        load_point(path)
    assert str(error.value) == f"{path}: line 2 begins with a tab; YAML wants spaces"


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


def test_another_name_of_a_file_keeps_its_time_and_its_content(tmp_path):
    path, other = tmp_path / "run.nc", tmp_path / "other.nc"
    path.write_bytes(b"some")
    os.link(path, other)
    before = other.stat().st_mtime_ns
    age(path, True)
    assert path.stat().st_mtime < YEAR_2000 and path.read_bytes() == b"some"
    assert other.stat().st_mtime_ns == before and other.stat().st_nlink == 1
    # A file that a study has dated back is taken by another one, for which it is enough.
    os.link(path, taken := tmp_path / "taken.nc")
    age(taken, False)
    assert path.stat().st_mtime < YEAR_2000 < taken.stat().st_mtime


def test_what_is_made_of_run_files_is_dated_before_them(tmp_path):
    for name in ("runs/a.nc", "rounds/1.json", "dataset.nc", "report.html"):
        path = tmp_path / name
        path.parent.mkdir(exist_ok=True)
        path.touch()
    date_back_readers(tmp_path)
    old = {path.name for path in tmp_path.rglob("*.*") if path.stat().st_mtime < YEAR_2000}
    assert old == {"1.json", "dataset.nc"}
