"""A comparison in words and as JSON."""

import json

import pytest

from sim.__main__ import main
from sim.parameters import parse_point
from tests.made.runs import write_run


@pytest.fixture
def runs(tmp_path):
    """Two run files of other friction."""
    points = [
        parse_point({"system": "chute", "replicates": 3, "friction": mu}, "test")
        for mu in (0.4, 0.5)
    ]
    paths = []
    for number, (point, velocity) in enumerate(zip(points, (0.5, 0.4), strict=True)):
        (folder := tmp_path / str(number)).mkdir()
        paths.append(str(write_run(folder, point, velocity)))
    return paths


def test_two_runs_are_told_with_intervals_and_what_is_different(runs, capsys):
    assert main(["compare", *runs]) == 0
    out = capsys.readouterr().out
    assert "friction: A 0.4, B 0.5" in out and "velocity (m s-1), with 95 % intervals" in out
    assert "of 1 point" in out and "±" in out


def test_the_same_as_json(runs, capsys):
    assert main(["compare", *runs, "--format", "json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["different"]["friction"] == [0.4, 0.5]
    (point,) = found["points"]
    assert point["difference"]["value"] == pytest.approx(point["b"]["value"] - point["a"]["value"])


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--ignore", "frction"], "--ignore: got 'frction'"),
        (["--of", "speed"], "got 'speed'; allowed: one of"),
    ],
)
def test_what_is_not_known_is_refused_in_one_line(words, message, runs, capsys):
    assert main(["compare", *runs, *words]) == 2
    err = capsys.readouterr().err
    assert message in err and err.count("\n") == 1
