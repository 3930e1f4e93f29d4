"""How far a study is, as text, as JSON and on the command line, and runs of no point of it."""

import json

import pytest

from sim.__main__ import main
from sim.engine.progress import Progress
from sim.report.status import PointStatus, StudyStatus
from sim.report.status_table import as_json, as_text
from tests.made.folder import BOUNDED, NOW, STUDY, Folder
from tests.made.netcdf import edit_file
from tests.made.processes import refusal
from tests.made.runs import FAILURE


@pytest.fixture
def folder(tmp_path) -> Folder:
    return Folder(tmp_path)


def screenful(points: int) -> StudyStatus:
    said = {"at_most": True, "particles": 1000, "rate": 45e6, "elapsed": 4000.0, "pid": 1}
    said |= {"done": 1, "total": 10**12, "started": NOW, "updated": NOW, "expires": NOW}
    name = "chute-depth5-friction0.4-restitution0.85-stiffness100-tangential_exponent0.5-{:08x}"
    made = {}
    for index in range(points):
        key = name.format(index)
        progress = Progress(point=key, host="here", **said)
        made[f"{key[:-8]}a{key[-7:]}"] = PointStatus("running", 1, progress=progress)
        made[f"{key[:-8]}b{key[-7:]}"] = PointStatus("failed", 1, reason=f"{FAILURE} " * 5)
    return StudyStatus("made", "A made-up study", made, 1e6, 1e4, True)


def test_text_is_one_aligned_screenful():
    status = screenful(100)
    lines = as_text(status, 80).splitlines()
    assert len(lines) <= 24
    assert max(map(len, lines)) <= 80
    table = [line for line in lines if " running " in line and "points" not in line]
    assert len(table) == 8
    assert len({len(line) for line in table}) == 1
    assert "and 92 more" in lines and "and 95 more" in lines
    assert table[0].split("  ")[0].endswith("-a0000000")
    assert "45.0" in table[0]
    assert next(iter(status.points)) in as_text(status)


def test_a_study_that_is_over_says_what_it_took(folder):
    for key in folder.ids:
        folder.finish(key)
    status = folder.survey()
    assert status.is_over and status.seconds_left == 0.0
    assert as_text(status) == "made: A made-up study\n5 points: 5 done\n\n" + (
        "time of all runs 7.5 s, with compiling and waiting"
    )


def test_points_with_a_caveat_are_counted(folder):
    leaking = {"energy_residual": ("replicate", [-0.012], {"units": "1"})}
    folder.finish(folder.ids[0], arrays=leaking)
    path = folder.finish(folder.ids[3])
    with edit_file(path) as run:
        run.caveat = "the time step is long"
    folder.finish(folder.ids[4])
    status = folder.survey()
    assert "5 points: 3 done, 2 waiting; 2 with a caveat" in as_text(status)
    document = json.loads(as_json(status))
    assert document["caveats"] == 2
    told = [point.get("caveat", "") for point in document["points"]]
    assert "energy does not add up" in told[0]
    assert told[1:] == ["", "", "the time step is long", ""]


def test_json_holds_every_point(folder):
    folder.finish(folder.ids[0])
    folder.finish(folder.ids[1], failed=[0])
    folder.write_progress(folder.ids[2])
    document = json.loads(as_json(folder.survey()))
    assert document["counts"]["waiting"] == 2
    assert [point["id"] for point in document["points"]] == folder.ids
    _, failed, running, *_ = document["points"]
    assert failed["reason"] == FAILURE
    assert (running["done"], running["total"], running["seconds_left"]) == (500, 1000, 10.0)
    assert document["seconds_left"] > 0


def test_the_command_shows_a_study_until_it_is_over(folder, capsys):
    for key in folder.ids:
        folder.finish(key)
    options = ["--results", str(folder.results)]
    assert main(["status", str(folder.file), *options, "--watch", "5"]) == 0
    assert "5 points: 5 done" in capsys.readouterr().out
    assert main(["status", str(folder.file), *options, "--format", "json"]) == 0
    assert json.loads(capsys.readouterr().out)["counts"]["done"] == 5


def test_the_study_is_the_default_one_when_none_is_named(tmp_path, capsys):
    assert main(["status", "--results", str(tmp_path)]) == 0
    assert capsys.readouterr().out.startswith("quick: ")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["none.yaml"], "none.yaml: no such file"),
        (["--watch", "0"], "--watch: got 0; allowed: a number in [1, 86400]"),
        (["--watch", "nan"], "--watch: got nan; allowed: a number in [1, 86400]"),
        (["--results", "README.md"], "--results: got 'README.md'; allowed: a folder"),
    ],
)
def test_mistakes_give_one_line(arguments, words, capsys):
    assert words in refusal(capsys, "status", *arguments)


@pytest.mark.parametrize("content", ["[", "[1]", '{"extra": {"system": "chute", "depth": -1}}'])
def test_an_unreadable_round_gives_one_line(tmp_path, capsys, content):
    folder = Folder(tmp_path, BOUNDED)
    rounds = folder.results / "made" / "rounds"
    rounds.mkdir(parents=True)
    (rounds / "1.json").write_text(content)
    assert "1.json" in refusal(capsys, "status", folder.file, "--results", folder.results)


@pytest.fixture
def shrunk(tmp_path) -> Folder:
    """A study of which every point is run, and then one value is taken out."""
    made = Folder(tmp_path)
    for key in made.ids:
        run = made.finish(key)
        run.with_name(f".{run.name}.state").write_bytes(bytes(1000))
    return Folder(tmp_path, STUDY.replace("[1, 2, 3]", "[1, 3]"))


def run_orphans(folder: Folder, *options: str) -> int:
    return main(["orphans", str(folder.file), "--results", str(folder.results), *options])


def test_orphans_are_told_and_left_alone(shrunk, capsys):
    before = sorted(path.name for path in shrunk.runs.iterdir())
    status = shrunk.survey()
    (orphan,) = status.orphans
    assert orphan.startswith("chute-depth2-")
    assert "runs of no point of the study: 1" in as_text(status)
    assert f'"{orphan}"' in as_json(status)
    assert run_orphans(shrunk) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].startswith(orphan) and lines[-1].startswith("1 run, 0.")
    assert sorted(path.name for path in shrunk.runs.iterdir()) == before


def test_orphans_are_removed_when_told_to(shrunk, capsys):
    (orphan,) = shrunk.survey().orphans
    assert run_orphans(shrunk, "--remove") == 0
    left = {path.name for path in shrunk.runs.iterdir()}
    assert left == {name for key in shrunk.ids for name in (f"{key}.nc", f".{key}.nc.state")}
    assert not any(orphan in name for name in left)
    capsys.readouterr()
    assert run_orphans(shrunk, "--remove") == 0
    assert capsys.readouterr().out == "none\n"


def test_what_a_run_that_was_stopped_has_left_is_removed_too(tmp_path, capsys):
    made = Folder(tmp_path)
    kept, gone = made.ids[0], made.ids[1]
    for key in (kept, gone):
        made.write_progress(key)
        (made.runs / f".{key}.nc.state").write_bytes(bytes(1000))
    folder = Folder(tmp_path, STUDY.replace("[1, 2, 3]", "[1, 3]"))
    assert run_orphans(folder) == 0
    assert capsys.readouterr().out.startswith(f"{gone}  0.0 MB\n1 run, ")
    assert run_orphans(folder, "--remove") == 0
    left = {f".{kept}.nc.state", f".{kept}.nc.progress"}
    assert {path.name for path in folder.runs.iterdir()} == left


def test_nothing_is_an_orphan_while_rounds_are_to_come(tmp_path, capsys):
    made = Folder(tmp_path)
    made.finish(made.ids[0])
    bounded = Folder(tmp_path, BOUNDED)
    assert bounded.survey().orphans == ()
    assert run_orphans(bounded, "--remove") == 2
    assert "boundaries: got '" in capsys.readouterr().err
    assert (made.runs / f"{made.ids[0]}.nc").exists()
