"""Files have times by which Snakemake decides what is old; other names of a file keep theirs."""

import errno
import os
import time

import pytest

from sim.base.files import (
    YEAR_2000,
    age,
    correct_future_times,
    date_back_readers,
    write_start,
)


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
