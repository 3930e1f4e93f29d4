"""A dataset made from an earlier one and few run files is that made from all of them."""

import random
import shutil
from pathlib import Path

import pytest
import xarray as xr

from sim.base.files import seal
from sim.dataset import earlier, gather, side_by_side
from tests.made.mixed import PATHS, POINTS, SHOWN, STATES, Mixed, ids
from tests.made.netcdf import store

#: The points of which there is a dataset, by number.
HELD = (0, 3)


@pytest.fixture(scope="module")
def original(tmp_path_factory) -> Path:
    """Return a folder with run files of all points and a dataset of some."""
    folder = tmp_path_factory.mktemp("made")
    study = Mixed(folder)
    for number in range(len(POINTS)):
        study.write(number)
    study.build(*HELD)
    return folder


@pytest.fixture
def study(original, tmp_path) -> Mixed:
    shutil.copytree(original, tmp_path, dirs_exist_ok=True)
    return Mixed(tmp_path)


@pytest.fixture
def read(monkeypatch) -> list[str]:
    """Return a list of the ids of points whose run files are read."""
    found: list[str] = []

    def read_run(path: Path, wanted=None, shown: bool = False):
        found.append(path.stem)
        return gather.read_run(path, wanted, shown)

    monkeypatch.setattr(side_by_side, "read_run", read_run)
    return found


def test_nothing_is_read_again(study, read):
    assert study.build(*HELD) == study.output.read_bytes()
    assert read == []


def test_nothing_is_read_again_once_the_dataset_is_removed(study, read):
    whole = study.output.read_bytes()
    study.output.unlink()
    assert study.build(*HELD) == whole
    assert read == []


def test_points_that_come_are_read_and_those_that_go_leave_no_trace(study, read):
    steps = random.Random(1)
    held = set(HELD)
    for _ in range(4):
        numbers = steps.sample(range(6), steps.randrange(1, 7))
        read.clear()
        found = study.build(*numbers)
        assert set(read) == set(ids(study, *set(numbers) - held))
        assert found == study.afresh(*numbers)
        held = set(numbers)


def test_a_run_file_that_was_made_anew_is_read(study, read):
    before = study.output.read_bytes()
    study.write(3, velocity=0.7)
    found = study.build(*HELD)
    assert read == ids(study, 3)
    assert found != before and found == study.afresh(*HELD)


def test_particles_are_kept_for_as_long_as_a_figure_shows_them(study, read):
    paths, states = (study.afresh(3, SHOWN, shown=figure) for figure in (PATHS, STATES))
    hidden = study.afresh(3, SHOWN)
    assert len({paths, states, hidden}) == 3
    for figure, content, is_read in (
        (STATES, states, True),
        (PATHS, paths, True),
        (PATHS, paths, False),
        (STATES, states, False),
        ("", hidden, False),
    ):
        read.clear()
        assert study.build(3, SHOWN, shown=figure) == content
        assert read == ids(study, SHOWN) * is_read


def test_what_other_code_has_read_is_read_again(study, read, monkeypatch):
    monkeypatch.setattr(earlier, "reading_code", lambda: "other")
    study.build(*HELD)
    assert read == ids(study, *HELD)


def test_a_dataset_that_is_damaged_or_none_is_not_used(study, read):
    whole = study.output.read_bytes()
    store(xr.Dataset({"depth": 1.0}), study.path.with_name("other.nc"))
    other = study.path.with_name("other.nc")
    seal(other)
    half = len(whole) // 2
    flipped = whole[:half] + bytes([whole[half] ^ 1]) + whole[half + 1 :]
    for content in (b"", whole[:half], flipped, other.read_bytes()):
        (study.output.parent / earlier.EARLIER).write_bytes(content)
        read.clear()
        assert study.build(*HELD) == whole
        assert read == ids(study, *HELD)
