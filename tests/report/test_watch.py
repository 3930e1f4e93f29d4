"""What a workflow shows while it runs: a line per finished point, and how many there are."""

import pytest

from sim.report.watch import Watch
from sim.study.load import load_study

STUDY = """\
study: watched
series: [{name: beds, system: belt, grid: {frequency: [20, 40, 60]}}]
"""


@pytest.fixture
def study(tmp_path):
    (tmp_path / "watched.yaml").write_text(STUDY)
    return load_study(tmp_path / "watched.yaml", tmp_path)


def finish(folder, name, *lines):
    """Write what a run leaves: its log and its file."""
    for part in ("runs", "logs/runs"):
        (folder / part).mkdir(parents=True, exist_ok=True)
    said = "".join(f"{name}: {line}\n" for line in lines)
    (folder / "logs" / "runs" / f"{name}.log").write_text(f"{said}{folder}: written\n")
    (folder / "runs" / f"{name}.nc").touch()


def test_each_point_that_finishes_is_told_once_with_its_result(study, tmp_path, capsys):
    there, failing, flowing = study.points
    finish(tmp_path, there, "velocity 1 m/s")
    watch = Watch(study, tmp_path)
    watch.start()
    finish(tmp_path, failing, "200 particles", "failed: an overlap")
    finish(tmp_path, flowing, "200 particles", "velocity 2 m/s")
    (tmp_path / "runs" / ".other.nc.progress").touch()
    watch.end()
    said = capsys.readouterr().err.splitlines()
    assert sorted(said) == sorted([f"{failing}: failed: an overlap", f"{flowing}: velocity 2 m/s"])
    assert watch._state_text() == "1 running, 1 failed"


def test_a_point_without_a_log_is_told_too(study, tmp_path, capsys):
    watch = Watch(study, tmp_path)
    name = next(iter(study.points))
    (tmp_path / "runs").mkdir()
    (tmp_path / "runs" / f"{name}.nc").touch()
    watch.end()
    assert capsys.readouterr().err == f"{name}: done\n"


def test_of_many_points_failures_are_told_and_how_far_the_study_is(tmp_path, capsys):
    text = STUDY.replace("[20, 40, 60]", str(list(range(20, 60))))
    (tmp_path / "watched.yaml").write_text(text)
    study = load_study(tmp_path / "watched.yaml", tmp_path)
    watch = Watch(study, tmp_path)
    failing, *others = study.points
    finish(tmp_path, failing, "failed: an overlap")
    watch._report()
    for name in others[:9]:
        finish(tmp_path, name, "velocity 1 m/s")
    watch.end()
    first, second = capsys.readouterr().err.splitlines()
    assert first == f"{failing}: failed: an overlap"
    assert second.startswith("watched: 10 of 40 points, 0 running, 1 failed, about ")


def test_the_time_left_follows_from_what_is_done(study, tmp_path):
    watch = Watch(study, tmp_path)
    assert "left" not in watch._state_text()
    finish(tmp_path, next(iter(study.points)), "velocity 1 m/s")
    watch.end()
    assert "left" in watch._state_text()
