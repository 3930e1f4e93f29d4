"""A study whose processes are killed at random moments ends in the bits of an undisturbed one.

TALUS_DRILL_SEED sets their moments and victims.
"""

import json
import os
import random
import shutil
import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path

import numpy as np
import psutil
import pytest

from sim.study.load import load_study
from tests.golden import contents, digest
from tests.made.processes import ROOT, wait_until
from tests.made.project import command

SEED = int(os.environ.get("TALUS_DRILL_SEED", "1"))

#: How often each kind of process is chosen to be killed. A batch computes if it has written a
#: checkpoint; another may still be starting.
KINDS = {"computing batch": 0.5, "batch": 0.2, "shell": 0.1, "workflow": 0.1, "other": 0.1}

#: Share of the kills that do not wait for a computing batch; and the probability, after each pause
#: of such a wait, that the kill comes next.
EARLY, SOON = 0.2, 0.1

#: Seconds between two kills, at most.
PAUSE = 0.4

STUDY = """\
study: drill
series:
  - name: flows
    system: chute
    base: {cell: 5, transient: 30, average: 60}
    cases: [{depth: 3}, {depth: 2, overlap_limit: 1.0e-6}]
  - name: beds
    system: belt
    base: {beads: 100, width: 10, transient: 10, average: 30, replicates: 2}
    grid: {frequency: [20, 50]}
"""

#: The same before it has grown.
SHORT = STUDY.replace("average: 60", "average: 30").replace(
    "average: 30, replicates: 2", "average: 10"
)


def snakemake(tree: Path, target: str) -> subprocess.Popen:
    """Start the study in a session of its own; its log goes to ``drill.log``."""
    with (tree / "drill.log").open("a") as log:
        return subprocess.Popen(
            command(tree, target, study="drill.yaml"),
            cwd=tree,
            stdout=log,
            stderr=log,
            start_new_session=True,
            env=os.environ | {"TALUS_CHECKPOINT_SECONDS": "0.1"},
        )


class Drill:
    """Workflows in one folder, with counts of killed processes and of kills still required."""

    def __init__(self, tree: Path, kills: int = 0):
        self.tree = tree
        self.random = random.Random(SEED)
        self.sessions: set[int] = set()
        self.kills = dict.fromkeys(KINDS, 0)
        self.least = {"all": kills, "computing batch": kills / 3}
        self.early = False

    @property
    def is_over(self) -> bool:
        """True where enough processes were killed, of those that compute and of all."""
        counts = {"all": sum(self.kills.values()), **self.kills}
        return all(counts[kind] >= number for kind, number in self.least.items())

    def living(self) -> list[psutil.Process]:
        """Return all processes of all workflows so far, orphans included."""
        processes = []
        for process in psutil.process_iter():
            try:
                is_ours = os.getsid(process.pid) in self.sessions
                if is_ours and process.status() != psutil.STATUS_ZOMBIE:
                    processes.append(process)
            except (ProcessLookupError, psutil.NoSuchProcess):
                continue
        return processes

    def kill_one(self) -> None:
        """Kill a process of a random kind, mostly while runs compute."""
        by_kind = {kind: [] for kind in KINDS}
        for process in self.living():
            with suppress(psutil.NoSuchProcess):
                by_kind[self.kind(process)].append(process)
        # A study that is killed whenever it starts would never get to its runs.
        if not by_kind["computing batch"] and not (self.early and self.random.random() < SOON):
            return
        kind = self.random.choices(list(KINDS), KINDS.values())[0]
        with suppress(psutil.NoSuchProcess, IndexError):
            self.random.choice(by_kind[kind]).kill()
            self.kills[kind] += 1
            self.early = self.random.random() < EARLY

    def kind(self, process: psutil.Process) -> str:
        """Return the kind of a process: workflow, shell of a job, batch, or other job."""
        words = process.cmdline()
        if "snakemake" in words:
            return "workflow"
        if words and Path(words[0]).name == "bash":
            return "shell"
        if words[2:5] != ["sim", "job", "batch"]:
            return "other"
        for checkpoint in (self.tree / words[5] / "runs").glob(".*.state"):
            with suppress(FileNotFoundError):
                if checkpoint.stat().st_mtime > process.create_time():
                    return "computing batch"
        return "batch"

    def end(self) -> None:
        """Leave no process behind."""
        for process in self.living():
            with suppress(psutil.NoSuchProcess):
                process.kill()

    def start(self, target: str = "dataset") -> subprocess.Popen:
        """Start the workflow."""
        process = snakemake(self.tree, target)
        self.sessions.add(process.pid)
        return process

    def run(self) -> None:
        """Restart the workflow until it succeeds, killing processes until the drill is over."""
        code = 1
        while code != 0:
            process = self.start()
            while not self.is_over and process.poll() is None:
                time.sleep(self.random.uniform(0.0, PAUSE))
                self.kill_one()
            code = process.wait()
        wait_until(lambda: not self.living())


def arrays_equal(one: np.ndarray, other: np.ndarray) -> bool:
    """True where two arrays are equal, with NaN equal to NaN."""
    return np.array_equal(one, other, equal_nan=one.dtype.kind == "f")


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory) -> Path:
    """A folder in which the study has run to its end in peace."""
    tree = tmp_path_factory.mktemp("undisturbed")
    (tree / "drill.yaml").write_text(STUDY)
    assert snakemake(tree, "dataset").wait() == 0, (tree / "drill.log").read_text()
    return tree


@pytest.mark.long
def test_kills_at_random_moments_change_no_bit(undisturbed, tmp_path, request):
    """A hundred kills, of a study and of what it grows to."""
    study, tree = load_study(undisturbed / "drill.yaml"), tmp_path
    drills = {SHORT: Drill(tree, 33), STUDY: Drill(tree, 67)}
    while True:
        for text, drill in drills.items():
            request.addfinalizer(drill.end)
            (tree / "drill.yaml").write_text(text)
            drill.run()
        results, expected = (folder / "results" / "drill" for folder in (tree, undisturbed))
        runs = {path.name for path in (results / "runs").iterdir()}
        assert runs == {path.name for path in (expected / "runs").iterdir()}
        for point in study.points:
            name = f"runs/{point}.nc"
            assert digest(results / name) == digest(expected / name), point
        one, other = (contents(folder / "dataset.nc") for folder in (results, expected))
        assert [name for name in one if not arrays_equal(one[name], other[name])] == []
        if all(drill.is_over for drill in drills.values()):
            break
        shutil.rmtree(tree / "results")


def kill_workflow_only(drill: Drill, average: int) -> Path | None:
    """Kill a workflow while its run computes; return the future run file, ``None`` if it exists."""
    (drill.tree / "drill.yaml").write_text(
        "study: drill\nseries: [{name: a, system: belt, "
        f"base: {{beads: 200, transient: 10, average: {average}}}}}]\n"
    )
    (point,) = load_study(drill.tree / "drill.yaml", drill.tree).points
    output = drill.tree / "results" / "drill" / "runs" / f"{point}.nc"
    checkpoint = output.with_name(f".{output.name}.state")
    process = drill.start("runs")
    wait_until(lambda: checkpoint.exists() or output.exists(), process)
    process.kill()
    process.wait()
    return None if output.exists() else output


@pytest.mark.long
def test_a_run_that_outlives_its_workflow_is_kept(tmp_path, request):
    drill, average = Drill(tmp_path), 15
    request.addfinalizer(drill.end)
    # On a machine that looks too late, the run has ended before its workflow is killed.
    while not (output := kill_workflow_only(drill, average)):
        average *= 4
    wait_until(lambda: output.exists() or not drill.living())
    before = output.stat().st_ino
    assert drill.start("runs").wait() == 0, (tmp_path / "drill.log").read_text()
    assert output.stat().st_ino == before


DECIDING = """\
study: drill
series:
  - name: beds
    system: belt
    base: {beads: 40, width: 10, steps_per_cycle: 1000, transient: 20, average: 400, replicates: 2}
    grid: {frequency: [25, 26]}
decide: {precision: 0.01, budget: 1, replicates: 10}
"""


def start_deciding(tree: Path) -> subprocess.Popen:
    """Start rounds of decisions in a session of its own."""
    tree.mkdir(exist_ok=True)
    (tree / "drill.yaml").write_text(DECIDING)
    with (tree / "drill.log").open("a") as log:
        return subprocess.Popen(
            [sys.executable, "-m", "sim", "decide", "drill.yaml", "--cores", "2"],
            cwd=tree,
            stdout=log,
            stderr=log,
            start_new_session=True,
            env=os.environ | {"PYTHONPATH": str(ROOT), "TALUS_CHECKPOINT_SECONDS": "0"},
        )


def decided(tree: Path) -> tuple[dict, dict[str, str]]:
    """Return what was bought, and a hash of each run."""
    results = tree / "results" / "drill"
    bought = json.loads((results / "bought.json").read_text())
    runs = {path.name: digest(path) for path in (results / "runs").glob("belt-*.nc")}
    return {name: bought[name] for name in ("amounts", "rounds")}, runs


@pytest.mark.parametrize("kills", [pytest.param(10, marks=pytest.mark.long)])
def test_kills_between_rounds_of_decisions_change_nothing(kills, tmp_path, request):
    drill, alone = Drill(tmp_path / "killed"), tmp_path / "alone"
    request.addfinalizer(drill.end)
    begin = time.monotonic()
    assert start_deciding(alone).wait() == 0, (alone / "drill.log").read_text()
    seconds, log = time.monotonic() - begin, drill.tree / "drill.log"
    assert max(decided(alone)[0]["rounds"].values()) > 1
    while kills:
        process = start_deciding(drill.tree)
        drill.sessions.add(process.pid)
        with suppress(subprocess.TimeoutExpired):
            code = process.wait(drill.random.uniform(0.1, 0.7) * seconds)
            assert code == 0, log.read_text()
            # It has ended before the kill: from the beginning.
            shutil.rmtree(drill.tree / "results")
            continue
        drill.end()
        kills -= 1
    assert start_deciding(drill.tree).wait() == 0, log.read_text()
    assert "Traceback" not in log.read_text()
    assert decided(drill.tree) == decided(alone)
