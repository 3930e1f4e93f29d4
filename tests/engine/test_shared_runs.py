"""What other studies have run is taken, once and whole, and they keep what they have."""

import errno
import os
from pathlib import Path
from types import SimpleNamespace

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


def make(results: Path, study: str, *stages: BeltParameters, samples: int = 0, numerics=NUMERICS):
    """Write the end of a run file, with the longest run first; and a state after some samples."""
    path = results / study / "runs" / f"{point_id(stages[0])}.nc"
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(study.encode())
    attributes = {"point_id": point_id(stages[0]), "numerics": numerics}
    append_summary(path, {"attributes": attributes, "held": [amounts(one) for one in stages]})
    seal(path)
    if samples:
        keep(path, stages[0], samples)
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
    make(results, "other", POINT, longer(10))
    dataset = results / "mine" / "dataset.nc"
    dataset.touch()
    assert take(results) == {KEY}
    assert dataset.stat().st_mtime < YEAR_2000


def test_a_run_that_is_here_is_looked_for_nowhere(results):
    make(results, "mine", POINT)
    make(results, "other", longer(80))
    assert find(results) is None


def test_just_what_is_wanted_comes_first_and_then_the_largest(results):
    make(results, "a", longer(40))
    make(results, "b", longer(80))
    make(results, "c", longer(60))
    assert find(results) == ("b", True)
    make(results, "d", longer(60, replicates=2), longer(20))
    assert find(results) == ("d", True)
    make(results, "e", longer(20, replicates=3))
    assert find(results, longer(20, replicates=3)) == ("e", True)


def test_a_smaller_run_is_taken_to_grow_if_a_run_here_would_pass_through_it(results):
    make(results, "a", longer(5), samples=5)
    make(results, "b", longer(10), samples=10)
    assert find(results) == ("b", False)
    make(results, "c", longer(15, replicates=3), samples=15)
    assert find(results) == ("b", False)
    assert take(results) == {KEY}
    mine = results / "mine" / "runs" / f"{KEY}.nc"
    assert stored_samples(mine, POINT) == [10]
    assert find(results) is None


def test_a_smaller_run_does_not_replace_what_is_further_here(results):
    mine = results / "mine" / "runs" / f"{KEY}.nc"
    mine.parent.mkdir(parents=True)
    keep(mine, POINT, 12)
    make(results, "other", longer(10), samples=10)
    assert find(results) is None
    make(results, "other", longer(15), samples=15)
    assert find(results) == ("other", False)


def test_a_run_file_here_is_only_replaced_by_one_that_holds_all_it_holds(results):
    make(results, "mine", longer(10))
    make(results, "other", POINT)
    assert find(results) is None
    make(results, "other", POINT, longer(10))
    assert find(results) == ("other", True)


def test_a_state_that_is_further_here_stays(results):
    path = write_run(results / "other" / "runs", POINT)
    keep(path, POINT, 20)
    mine = results / "mine" / "runs" / path.name
    mine.parent.mkdir(parents=True)
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
    make(results, "new", longer(80), POINT, samples=80)
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


def test_run_files_of_other_numerics_and_those_set_aside_are_not_taken(results):
    path = make(results, "old", POINT, numerics=NUMERICS + 1)
    path.with_name(f"{path.name}.damaged").write_bytes(make(results, "b", POINT).read_bytes())
    (results / "b" / "runs" / path.name).unlink()
    assert find(results) is None


@pytest.mark.parametrize("kind", ["file", "folder of runs", "study", "pipe", "folder", "state"])
def test_links_and_special_files_are_not_followed(kind, results, tmp_path):
    elsewhere = make(tmp_path / "elsewhere", "other", POINT, samples=9)
    path = results / "other" / "runs" / elsewhere.name
    link, target = {
        "file": (path, elsewhere),
        "folder of runs": (path.parent, elsewhere.parent),
        "study": (path.parent.parent, elsewhere.parent.parent),
    }.get(kind, (None, None))
    (link or path).parent.mkdir(parents=True)
    if link:
        link.symlink_to(target)
    elif kind == "pipe":
        os.mkfifo(path)
    elif kind == "folder":
        path.mkdir()
    else:
        make(results, "other", POINT)
        state_file(path).symlink_to(state_file(elsewhere))
        assert take(results) == {KEY}
        assert not os.path.lexists(state_file(results / "mine" / "runs" / path.name))
        return
    assert find(results) is None


def test_a_file_that_becomes_a_link_in_the_meantime_is_not_taken(results, tmp_path):
    path = make(results, "other", POINT)
    found = find_runs(results / "mine" / "runs", {KEY: POINT})
    path.unlink()
    path.symlink_to(make(tmp_path / "elsewhere", "other", POINT))
    assert take_runs(results / "mine" / "runs", found) == set()
    path.unlink()
    assert take_runs(results / "mine" / "runs", found) == set()
    assert not list((results / "mine" / "runs").iterdir())


@pytest.mark.parametrize("obstacle", ["other disk", "other owner"])
def test_a_copy_is_taken_where_a_link_cannot_be(obstacle, results, monkeypatch):
    path = make(results, "other", POINT, samples=9)
    os.utime(path, (1.7e9, 1.7e9))
    if obstacle == "other disk":

        def link(*_, **__):
            raise OSError(errno.EXDEV, os.strerror(errno.EXDEV))

        monkeypatch.setattr("os.link", link)
    else:
        monkeypatch.setattr("os.geteuid", lambda: 4242)
    assert take(results) == {KEY}
    mine = results / "mine" / "runs" / path.name
    assert mine.read_bytes() == path.read_bytes() and not mine.samefile(path)
    assert mine.stat().st_mtime == 1.7e9


def test_nothing_is_taken_from_what_may_not_be_read(results, monkeypatch):
    path = make(results, "other", POINT)
    found = find_runs(results / "mine" / "runs", {KEY: POINT})

    def refuse(*_, **__):
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))

    monkeypatch.setattr("sim.engine.shared_runs.open_regular", refuse)
    monkeypatch.setattr("os.link", refuse)
    assert take_runs(results / "mine" / "runs", found) == set()
    assert path.is_file()
    monkeypatch.setattr("os.scandir", refuse)
    monkeypatch.setattr("os.lstat", refuse)
    assert find(results) is None


@pytest.mark.parametrize("held", [[{}], [{"average": "x"}], ["x"], 3, {"a": 1}])
def test_a_forged_end_of_a_file_is_not_taken(held, results):
    path = make(results, "other", POINT)
    path.write_bytes(b"")
    attributes = {"point_id": KEY, "numerics": NUMERICS}
    append_summary(path, {"attributes": attributes, "held": held})
    seal(path)
    assert find(results) is None


def test_a_point_that_is_being_run_here_is_left_to_that(results):
    make(results, "other", POINT)
    mine = results / "mine" / "runs" / f"{KEY}.nc"
    mine.parent.mkdir(parents=True)
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
    assert len(find_runs(results / "mine" / "runs", points)) == 60
    assert len([path for path in reads if "mine" not in path.parts]) == 60


def test_one_line_says_how_much_other_studies_have(results):
    assert describe([]) == ""
    make(results, "a", POINT)
    point = longer(40)
    make(results, "b", longer(20, point=BeltParameters(beads=10, width=5, frequency=30)))
    points = {KEY: POINT}
    points |= {point_id(one): one for one in [BeltParameters(beads=10, width=5, frequency=30)]}
    found = find_runs(results / "mine" / "runs", points | {KEY: POINT})
    assert describe(found.values()).startswith("1 point in other studies, not to be run: a (1); ")
    found = find_runs(results / "mine" / "runs", {KEY: point})
    assert describe(found.values()) == "1 point in other studies, from which runs here grow: a (1)"
