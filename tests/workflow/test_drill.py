"""A study whose processes are killed at random moments ends in the bits of an undisturbed one.

TALUS_DRILL_SEED sets their moments and victims.
"""

import os
import random
import shutil
import subprocess
import time
from contextlib import suppress
from pathlib import Path

import numpy as np
import psutil
import pytest

from sim.study.load import load_study
from tests.golden import contents, digest
from tests.made.processes import wait_until
from tests.made.project import command

SEED = int(os.environ.get("TALUS_DRILL_SEED", "1"))

#: How often each kind of process is chosen to be killed. A batch computes if it has written a
#: checkpoint; another may still be starting.
KINDS = {"computing batch": 0.5, "batch": 0.2, "shell": 0.1, "workflow": 0.1, "other": 0.1}

#: Share of the kills that do not wait until something computes, and how likely each pause is then
#: the last.
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


def snakemake(tree: Path) -> subprocess.Popen:
    """Start the study in a session of its own; its log goes to ``drill.log``."""
    with (tree / "drill.log").open("a") as log:
        return subprocess.Popen(
            command(tree, "dataset", study="drill.yaml"),
            cwd=tree,
            stdout=log,
            stderr=log,
            start_new_session=True,
            env=os.environ | {"TALUS_CHECKPOINT_SECONDS": "0.1"},
        )


class Drill:
    """Workflows in one folder, what has been killed of them so far and what is still to be."""

    def __init__(self, tree: Path, kills: int = 0):
        self.tree = tree
        self.random = random.Random(SEED)
        self.sessions: set[int] = set()
        self.kills = dict.fromkeys(KINDS, 0)
        self.least = {"all": kills, "computing batch": kills / 3}
        self.early = False

    @property
    def is_over(self) -> bool:
        """Whether enough was killed; a drill that hits nothing that computes proves nothing."""
        found = {"all": sum(self.kills.values()), **self.kills}
        return all(found[kind] >= number for kind, number in self.least.items())

    def living(self) -> list[psutil.Process]:
        """Return all processes of all workflows so far, orphans included."""
        found = []
        for process in psutil.process_iter():
            try:
                ours = os.getsid(process.pid) in self.sessions
                if ours and process.status() != psutil.STATUS_ZOMBIE:
                    found.append(process)
            except (ProcessLookupError, psutil.NoSuchProcess):
                continue
        return found

    def kill_one(self) -> None:
        """Kill a process of a kind that is drawn, mostly while runs compute."""
        alive = {kind: [] for kind in KINDS}
        for process in self.living():
            with suppress(psutil.NoSuchProcess):
                alive[self.kind(process)].append(process)
        # A study that is killed whenever it starts would never get to its runs.
        if not alive["computing batch"] and not (self.early and self.random.random() < SOON):
            return
        kind = self.random.choices(list(KINDS), KINDS.values())[0]
        with suppress(psutil.NoSuchProcess, IndexError):
            self.random.choice(alive[kind]).kill()
            self.kills[kind] += 1
            self.early = self.random.random() < EARLY

    def kind(self, process: psutil.Process) -> str:
        """Say what a process is: the workflow, the shell of a job, a batch or another job."""
        words = process.cmdline()
        if "snakemake" in words:
            return "workflow"
        if words and Path(words[0]).name == "bash":
            return "shell"
        if words[2:4] != ["sim", "batch"]:
            return "other"
        for checkpoint in (self.tree / words[4] / "runs").glob(".*.state"):
            with suppress(FileNotFoundError):
                if checkpoint.stat().st_mtime > process.create_time():
                    return "computing batch"
        return "batch"

    def end(self) -> None:
        """Leave no process behind."""
        for process in self.living():
            with suppress(psutil.NoSuchProcess):
                process.kill()

    def start(self) -> subprocess.Popen:
        """Start the workflow."""
        process = snakemake(self.tree)
        self.sessions.add(process.pid)
        return process

    def run(self) -> None:
        """Start the workflow until it ends well, killing until that is over."""
        code = 1
        while code != 0:
            process = self.start()
            while not self.is_over and process.poll() is None:
                time.sleep(self.random.uniform(0.0, PAUSE))
                self.kill_one()
            code = process.wait()
        wait_until(lambda: not self.living())


def same(one: np.ndarray, other: np.ndarray) -> bool:
    """Return whether two arrays hold the same, unknown numbers included."""
    return np.array_equal(one, other, equal_nan=one.dtype.kind == "f")


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory) -> Path:
    """A folder in which the study has run to its end in peace; it compiles the engine, too."""
    tree = tmp_path_factory.mktemp("undisturbed")
    (tree / "drill.yaml").write_text(STUDY)
    assert snakemake(tree).wait() == 0, (tree / "drill.log").read_text()
    return tree


@pytest.mark.parametrize(
    "kills", [{SHORT: 1, STUDY: 1}, pytest.param({SHORT: 33, STUDY: 67}, marks=pytest.mark.long)]
)
def test_kills_at_random_moments_change_no_bit(kills, undisturbed, tmp_path, request):
    """The second study is what the first one grows to."""
    study, tree = load_study(undisturbed / "drill.yaml"), tmp_path
    drills = {text: Drill(tree, number) for text, number in kills.items()}
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
        assert [name for name in one if not same(one[name], other[name])] == []
        if all(drill.is_over for drill in drills.values()):
            break
        shutil.rmtree(tree / "results")


def outlived(drill: Drill, average: int) -> Path | None:
    """Kill a workflow whose run computes; return the run file to be, none if it was there."""
    (drill.tree / "drill.yaml").write_text(
        "study: drill\nseries: [{name: a, system: belt, "
        f"base: {{beads: 200, transient: 10, average: {average}}}}}]\n"
    )
    (point,) = load_study(drill.tree / "drill.yaml", drill.tree).points
    output = drill.tree / "results" / "drill" / "runs" / f"{point}.nc"
    checkpoint = output.with_name(f".{output.name}.state")
    process = drill.start()
    wait_until(lambda: checkpoint.exists() or output.exists(), process)
    process.kill()
    process.wait()
    return None if output.exists() else output


def test_a_run_that_outlives_its_workflow_is_kept(undisturbed, tmp_path, request):
    drill, average = Drill(tmp_path), 250
    request.addfinalizer(drill.end)
    # On a machine that looks too late, the run has ended before its workflow is killed.
    while not (output := outlived(drill, average)):
        average *= 4
    wait_until(lambda: output.exists() or not drill.living())
    before = output.stat().st_ino
    assert drill.start().wait() == 0, (tmp_path / "drill.log").read_text()
    assert output.stat().st_ino == before
