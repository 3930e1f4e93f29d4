"""A study whose processes are killed at random moments ends in the bits of an undisturbed one.

TALUS_DRILL_KILLS sets the number of kills, TALUS_DRILL_SEED their moments and victims.
"""

import os
import random
import shutil
import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path

import netCDF4
import numpy as np
import psutil
import pytest

from sim.study.load import load_study
from tests.made.project import ROOT

KILLS = int(os.environ.get("TALUS_DRILL_KILLS", "30"))
SEED = int(os.environ.get("TALUS_DRILL_SEED", "1"))

#: How often each kind of process is chosen to be killed. A run computes if it has written a
#: checkpoint; another may still be starting.
KINDS = {"computing run": 0.5, "run": 0.2, "shell": 0.1, "workflow": 0.1, "other": 0.1}

#: Probability of a kill at a moment when nothing computes.
EARLY = 0.02

#: Seconds between two kills, at most.
PAUSE = 0.4

STUDY = """\
study: drill
series:
  - name: flows
    system: chute
    base: {cell: 5, transient: 50, average: 100}
    grid: {depth: [2, 3]}
    cases: [{depth: 2, overlap_limit: 1.0e-6}]
  - name: beds
    system: belt
    base: {transient: 10, average: 40, replicates: 2}
    grid: {frequency: [20, 50, 80]}
"""


def snakemake(tree: Path) -> subprocess.Popen:
    """Start the study in a session of its own; its log goes to ``drill.log``."""
    command = [sys.executable, "-m", "snakemake", "dataset", "--cores", "2"]
    with (tree / "drill.log").open("a") as log:
        return subprocess.Popen(
            [*command, "--configfile", "drill.yaml", "--snakefile", str(ROOT / "Snakefile")],
            cwd=tree,
            stdout=log,
            stderr=log,
            start_new_session=True,
            env=os.environ | {"TALUS_CHECKPOINT_SECONDS": "0.1"},
        )


class Drill:
    """Workflows in one folder, and what has been killed of them so far."""

    def __init__(self, tree: Path):
        self.tree = tree
        self.random = random.Random(SEED)
        self.sessions: set[int] = set()
        self.kills = dict.fromkeys(KINDS, 0)

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
        if not alive["computing run"] and self.random.random() > EARLY:
            return
        kind = self.random.choices(list(KINDS), KINDS.values())[0]
        with suppress(psutil.NoSuchProcess, IndexError):
            self.random.choice(alive[kind]).kill()
            self.kills[kind] += 1

    def kind(self, process: psutil.Process) -> str:
        """Say what a process is: the workflow, the shell of a job, a run or another job."""
        words = process.cmdline()
        if "snakemake" in words:
            return "workflow"
        if words and Path(words[0]).name == "bash":
            return "shell"
        if words[2:4] != ["sim", "run"]:
            return "other"
        output = self.tree / words[words.index("--output") + 1]
        with suppress(FileNotFoundError):
            saved = output.with_name(f".{output.name}.checkpoint").stat().st_mtime
            if saved > process.create_time():
                return "computing run"
        return "run"

    def end(self) -> None:
        """Leave no process behind."""
        for process in self.living():
            with suppress(psutil.NoSuchProcess):
                process.kill()

    def run(self, kills: int) -> None:
        """Start the workflow until it ends well, killing until there have been so many kills."""
        code = 1
        while code != 0:
            process = snakemake(self.tree)
            self.sessions.add(process.pid)
            while sum(self.kills.values()) < kills and process.poll() is None:
                time.sleep(self.random.uniform(0.0, PAUSE))
                self.kill_one()
            code = process.wait(timeout=300)
        limit = time.monotonic() + 60
        while self.living() and time.monotonic() < limit:
            time.sleep(0.1)


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory) -> Path:
    """A folder in which the study has run to its end in peace; it compiles the engine, too."""
    tree = tmp_path_factory.mktemp("undisturbed")
    (tree / "drill.yaml").write_text(STUDY)
    assert snakemake(tree).wait(timeout=300) == 0, (tree / "drill.log").read_text()
    return tree


def content(path: Path) -> dict[str, bytes | list]:
    """Return the bits of all variables of a file but the times that it took."""
    with netCDF4.Dataset(path) as file:
        file.set_auto_mask(False)
        values = {name: np.asarray(v[...]) for name, v in file.variables.items()}
    del values["wall_time"]
    return {
        name: array.tobytes() if array.dtype.kind in "fiu" else list(array.flat)
        for name, array in values.items()
    }


def test_kills_at_random_moments_change_no_bit(undisturbed, tmp_path, request):
    study = load_study(undisturbed / "drill.yaml")
    tree = tmp_path
    (tree / "drill.yaml").write_text(STUDY)
    drill = Drill(tree)
    request.addfinalizer(drill.end)
    while True:
        drill.run(KILLS)
        results, expected = (folder / "results" / "drill" for folder in (tree, undisturbed))
        assert content(results / "dataset.nc") == content(expected / "dataset.nc")
        runs = {path.name for path in (results / "runs").iterdir()}
        assert runs == {path.name for path in (expected / "runs").iterdir()}
        for point in study.points:
            name = f"runs/{point}.nc"
            assert content(results / name) == content(expected / name), point
        if sum(drill.kills.values()) >= KILLS:
            break
        shutil.rmtree(tree / "results")
    # A drill that hits nothing that computes would prove nothing.
    assert drill.kills["computing run"] >= KILLS / 3, drill.kills


def test_a_run_that_outlives_its_workflow_is_kept(undisturbed, tmp_path):
    text = (
        "study: drill\nseries: [{name: a, system: belt, base: {beads: 200, transient: 10, "
        "average: 250}}]\n"
    )
    (tmp_path / "drill.yaml").write_text(text)
    (point,) = load_study(tmp_path / "drill.yaml", tmp_path).points
    runs = tmp_path / "results" / "drill" / "runs"
    process = snakemake(tmp_path)
    wait_for(runs / f".{point}.nc.checkpoint")
    process.kill()
    process.wait()
    assert not (runs / f"{point}.nc").exists()
    wait_for(runs / f"{point}.nc")
    before = (runs / f"{point}.nc").stat().st_ino
    assert snakemake(tmp_path).wait(timeout=120) == 0, (tmp_path / "drill.log").read_text()
    assert (runs / f"{point}.nc").stat().st_ino == before


def wait_for(path: Path) -> None:
    limit = time.monotonic() + 60
    while not path.exists():
        assert time.monotonic() < limit
        time.sleep(0.02)
