"""Replicates that decide something are added in rounds, the cheapest first, for a budget."""

import json
import shutil
from collections.abc import Sequence
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from sim.__main__ import main
from sim.base.errors import InputError
from sim.claims.checks import above
from sim.claims.claim import claims
from sim.claims.place import Place
from sim.claims.verdict import Check
from sim.dataset.build import build
from sim.dataset.results import load_results
from sim.report import decide as deciding
from sim.study.load import extra_amounts_file, load_study, parse_study
from tests.made.netcdf import edit_file
from tests.made.processes import refusal
from tests.made.runs import write_run

STUDY = """\
study: open
decide: {%s}
series:
  - {name: flows, system: chute, base: {replicates: 3}, grid: {depth: [1, 2]}}
"""
#: Of the first point the mean is known well, of the second it is not.
SPREAD = {1: [0.5, 0.501, 0.499], 2: [0.4, 0.5, 0.6]}


class Folder:
    """A study that is run with made-up runs."""

    def __init__(self, root, text: str):
        self.results, self.path = root / "results", root / "open.yaml"
        self.path.write_text(STUDY % text)

    @property
    def points(self):
        return load_study(self.path, self.results).points

    def run(self, *_) -> int:
        """Run what is wanted: further replicates repeat the first."""
        for point in self.points.values():
            spread, count = SPREAD[point.parameters.depth], point.parameters.replicates
            velocities = [spread[number % 3] for number in range(count)]
            write_run(self.results / "open" / "runs", point.parameters, velocities)
        build(self.path, self.results)
        return 0

    def decide(self, *options: str) -> int:
        return main(["decide", str(self.path), *options])

    def replicates(self) -> list[int]:
        return [point.parameters.replicates for point in self.points.values()]


@pytest.fixture(scope="module")
def ran(tmp_path_factory) -> Path:
    """Return a folder with the study, its runs and its dataset."""
    folder = Folder(tmp_path_factory.mktemp("ran"), "budget: 1, precision: 0.1")
    folder.run()
    return folder.path.parent


@pytest.fixture
def made(ran, tmp_path, monkeypatch):
    """Return a function that makes a study, with its runs, that decides something."""
    monkeypatch.chdir(tmp_path)

    def make(text: str) -> Folder:
        shutil.copytree(ran, tmp_path, dirs_exist_ok=True)
        return Folder(tmp_path, text)

    return make


def test_a_mean_that_is_not_known_well_enough_gets_replicates(made, capsys):
    folder = made("budget: 10, precision: 0.05")
    assert folder.decide() == 0
    out = capsys.readouterr().out
    assert "chute-depth2-" in out and "chute-depth1-" not in out
    assert "replicates of 1 point" in out and out.endswith("0 of 10 core hours spent\n")
    # A round makes a point four times as long at most.
    assert folder.replicates() == [3, 12]


def test_a_point_gets_as_many_as_the_study_allows(made, capsys):
    folder = made("budget: 10, precision: 0.05, replicates: 5")
    folder.decide()
    folder.run()
    before = extra_amounts_file(folder.results / "open").read_bytes()
    folder.decide()
    assert "nothing is open" in capsys.readouterr().out and folder.replicates() == [3, 5]
    assert extra_amounts_file(folder.results / "open").read_bytes() == before


def test_what_the_budget_does_not_hold_is_not_bought(made, capsys):
    folder = made("budget: 0.0001, precision: 0.05")
    folder.decide()
    assert "beyond the budget" in capsys.readouterr().out
    assert not extra_amounts_file(folder.results / "open").exists()


def test_rounds_go_on_until_nothing_is_open(made, monkeypatch, capfd):
    folder = made("budget: 10, precision: 0.05")
    monkeypatch.setattr(deciding, "run_with_signals", folder.run)
    assert folder.decide("--cores", "2") == 0
    out = capfd.readouterr().out
    assert out.count("bought; run the study again") >= 2
    assert "nothing is open; 0." in out.splitlines()[-1]
    assert folder.replicates()[1] > 12


def test_points_and_status_tell_the_budget(made, capsys):
    folder = made("budget: 10, precision: 0.05")

    def told(command: str) -> dict:
        assert main([command, str(folder.path), "--format", "json"]) == 0
        return json.loads(capsys.readouterr().out)

    assert told("points")["totals"]["decisions_core_hours"] == 10
    assert told("status")["budget"] == {"hours": 10, "spent": 0, "left": 10}
    taken = told("status")["core_seconds"]
    assert folder.decide() == 0
    capsys.readouterr()
    assert told("status")["counts"]["waiting"] == 1
    folder.run()
    after = told("status")
    spent = pytest.approx((after["core_seconds"] - taken) / 3600, abs=1e-3)
    assert after["counts"]["done"] == 2 and after["budget"]["spent"] == spent
    assert after["budget"]["left"] == pytest.approx(10 - after["budget"]["spent"], abs=1e-3)
    assert main(["status", str(folder.path)]) == 0
    assert "decisions: " in capsys.readouterr().out


@pytest.fixture
def judges(monkeypatch):
    """Return a function that lets the judge give some judgements."""
    return lambda *judgements: monkeypatch.setattr(deciding, "judge", lambda *_: judgements)


def judged(name: str, short: Sequence[str] = (), **by_reading: list[Check]) -> SimpleNamespace:
    """Return a judgement on the chute with open checks by reading, in one word."""
    return SimpleNamespace(
        claim=SimpleNamespace(id=name, system="chute"),
        headings=["default"],
        open_checks=lambda reading: by_reading.get(reading.rpartition(" ")[-1], []),
        short_points=lambda reading: short,
    )


def test_open_claims_get_the_replicates_of_their_points_and_each_look_is_counted(
    made, judges, capsys
):
    """Two rounds make three looks; points of which nothing was bought have been looked at once."""
    folder = made("budget: 10, claims: [W9]")
    first, second = folder.points
    check = Check("x", 1.5, 0.6, 1.0, 9.0, points=(first,), samples=99)
    judges(judged("W8", default=[check]), judged("W9", default=[check, check]))
    assert 1 < check.replicate_factor < 4
    folder.decide()
    out = capsys.readouterr().out
    assert out.startswith("W9: replicates of 1 point") and "W8" not in out
    assert folder.replicates() == [4, 3]
    held = json.loads(extra_amounts_file(folder.results / "open").read_text())
    assert held["amounts"] == {first: {"replicates": 4.0}} and held["rounds"] == {first: 1}
    folder.run()
    folder.decide()
    folder.run()
    assert {point.id: point.looks for point in folder.points.values()} == {first: 3, second: 1}
    results = load_results(folder.results / "open" / "dataset.nc")
    places = [Place(results, point) for point in (first, second)]
    assert [place.looks for place in places] == [3, 1]
    assert above("V", places[0].velocity, 0, places).looks == 3


def test_claims_of_the_papers_may_be_decided_and_no_others():
    study = {"study": "s", "series": [{"name": "a", "system": "chute"}]}

    def decided(*names: str) -> list[str]:
        decide = {"decide": {"budget": 1.0, "claims": [*names]}}
        return parse_study(study | decide, "s.yaml", None).decide.claims

    every = [claim.id for claim in claims()]
    assert decided(*every, "all") == [*every, "all"]
    for name in ("W0", "W26", "G41", "G99", "X1"):
        with pytest.raises(InputError, match=rf"s\.yaml: decide\.claims\[0\]: got '{name}'"):
            decided(name)


def test_a_claim_is_decided_under_each_reading_of_the_whole_study(made, judges, capsys):
    folder = made("budget: 10, claims: [W9]")
    first, second = folder.points
    checks = {
        name: [Check("x", 1.5, 0.6, 1.0, 9.0, points=(point,), samples=99)]
        for name, point in (("after", first), ("reset", second))
    }
    judges(judged("W9", **checks))
    folder.decide()
    assert "nothing is open" in capsys.readouterr().out
    text = folder.path.read_text()
    folder.path.write_text(text + "readings: {chute: {friction_cap: [before, after]}}\n")
    assert load_study(folder.path, None).readings == {"chute": [{}, {"friction_cap": "after"}]}
    folder.run()
    folder.decide()
    out = capsys.readouterr().out
    assert out.startswith("W9 (friction_cap after): replicates of 1 point") and "reset" not in out


@pytest.mark.parametrize("damage", ["torn", "a digit"])
def test_a_damaged_list_of_what_was_bought_is_set_aside(damage, made, capsys):
    folder = made("budget: 10, precision: 0.05")
    folder.decide()
    path = extra_amounts_file(folder.results / "open")
    text = path.read_text()
    digit = text.index('"before": ') + len('"before": ')
    texts = {
        "torn": text[:-20],
        "a digit": text[:digit] + str((int(text[digit]) + 1) % 10) + text[digit + 1 :],
    }
    path.write_text(texts[damage])
    line = refusal(capsys, "decide", folder.path)
    assert "list of what was bought" in line
    assert folder.replicates() == [3, 3]


def test_runs_that_are_too_short_for_a_claim_get_longer(made, judges, capsys):
    folder = made("budget: 10, claims: [W9], longer: 3")
    first, _ = folder.points
    judges(judged("W9", short=[first]))

    def average() -> list[float]:
        return [point.parameters.average for point in folder.points.values()]

    before = average()
    for times in (2, 3, 3):
        folder.decide()
        assert average() == [times * before[0], before[1]]
        folder.run()
    assert "W9: longer runs of 1 point" in capsys.readouterr().out
    assert folder.replicates() == [3, 3]


@pytest.mark.parametrize("ended", ["target", "limit"])
def test_runs_that_end_before_their_limit_get_more_beside_them(
    ended, tmp_path, judges, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    folder = Folder(tmp_path, "budget: 10, claims: [W9]")
    text = folder.path.read_text()
    folder.path.write_text(text.replace("replicates: 3", "replicates: 3, protocol: converged"))
    write = write_run

    def written(*arguments, **options):
        path = write(*arguments, **options)
        with edit_file(path) as file:
            file["stopped"][:] = np.array([ended] * file["stopped"].size, object)
        return path

    monkeypatch.setattr("tests.report.test_decide.write_run", written)
    folder.run()
    first, _ = folder.points
    judges(judged("W9", short=[first]))
    limit = next(iter(folder.points.values())).parameters.limit
    folder.decide()
    grown = next(iter(folder.points.values())).parameters
    assert (grown.replicates, grown.limit) == ((6, limit) if ended == "target" else (3, 2 * limit))
