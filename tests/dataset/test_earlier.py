"""A dataset made from an earlier one and few run files is that made from all of them."""

import random
import shutil
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from sim.base.files import seal
from sim.dataset import earlier, gather, side_by_side
from sim.dataset.build import build
from sim.parameters import Parameters, parse_point, point_id
from tests.made.netcdf import store
from tests.made.runs import write_run

#: Points that differ in all that is lined up: systems, replicates, slices, squares, variables.
POINTS = [
    {"system": "chute", "depth": 2},
    {"system": "chute", "depth": 5, "replicates": 3},
    {"system": "chute", "depth": 1, "friction": 0.5, "replicates": 2},
    {"system": "belt", "frequency": 30},
    {"system": "belt", "frequency": 20, "replicates": 2},
    {"system": "belt", "frequency": 50, "width": 30, "replicates": 4},
]

#: The number of a point that a figure shows particle by particle, and that figure.
SHOWN, FIGURE = 4, "gallas_4c"


def arrays(parameters: Parameters) -> dict[str, object]:
    """Return arrays as long as the point is large, and some that only some runs have."""
    count, slices = parameters.replicates, parameters.replicates + 3
    made = {
        "height": ("height", np.arange(slices) * 1e-3),
        "velocity_profile": (("replicate", "height"), np.ones((count, slices))),
    }
    if parameters.system == "belt":
        squares = round(parameters.width)
        dims, field = ("replicate", "column", "level"), np.ones((count, squares, 2))
        made |= {"column": ("column", np.arange(squares) * 1e-3), "level": ("level", [0.0, 1e-3])}
        made |= {"field_velocity": (dims, field), "field_density": (dims, field)}
        dims = ("replicate", "frame", "particle", "axis")
        made |= {"position": (dims, np.ones((count, 2, 3, 2))), "axis": ("axis", ["x", "z"])}
    elif count == 2:
        made["transient_end"] = ("replicate", np.full(count, np.nan))
    return made


class Study:
    """A study of some of the points, whose run files are all there."""

    def __init__(self, folder: Path):
        self.path, self.results = folder / "made.yaml", folder / "results"
        self.runs = self.results / "made" / "runs"
        self.output = self.results / "made" / "dataset.nc"
        self.points = [parse_point(values, "test") for values in POINTS]

    def write(self, number: int, velocity: float = 0.5) -> Path:
        """Write the run file of a point."""
        point = self.points[number]
        return write_run(
            self.runs, point, velocity, failed=[0] * (number == 1), arrays=arrays(point)
        )

    def build(self, *numbers: int, shown: bool = False) -> bytes:
        """Make the dataset of points by their numbers, in their order."""
        series = ""
        for number in numbers:
            values = dict(POINTS[number])
            figures = [FIGURE] * (shown and number == SHOWN)
            series += (
                f"  - {{name: s{number}, system: {values.pop('system')}, figures: {figures},"
                f" cases: [{values}]}}\n"
            )
        self.path.write_text(f"study: made\nseries:\n{series}")
        return build(self.path, self.results).read_bytes()

    def afresh(self, *numbers: int, shown: bool = False) -> bytes:
        """Make it from run files alone."""
        (self.output.parent / earlier.EARLIER).unlink(missing_ok=True)
        return self.build(*numbers, shown=shown)


@pytest.fixture(scope="module")
def original(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("made")
    study = Study(folder)
    for number in range(len(POINTS)):
        study.write(number)
    return folder


@pytest.fixture
def study(original, tmp_path) -> Study:
    shutil.copytree(original, tmp_path, dirs_exist_ok=True)
    return Study(tmp_path)


@pytest.fixture
def read(monkeypatch) -> list[str]:
    """Return a list of the ids of points whose run files are read."""
    found: list[str] = []

    def read_run(path: Path, wanted=None, shown: bool = False):
        found.append(path.stem)
        return gather.read_run(path, wanted, shown)

    monkeypatch.setattr(side_by_side, "read_run", read_run)
    return found


def ids(study: Study, *numbers: int) -> list[str]:
    return [point_id(study.points[number]) for number in numbers]


def test_nothing_is_read_again(study, read):
    whole = study.build(*range(6))
    assert read == ids(study, *range(6))
    read.clear()
    assert study.build(*range(6)) == whole
    assert read == []


def test_nothing_is_read_again_once_the_dataset_is_removed(study, read):
    whole = study.build(0, 3)
    study.output.unlink()
    read.clear()
    assert study.build(0, 3) == whole
    assert read == []


def test_points_that_come_are_read_and_those_that_go_leave_no_trace(study, read):
    steps = random.Random(1)
    held: set[int] = set()
    for _ in range(5):
        numbers = steps.sample(range(6), steps.randrange(1, 7))
        read.clear()
        found = study.build(*numbers)
        assert set(read) == set(ids(study, *set(numbers) - held))
        assert found == study.afresh(*numbers)
        held = set(numbers)


def test_a_run_file_that_was_made_anew_is_read(study, read):
    before = study.build(0, 3)
    read.clear()
    study.write(3, velocity=0.7)
    found = study.build(0, 3)
    assert read == ids(study, 3)
    assert found != before and found == study.afresh(0, 3)


def test_particles_are_kept_for_as_long_as_a_figure_shows_them(study, read):
    hidden, shown = study.afresh(3, SHOWN), study.afresh(3, SHOWN, shown=True)
    assert hidden != shown
    read.clear()
    assert study.build(3, SHOWN) == hidden
    assert read == []
    assert study.build(3, SHOWN, shown=True) == shown
    assert read == ids(study, SHOWN)
    read.clear()
    assert study.build(3, SHOWN, shown=True) == shown
    assert read == []


def test_what_other_code_has_read_is_read_again(study, read, monkeypatch):
    study.build(0, 3)
    read.clear()
    monkeypatch.setattr(earlier, "reading_code", lambda: "other")
    study.build(0, 3)
    assert read == ids(study, 0, 3)


def test_a_dataset_that_is_damaged_or_none_is_not_used(study, read):
    whole = study.build(0, 3)
    store(xr.Dataset({"depth": 1.0}), study.path.with_name("other.nc"))
    other = study.path.with_name("other.nc")
    seal(other)
    half = len(whole) // 2
    flipped = whole[:half] + bytes([whole[half] ^ 1]) + whole[half + 1 :]
    for content in (b"", whole[:half], flipped, other.read_bytes()):
        (study.output.parent / earlier.EARLIER).write_bytes(content)
        read.clear()
        assert study.build(0, 3) == whole
        assert read == ids(study, 0, 3)
