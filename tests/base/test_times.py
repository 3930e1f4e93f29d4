"""Files have times by which Snakemake decides what is old; other names of a file keep theirs."""

import os

from sim.base.files import (
    YEAR_2000,
    age,
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
