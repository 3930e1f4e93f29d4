"""Workflows that were killed or find a damaged file: their messages and reruns."""

import os
import random
import re
import shutil
import signal
import subprocess
import time
from pathlib import Path

import pytest

from sim.study.load import load_study
from tests.made.processes import wait_until
from tests.made.project import bare_folder, command, jobs, planned_jobs, points, snakemake

#: Beads enough for points of different lengths.
STUDY = """\
study: small
defaults: {belt: {width: 5, steps_per_cycle: 1000, transient: 1, average: 2}}
series: [{name: beds, system: belt, grid: {beads: [10, 12, 14, 16, 18, 20]}}]
"""


class Killed:
    """A workflow over all points on one core, killed in the middle of its runs."""

    def __init__(self, tree: Path):
        (tree / "small.yaml").write_text(STUDY)
        self.study = load_study(tree / "small.yaml", tree / "results")
        self.runs = tree / "results" / "small" / "runs"
        log = tree / "killed.log"
        while not self._stopped_halfway(tree, log):
            shutil.rmtree(tree / "results")
        # It lives, and can get no further meanwhile.
        self.second = snakemake(tree, "runs", study="small.yaml")
        os.killpg(self.process.pid, signal.SIGKILL)
        self.process.wait()
        self.before = {path: path.stat().st_mtime_ns for path in self.runs.glob("*.nc")}
        self.resumed = snakemake(tree, "dataset", study="small.yaml")

    def _stopped_halfway(self, tree: Path, log: Path) -> bool:
        """Start the workflow, stop it after three runs; true where some runs are still missing."""
        with log.open("w") as file:
            self.process = subprocess.Popen(
                command(tree, "runs", "--cores", "1", study="small.yaml"),
                cwd=tree,
                stdout=file,
                stderr=file,
                start_new_session=True,
            )
        wait_until(lambda: self.run_file_count() >= 3, self.process)
        os.killpg(self.process.pid, signal.SIGSTOP)
        if self.run_file_count() < len(self.study.points):
            return True
        os.killpg(self.process.pid, signal.SIGKILL)
        self.process.wait()
        return False

    def run_file_count(self) -> int:
        """Return the number of run files."""
        return len(list(self.runs.glob("*.nc")))


@pytest.fixture(scope="module")
def killed(tmp_path_factory) -> Killed:
    return Killed(tmp_path_factory.mktemp("killed"))


def test_a_killed_workflow_resumes_by_itself_and_a_living_one_keeps_its_lock(killed):
    assert killed.second.returncode != 0
    assert "cannot be locked" in killed.second.stdout + killed.second.stderr
    assert len(killed.before) < len(killed.study.points)
    assert killed.resumed.returncode == 0, killed.resumed.stderr
    assert {path.stem for path in killed.runs.glob("*.nc")} == set(killed.study.points)
    rerun = [path for path, changed in killed.before.items() if path.stat().st_mtime_ns != changed]
    assert len(rerun) <= 1
    # An empty folder may be left, of a process that was killed after it had renamed its file.
    assert not [path for path in killed.runs.glob(".*.part") if any(path.iterdir())]


def test_a_killed_study_starts_again_while_another_runs_in_the_folder(tmp_path):
    """Snakemake's own locks do not say whose they are."""
    processes = []
    try:
        for name in ("small", "other"):
            (tmp_path / f"{name}.yaml").write_text(STUDY.replace("study: small", f"study: {name}"))
            words = command(tmp_path, "warm", study=f"{name}.yaml")
            process = subprocess.Popen(words, cwd=tmp_path, start_new_session=True)
            processes.append(process)
            wait_until((tmp_path / "results" / name / "runs" / ".batches").exists, process)
            os.killpg(process.pid, signal.SIGSTOP)
        os.killpg(processes[0].pid, signal.SIGKILL)
        restarted = snakemake(tmp_path, "warm", study="small.yaml")
        assert restarted.returncode == 0, restarted.stderr
    finally:
        for process in processes:
            os.killpg(process.pid, signal.SIGKILL)
            process.wait()


def test_a_damaged_run_is_named_and_computed_again_by_a_rerun(killed):
    """And a workflow that fails ends with a summary as others do."""
    tree = killed.runs.parents[2]
    path = sorted(killed.runs.glob("*.nc"))[1]
    content = path.read_bytes()
    path.write_bytes(content[: len(content) // 2])
    first = snakemake(tree, "dataset", study="small.yaml")
    assert first.returncode != 0
    assert f"error: results/small/runs/{path.name}: damaged" in first.stdout + first.stderr
    assert re.search(r"^6 points: 5 done", first.stderr, re.M)
    assert path.with_name(f"{path.name}.damaged").exists()
    rerun = snakemake(tree, "dataset", study="small.yaml")
    assert rerun.returncode == 0, rerun.stderr
    assert jobs(rerun.stderr) == {"run": 1, "dataset": 1}
    assert points(rerun.stderr) == [path.stem]
    assert len(path.read_bytes()) == pytest.approx(len(content), rel=0.01)
    assert planned_jobs(tree, "dataset", study="small.yaml") == {}


def test_what_a_batch_has_finished_stays_when_it_fails(killed, tmp_path):
    """Snakemake would put back the run files as they were before the job."""
    shutil.copytree(killed.runs.parents[2], tmp_path, dirs_exist_ok=True)
    study = (tmp_path / "small.yaml").read_text().replace("average: 2", "average: 2, replicates: 2")
    (tmp_path / "small.yaml").write_text(study)
    results = tmp_path / "results" / "small"
    before = {path: path.read_bytes() for path in (results / "runs").glob("*.nc")}
    # The longest comes first; the shortest cannot write its log.
    (shortest,) = (path for path in before if "beads10-" in path.name)
    log = results / "logs" / "runs" / f"{shortest.stem}.log"
    log.unlink()
    log.mkdir()
    process = snakemake(tmp_path, "runs", study="small.yaml")
    assert process.returncode == 1 and "job failed: error: " in process.stderr
    same = [path for path, content in before.items() if path.read_bytes() == content]
    assert same == [shortest]


SEED = int(os.environ.get("TALUS_DRILL_SEED", "1"))

DAY = 86400.0


@pytest.fixture(scope="module")
def finished(tmp_path_factory) -> Path:
    """Return a folder with a finished study."""
    tree = bare_folder(tmp_path_factory.mktemp("clocks"))
    process = snakemake(tree)
    assert process.returncode == 0, process.stderr
    return tree


def contents(tree: Path) -> dict[Path, bytes]:
    """Return the content of all results but logs, benchmarks and notes."""
    paths = (tree / "results").rglob("*")
    kinds = (".nc", ".csv", ".svg", ".json", ".html")
    return {path: path.read_bytes() for path in paths if path.suffix in kinds and path.is_file()}


def ahead(chance: random.Random, path: Path) -> float:
    """A clock that was a day ahead until some files were made, and was then put right."""
    return chance.choice((0.0, DAY))


def behind(chance: random.Random, path: Path) -> float:
    """A clock that went back a day before some files were made."""
    return chance.choice((0.0, -DAY))


def jumping(chance: random.Random, path: Path) -> float:
    return chance.uniform(-2 * DAY, 2 * DAY)


@pytest.mark.long
@pytest.mark.parametrize("clock", [ahead, behind, jumping])
def test_times_of_files_run_nothing_again(clock, finished):
    chance, now, before = random.Random(SEED), time.time(), contents(finished)
    for path in sorted((finished / "results").rglob("*")):
        if path.is_file():
            shifted = now + clock(chance, path)
            os.utime(path, (shifted, shifted))
    times = {path: path.stat().st_ino for path in before if path.parent.name == "runs"}
    process = snakemake(finished)
    assert process.returncode == 0, process.stderr
    assert "batch" not in jobs(process.stderr) and "run" not in jobs(process.stderr)
    assert {path: path.stat().st_ino for path in times} == times
    after = contents(finished)
    # A report says when it was made.
    same = [path for path in before if path.suffix != ".html"]
    assert [path for path in same if after[path] != before[path]] == []
    assert jobs(snakemake(finished).stderr) == {}
