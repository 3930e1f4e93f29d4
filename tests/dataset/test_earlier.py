"""A dataset made from an earlier one and a few run files equals one made from all run files."""

import random
import shutil
from pathlib import Path

import pytest
import xarray as xr

from sim.base.seals import seal
from sim.dataset import earlier, gather, sources
from tests.made.mixed import PATHS, POINTS, SHOWN, STATES, Mixed, ids
from tests.made.netcdf import store

#: Numbers of the points in the dataset.
STORED = (0, 3)


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

    def read_run(path: Path, amounts=None, has_state: bool = False):
        ids_read.append(path.stem)
        return gather.read_run(path, amounts, has_state)

    monkeypatch.setattr(sources, "read_run", read_run)
    return ids_read


def test_nothing_is_read_again(study, points_read):
    assert study.build(*STORED) == study.output.read_bytes()
    assert points_read == []


def test_nothing_is_read_again_once_the_dataset_is_removed(study, points_read):
    whole = study.output.read_bytes()
    study.output.unlink()
    assert study.build(*STORED) == whole
    assert points_read == []


def test_points_that_come_are_read_and_those_that_go_leave_no_trace(study, points_read):
    steps = random.Random(1)
    held = set(STORED)
    for _ in range(4):
        numbers = steps.sample(range(6), steps.randrange(1, 7))
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


def test_what_other_code_has_read_is_read_again(study, points_read, monkeypatch):
    monkeypatch.setattr(earlier, "reader_hash", lambda: "other")
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
        (study.output.parent / earlier.EARLIER_FILE).write_bytes(content)
        points_read.clear()
        assert study.build(*STORED) == whole
        assert points_read == ids(study, *STORED)
