"""What other studies have run is taken, once and whole, and they keep what they have."""

import errno
import os
from pathlib import Path
from types import SimpleNamespace
from unittest.mock import Mock

import pytest

from sim.base.files import YEAR_2000, age, file_lock
from sim.base.seals import append_summary, seal
from sim.engine import stored_run
from sim.engine.identity import NUMERICS
from sim.engine.shared_runs import describe, find_runs, take_runs
from sim.engine.states import States, state_file, stored_samples
from sim.parameters import BeltParameters, amounts, point_id
from tests.made.netcdf import edit_file
from tests.made.runs import write_run

POINT = BeltParameters(beads=10, width=5, frequency=20, average=20)
KEY = point_id(POINT)


def longer(average: float, replicates: int = 1, point: BeltParameters = POINT) -> BeltParameters:
    return point.model_copy(update={"average": average, "replicates": replicates})


@pytest.fixture
def results(tmp_path) -> Path:
    return tmp_path / "results"


@pytest.fixture
def mine(results) -> Path:
    """The run file of the point in the study that looks for others."""
    path = results / "mine" / "runs" / f"{KEY}.nc"
    path.parent.mkdir(parents=True)
    return path


def make(results: Path, study: str, point: BeltParameters, samples: int = 0, numerics=NUMERICS):
    """Write the end of a run file, and a state after some samples."""
    path = results / study / "runs" / f"{point_id(point)}.nc"
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(study.encode())
    attributes = {"point_id": point_id(point), "numerics": numerics}
    append_summary(path, {"attributes": attributes, "held": [amounts(point)]})
    seal(path)
    if samples:
        keep(path, point, samples)
    return path


def keep(path: Path, point: BeltParameters, *samples: int) -> None:
    """Write states of replicates after some samples each."""
    states = States(path, point)
    for number, count in enumerate(samples):
        states.keep(SimpleNamespace(number=number, state=lambda n=count: {"told.shown": n}))
    states.save()


def find(results: Path, point: BeltParameters = POINT) -> tuple[str, bool] | None:
    """Return the study whose run file would be taken, and whether it is large enough."""
    found = find_runs(results / "mine" / "runs", {point_id(point): point})
    return (found[KEY].path.parts[-3], found[KEY].is_enough) if found else None


def take(results: Path, point: BeltParameters = POINT) -> set[str]:
    runs = results / "mine" / "runs"
    return take_runs(runs, find_runs(runs, {point_id(point): point}))


def test_a_run_of_another_study_is_taken_by_a_hard_link_with_its_state(results):
    path = make(results, "other", POINT, samples=9)
    assert find(results) == ("other", True)
    assert not (results / "mine").exists()
    assert take(results) == {KEY}
    mine = results / "mine" / "runs" / path.name
    assert mine.samefile(path) and state_file(mine).samefile(state_file(path))
    assert sorted(mine.parent.iterdir()) == sorted([mine, state_file(mine)])
    assert find(results) is None


def test_what_was_made_of_the_run_file_before_is_made_again(results):
    make(results, "mine", longer(10))
    make(results, "other", POINT)
    dataset = results / "mine" / "dataset.nc"
    dataset.touch()
    assert take(results) == {KEY}
    assert dataset.stat().st_mtime < YEAR_2000


#: Runs of studies as (study, (average, replicates), samples of the state), what is wanted, and
#: the study that is found, with whether its run is large enough.
FOUND = {
    "here is enough": ([("mine", (20, 1), 0), ("a", (80, 1), 0)], (20, 1), None),
    "the largest": ([("a", (40, 1), 0), ("b", (80, 1), 0), ("c", (60, 1), 0)], (20, 1), "b+"),
    "just what is wanted": ([("b", (80, 1), 0), ("d", (20, 1), 0)], (20, 1), "d+"),
    "replicates": ([("b", (80, 1), 0), ("e", (20, 3), 0)], (20, 3), "e+"),
    "the largest to grow": ([("a", (5, 1), 5), ("b", (10, 1), 10)], (20, 1), "b-"),
    "none that a run passes by": ([("b", (10, 1), 10), ("c", (15, 3), 15)], (20, 1), "b-"),
    "less than here": ([("mine", (10, 2), 0), ("a", (20, 1), 0)], (20, 1), None),
    "all that is here": ([("mine", (10, 1), 0), ("a", (20, 1), 0)], (20, 1), "a+"),
}


@pytest.mark.parametrize("case", FOUND)
def test_the_best_run_is_found(case, results):
    made, (average, replicates), expected = FOUND[case]
    for study, lengths, samples in made:
        make(results, study, longer(*lengths), samples=samples)
    found = find(results, longer(average, replicates))
    assert (f"{found[0]}{'-+'[found[1]]}" if found else None) == expected


def test_a_smaller_run_does_not_replace_what_is_further_here(results, mine):
    keep(mine, POINT, 12)
    make(results, "other", longer(10), samples=10)
    assert find(results) is None
    make(results, "other", longer(15), samples=15)
    assert find(results) == ("other", False)
    assert take(results) == {KEY}
    assert stored_samples(mine, POINT) == [15]


def test_a_state_that_is_further_here_stays(results, mine):
    keep(write_run(results / "other" / "runs", POINT), POINT, 20)
    keep(mine, POINT, 30)
    assert take(results) == {KEY}
    assert stored_samples(mine, POINT) == [30]


def test_what_grows_in_one_study_is_unchanged_in_the_other(results):
    path = make(results, "other", POINT, samples=20)
    before, changed = path.read_bytes(), path.stat().st_mtime_ns
    take(results)
    mine = results / "mine" / "runs" / path.name
    age(mine, True)
    assert mine.stat().st_mtime < YEAR_2000 and mine.read_bytes() == before
    make(results, "new", longer(80), samples=80)
    assert take(results, longer(80)) == {KEY}
    assert path.read_bytes() == before and path.stat().st_mtime_ns == changed
    assert stored_samples(path, POINT) == [20]
    # Nor does the other lose anything if the file here goes, and the other way round.
    path.unlink()
    state_file(path).unlink()
    assert mine.is_file() and stored_samples(mine, POINT) == [80]


@pytest.mark.parametrize("part", [lambda path: path, state_file], ids=["run file", "state"])
def test_what_is_damaged_is_not_taken_and_stays_as_it_is(part, results):
    path = make(results, "other", POINT, samples=9)
    damaged = part(path)
    content = b"x" + damaged.read_bytes()[1:]
    damaged.write_bytes(content)
    mine = results / "mine" / "runs" / path.name
    assert take(results) == ({KEY} if damaged != path else set())
    assert not (mine if damaged == path else state_file(mine)).exists()
    assert damaged.read_bytes() == content
    assert len(list(path.parent.iterdir())) == 2


def test_other_numerics_and_what_may_not_be_read_are_not_taken(results, monkeypatch):
    make(results, "old", POINT, numerics=NUMERICS + 1)
    assert find(results) is None
    path = make(results, "other", POINT)
    found = find_runs(results / "mine" / "runs", {KEY: POINT})
    refuse = Mock(side_effect=PermissionError(errno.EACCES, os.strerror(errno.EACCES)))
    with monkeypatch.context() as patched:
        patched.setattr("shutil.copy2", refuse)
        patched.setattr("os.link", refuse)
        assert take_runs(results / "mine" / "runs", found) == set() and path.is_file()
        patched.setattr("os.scandir", refuse)
        assert find(results) is None
    path.unlink()
    assert take_runs(results / "mine" / "runs", found) == set()


def test_a_copy_is_taken_where_a_link_cannot_be(results, monkeypatch):
    path = make(results, "other", POINT, samples=9)
    os.utime(path, (1.7e9, 1.7e9))
    other_disk = OSError(errno.EXDEV, os.strerror(errno.EXDEV))
    monkeypatch.setattr("os.link", Mock(side_effect=other_disk))
    assert take(results) == {KEY}
    mine = results / "mine" / "runs" / path.name
    assert mine.read_bytes() == path.read_bytes() and not mine.samefile(path)
    assert mine.stat().st_mtime == 1.7e9


def test_a_point_that_is_being_run_here_is_left_to_that(results, mine):
    make(results, "other", POINT)
    with file_lock(mine):
        assert take(results) == set()
    assert take(results) == {KEY}


def test_what_starts_from_another_run_is_taken_if_that_has_the_same_end(results):
    then = BeltParameters(beads=10, width=5, frequency=40, start_from=KEY)
    points = {point_id(then): then, KEY: POINT}
    runs = results / "mine" / "runs"

    keep(write_run(results / "other" / "runs", POINT), POINT, 9)
    with edit_file(write_run(results / "other" / "runs", then)) as file:
        file.origin = "9"
    assert set(find_runs(runs, points)) == set(points)
    # The run from which it starts ended elsewhere here.
    keep(write_run(runs, POINT), POINT, 12)
    assert not find_runs(runs, points)
    keep(runs / f"{KEY}.nc", POINT, 9)
    assert not find_runs(runs, points)  # and the file there is older
    os.utime(runs / f"{KEY}.nc", (1.7e9, 1.7e9))
    assert set(find_runs(runs, points)) == {point_id(then)}


def test_many_studies_and_points_are_looked_up_with_few_reads(results, monkeypatch):
    """Names that share a file are one: it is read once."""
    points = {
        point_id(point): point
        for point in (BeltParameters(beads=10, width=5, frequency=20 + n) for n in range(60))
    }
    for point in points.values():
        make(results, "first", point)
    for number in range(10):
        runs = results / f"study{number}" / "runs"
        assert take_runs(runs, find_runs(runs, points)) == set(points)
    reads = []
    read = stored_run.read_summary
    monkeypatch.setattr(stored_run, "read_summary", lambda path: reads.append(path) or read(path))
    stored_run._held_by.cache_clear()
    for _ in range(2):
        assert len(find_runs(results / "mine" / "runs", points)) == 60
    assert len(reads) == 60


def test_one_line_says_how_much_other_studies_have(results):
    assert describe([]) == ""
    other = BeltParameters(beads=10, width=5, frequency=30)
    make(results, "a", POINT)
    make(results, "b", longer(20, point=other))
    found = find_runs(results / "mine" / "runs", {KEY: POINT, point_id(other): other})
    assert describe(found.values()).startswith("1 point in other studies, not to be run: a (1); ")
    found = find_runs(results / "mine" / "runs", {KEY: longer(40)})
    assert describe(found.values()) == "1 point in other studies, from which runs here grow: a (1)"
