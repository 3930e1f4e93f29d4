"""Calls on files fail, stop half way, or end the process: nothing whole is lost or set aside."""

import json
import os
import random
import shutil
import subprocess
from collections import Counter
from collections.abc import Iterator
from errno import EACCES, EDQUOT, EIO, EMFILE, ENOENT, ENOMEM, ENOSPC, ESTALE
from html.parser import HTMLParser
from itertools import product
from pathlib import Path
from signal import SIGKILL
from typing import NamedTuple

import pytest

from sim.figures.pictures import RECORD_FILE
from sim.figures.render import draw_figures
from sim.parameters import canonical_values, point_id
from sim.report import page
from sim.study.load import load_study
from sim.surrogates.answers import refusal_in
from tests.golden import contents
from tests.made.faults import Calls, Commands, Fault, Outcome, What, faulty_commands
from tests.made.figures import make_figures
from tests.made.netcdf import edit_file
from tests.made.report import write_claims

SEED = int(os.environ.get("TALUS_DRILL_SEED", "1"))

STUDY = """\
study: faulty
defaults:
  belt: {beads: 10, width: 5, steps_per_cycle: 1000, transient: 1, average: 3}
series:
  - name: wide
    system: belt
    design: {kind: sobol, points: 5, over: {frequency: [30, 60]}}
  - name: few
    system: belt
    base: {replicates: 2}
    grid: {frequency: [20, 60]}
    figures: [gallas_1a]
surrogate:
  - name: speed
    series: wide
    observable: velocity
    regimes: [steady, accelerating, arrested, mixed, undetermined]
  - {name: none, series: wide, observable: velocity, regimes: [arrested]}
sensitivity: [{name: lost, surrogate: none}]
calibrate:
  - {name: beads, data: exp.csv, surrogate: none, parameters: {frequency: [30, 60]}}
decide: {precision: 0.01, budget: 1}
"""

#: Answers that are refused, as no flow is arrested.
REFUSED = ("surrogates/none.nc", "sensitivity/lost.csv", "calibration/beads.nc")

#: Commands of a study, in their order, each with words and what it writes below the folder.
RESULTS = "results/faulty"
DATASET = f"{RESULTS}/dataset.nc"
STEPS = {
    "batch": ["batch", RESULTS],
    "grow": ["batch", RESULTS],
    "take": ["batch", "results/other"],
    "grow apart": ["batch", "results/other"],
    "dataset": ["dataset", "faulty.yaml"],
    "dataset again": ["dataset", "faulty.yaml"],
    "finished": ["dataset", "faulty.yaml", "--finished", "finished.nc"],
    "questions": ["questions", "faulty.yaml"],
    "claims": ["claims", "faulty.yaml"],
    "figure": [
        *("figure", "gallas_1a", "speed-frequency", "speed-agreement", "none-frequency"),
        *("none-agreement", "lost-indices", "beads-posterior", "beads-predictions", DATASET),
        *("--study", "faulty.yaml", "-o", f"{RESULTS}/figures", "--code", "made"),
    ],
    "report": ["report", "faulty.yaml"],
    "publish": ["publish", "faulty.yaml", "--to", "published"],
    "publish again": ["publish", "faulty.yaml", "--to", "published"],
    "adopt": ["adopt", "faulty.yaml", "finished.nc"],
    "decide": ["decide", "faulty.yaml"],
    "status": ["status", "faulty.yaml"],
    "points": ["points", "faulty.yaml"],
    "predict": ["predict", "faulty.yaml", "--of", "speed", "--at", "frequency=40"],
    "compare": ["compare", RESULTS, RESULTS],
    "orphans": ["orphans", "faulty.yaml"],
    "info": ["info"],
    "export": ["export", "-o", "beads.extxyz"],
}

#: Cycles that the points of a batch are averaged over.
AVERAGES = {"batch": 2, "grow": 3, "take": 3, "grow apart": 4}


class Step(NamedTuple):
    """A command, and the folders before and after it in peace."""

    words: list[str]
    stdin: str
    before: Path
    after: Path
    outcome: Outcome


class Study:
    """A study in a folder, and what each command makes of it after those before it."""

    def __init__(self, commands: Commands, kept: Path):
        self.commands, self.tree, self._kept = commands, commands.folder, kept
        self.tree.mkdir()
        (self.tree / "faulty.yaml").write_text(STUDY)
        (self.tree / "exp.csv").write_text("velocity, velocity_error\n0.05, 0.01\n")
        self._steps: dict[str, Step] = {}
        self._points = [
            point.parameters for point in load_study(self.tree / "faulty.yaml").points.values()
        ]

    def step(self, name: str) -> Step:
        """Return a step, with those before it done."""
        for one in list(STEPS)[: list(STEPS).index(name) + 1]:
            if one not in self._steps:
                self._steps[one] = self._do(one)
        return self._steps[name]

    def _do(self, name: str) -> Step:
        before, after = self._kept / name / "before", self._kept / name / "after"
        last = list(self._steps.values())[-1].after if self._steps else self.tree
        copy(last, before)
        self._restore(before)
        words, stdin = STEPS[name], ""
        if words[0] == "batch":
            update = {"average": AVERAGES[name]}
            points = [point.model_copy(update=update) for point in self._points]
            stdin = json.dumps([canonical_values(point) for point in points])
        if words[0] in ("info", "export"):
            words = [*words, f"{RESULTS}/runs/{point_id(self._points[0])}.nc"]
        outcome = self.commands.run(words, stdin=stdin)
        assert outcome.code == 0, outcome
        if name == "questions":
            assert all(refusal_in(self.tree / RESULTS / file) for file in REFUSED)
        copy(self.tree, after)
        return Step(words, stdin, before, after, outcome)

    def _restore(self, tree: Path) -> None:
        shutil.rmtree(self.tree)
        copy(tree, self.tree)

    def run(self, name: str, fault: Fault) -> None:
        """Run a command from where it began, with a fault, and check what is left."""
        step = self.step(name)
        self._restore(step.before)
        outcome = self.commands.run(step.words, fault, step.stdin)
        note = f"{name}, {fault}: {outcome}"
        # A process that draws may be killed in place of the command.
        assert outcome.code in ((-SIGKILL, 1) if fault.what == What.KILL else (0, 1, 2)), note
        logs = [path.read_text() for path in self.tree.rglob("*.log")]
        assert not any("Traceback" in text for text in (outcome.error, *logs)), note + str(logs)
        assert outcome.code <= 0 or "error: " in outcome.error, note
        assert not list(self.tree.rglob("*.damaged*")), note
        for path in files(step.before):
            # Between two renames a publication has another name.
            names = path, Path("published", ".faulty.old", *path.parts[2:])
            is_there = any((self.tree / name).exists() for name in names)
            assert is_there, f"{path} is gone: {note}"
        for path in files(self.tree):
            trees = step.before, step.after
            is_whole = any(same(self.tree / path, tree / path) for tree in trees)
            # It names those figures that have been drawn.
            assert is_whole or path.name == RECORD_FILE, f"{path} is another: {note}"
        self._repeat(step, note, is_vanishing=fault[2:4] == (Calls.OPEN, ENOENT))

    def _repeat(self, step: Step, note: str, is_vanishing: bool) -> None:
        """Run a command again, in peace: its results are those of an undisturbed one."""
        again = self.commands.run(step.words, stdin=step.stdin)
        words = ("not there yet", "is there already")
        is_there = again.code == 2 and any(one in again.error for one in words)
        assert again.code == 0 or is_there, f"{again} after {note}"
        there, expected = files(self.tree), files(step.after)
        # A run of another study is taken without its state where that is said not to be there.
        gone = {path for path in expected - there if is_vanishing and path.suffix == ".state"}
        assert there | gone == expected, note
        for path in there:
            assert same(self.tree / path, step.after / path), f"{path}: {note}"


def copy(tree: Path, target: Path) -> None:
    """Copy a folder; names of one file stay names of one file."""
    target.parent.mkdir(parents=True, exist_ok=True)
    subprocess.run(["cp", "-a", tree, target], check=True)


def files(tree: Path) -> set[Path]:
    """Return the paths of all files but logs, progress and what killed processes leave."""
    return {
        path.relative_to(tree)
        for path in tree.rglob("*")
        if path.is_file()
        and path.suffix not in (".log", ".lock", ".progress", ".part")
        and not any(part.endswith((".part", ".old")) for part in path.parts)
    }


def same(one: Path, other: Path) -> bool:
    """True where two files hold the same numbers or text, times of computing left out."""
    if not other.exists():
        return False
    if one.read_bytes() == other.read_bytes():
        return True
    if one.suffix == ".nc" and "runs" in one.parts:
        mine, others = contents(one), contents(other)
        return mine.keys() == others.keys() and all(
            mine[name].dtype == others[name].dtype and str(mine[name]) == str(others[name])
            for name in mine
        )
    if one.name == RECORD_FILE:
        return json.loads(one.read_text()) == json.loads(other.read_text())
    return one.suffix == ".state"


@pytest.fixture(scope="module")
def study(tmp_path_factory) -> Iterator[Study]:
    room = tmp_path_factory.mktemp("faults")
    with faulty_commands(room / "tree", room) as commands:
        yield Study(commands, room / "kept")


ERRORS = {
    Calls.OPEN: (EACCES, EIO, EMFILE, ENOENT, ENOMEM, ESTALE),
    Calls.READ: (EIO, ESTALE),
    Calls.WRITE: (EACCES, EDQUOT, EIO, ENOSPC, ESTALE),
    Calls.STATUS: (EACCES, EIO, ENOENT, ESTALE),
}


#: Commands whose faults are tried with each change, and how often those of all are in a long drill.
QUICK, OFTEN = ("batch",), int(os.environ.get("TALUS_DRILL_FAULTS", "10"))
ALL = [*QUICK, *(pytest.param(name, marks=pytest.mark.long) for name in STEPS)]


@pytest.mark.parametrize(
    ("name", "calls"),
    [
        *product(QUICK, [Calls.OPEN]),
        *(pytest.param(*one, marks=pytest.mark.long) for one in product(STEPS, ERRORS)),
    ],
)
def test_an_error_of_the_system_takes_nothing(study, name, calls, request):
    """One call fails, or all from there on."""
    chance, total = random.Random(f"{SEED} {name}"), study.step(name).outcome.calls[calls]
    is_long = request.node.get_closest_marker("long")
    for _ in range(min(total, OFTEN if is_long else 1)):
        number, is_lasting = chance.choice(ERRORS[calls]), chance.random() < 0.3
        study.run(name, Fault(What.FAIL, chance.randint(1, total), calls, number, is_lasting))


@pytest.mark.parametrize("name", ALL)
def test_a_kill_between_two_calls_takes_nothing(study, name, request):
    chance, total = random.Random(f"{SEED} {name}"), study.step(name).outcome.calls[Calls.WRITE]
    is_long = request.node.get_closest_marker("long")
    for _ in range(min(total, OFTEN if is_long else 1)):
        study.run(name, Fault(What.KILL, chance.randint(1, total), Calls.WRITE))


@pytest.mark.long
@pytest.mark.parametrize("what", [What.SHORT, What.DELAY])
@pytest.mark.parametrize("name", STEPS)
def test_halves_and_delays_change_nothing(study, name, what):
    """Every call reads or writes half of what it could; or some are slow."""
    calls = Calls.READ | Calls.WRITE if what == What.SHORT else Calls.WRITE
    study.run(name, Fault(what, 1, calls, 1, lasting=what == What.SHORT))


#: Texts that would be a tag, end a script or an attribute, or run as a template.
HOSTILE = (
    "</script><script>alert(1)</script>",
    "<!--<script>",
    "<img src=x onerror=alert(1)>",
    "\"' onmouseover='alert(1)'",
    "javascript:alert(1)",
    "]]></svg><svg onload=alert(1)>",
    "{{ 7 * 7 }}{% raw %}",
    "$(touch x) `touch x`",
)


class Tags(HTMLParser):
    """Counts tags with the names of their attributes; collects addresses."""

    def __init__(self) -> None:
        super().__init__()
        self.tags: Counter[tuple[str, ...]] = Counter()
        self.addresses: set[str] = set()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags[(tag, *(name for name, _ in attrs if name.startswith("on")))] += 1
        self.addresses |= {str(value) for name, value in attrs if name in ("href", "src")}


def tags_of(path: Path) -> Tags:
    tags = Tags()
    tags.feed(path.read_text(encoding="utf-8"))
    return tags


def report_tags(folder: Path, text: str) -> Tags:
    """Make the report of a study with a text in all places; return its tags."""
    folder.mkdir()
    study_path, results = make_figures(folder)
    made, quoted = results / "made", text.replace("'", "''")
    plot = f"plots: [{{name: own, title: '{quoted}', kind: curves, x: depth, series: [depths]}}]"
    words = study_path.read_text().replace("A made-up study", f"'{quoted}'")
    study_path.write_text(f"{words}\n{plot}\n")
    with edit_file(made / "dataset.nc") as file:
        file.title = text
        for name in {"versions", "first_run", "machine"} & set(file.ncattrs()):
            file.setncattr(name, text)
    study = load_study(study_path, results)
    draw_figures(list(study.entries), made / "dataset.nc", made / "figures", 1, "made", study_path)
    write_claims(made / "claims.json", list(study.points))
    page.build(study_path, results)
    report = tags_of(made / "report.html")
    shutil.rmtree(folder)
    return report


@pytest.fixture(scope="module")
def plain(tmp_path_factory) -> Tags:
    """The tags of the report with harmless words."""
    return report_tags(tmp_path_factory.mktemp("pages") / "plain", "words")


@pytest.mark.long
@pytest.mark.parametrize("text", HOSTILE)
def test_what_a_stranger_writes_is_shown_as_text(text, plain, tmp_path):
    theirs = report_tags(tmp_path / "hostile", text)
    assert plain.tags == theirs.tags
    assert not any(address.startswith("javascript:") for address in theirs.addresses)
