"""Times of files by which Snakemake decides what is old."""

import os
import time

from sim.base.file_times import YEAR_2000, age, correct_future_times, write_start


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


def test_times_in_the_future_are_corrected_by_kind_of_file(tmp_path):
    now, run, dataset = time.time(), tmp_path / "runs" / "a.nc", tmp_path / "dataset.nc"
    other = tmp_path / "claims.csv"
    run.parent.mkdir()
    for path in (run, dataset, other):
        path.touch()
    for path in (run, dataset):
        os.utime(path, (now + 1e6, now + 1e6))
    correct_future_times(tmp_path)
    assert abs(run.stat().st_mtime - now) < 60
    assert dataset.stat().st_mtime < YEAR_2000
    assert abs(other.stat().st_mtime - now) < 60
