"""A study on a real Slurm: batches, a cancelled job, a time limit, and the bits of a local run."""

import json
import os
import signal
import subprocess
import sys
import sysconfig
import tomllib
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import psutil
import pytest

from sim.engine.progress import progress_file
from sim.study.load import load_study
from tests.golden import digest
from tests.made.processes import ROOT, wait_until
from tests.made.project import jobs, plan, snakemake
from tests.slurm.cluster import ACCOUNT, PARTITION, Cluster, install, lacking

pytestmark = [pytest.mark.long, pytest.mark.skipif(bool(lacking()), reason=lacking())]

STUDY = Path(__file__).with_name("study.yaml")

#: What Slurm's accounting is asked for, of each job.
ACCOUNTED = (
    *("Comment", "State", "End", "Account", "Partition", "ReqMem", "TimelimitRaw"),
    "AllocCPUS",
)


@pytest.fixture(scope="module")
def cluster(tmp_path_factory) -> Iterator[Cluster]:
    install()
    with Cluster(tmp_path_factory.mktemp("cluster")) as cluster:
        yield cluster


@pytest.fixture(scope="module")
def python(tmp_path_factory) -> Path:
    """An interpreter with the packages of this one, and those of the extra `slurm`."""
    folder = tmp_path_factory.mktemp("venv")
    subprocess.run([sys.executable, "-m", "venv", folder], check=True)
    python = folder / "bin" / "python"
    paths = {"base": str(folder), "platbase": str(folder)}
    site = Path(sysconfig.get_path("purelib", "venv", vars=paths))
    (site / "project.pth").write_text(sysconfig.get_path("purelib") + "\n")
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    extra = project["optional-dependencies"]["slurm"]
    subprocess.run([python, "-m", "pip", "install", "--quiet", *extra], check=True)
    return python


class Submitted:
    """A study that runs on the cluster, from a folder of its own."""

    def __init__(self, cluster: Cluster, python: Path, tree: Path):
        self.cluster, self.tree = cluster, tree
        self.runs = tree / "results" / "cluster" / "runs"
        self._python = python
        self._started: list[subprocess.Popen] = []

    def start(self, *options: str, checked: bool = False) -> subprocess.Popen:
        """Start the workflow as the documentation says; what it says goes to ``said.log``.

        It is that of the repository, or the packaged one once the study is ``checked``.
        """
        command = ["-m", "snakemake", "--snakefile", str(ROOT / "Snakefile")]
        command += ["--profile", str(ROOT / "workflow" / "profiles" / "slurm")]
        command += ["--configfile", STUDY.name]
        if checked:
            command = ["-m", "sim", "study", STUDY.name, "--profile", "slurm", "--"]
        command += [
            "--default-resources",
            f"slurm_account={ACCOUNT}",
            f"slurm_partition={PARTITION}",
        ]
        command += ["--slurm-init-seconds-before-status-checks", "5", *options]
        with (self.tree / "said.log").open("w") as said:
            process = subprocess.Popen(
                [self._python, *command],
                cwd=self.tree,
                env=self.cluster.environment
                | {"TALUS_CHECKPOINT_SECONDS": "0.5", "PYTHONPATH": str(ROOT)},
                stdout=said,
                stderr=said,
            )
        self._started.append(process)
        return process

    def said(self) -> str:
        return (self.tree / "said.log").read_text(encoding="utf-8")

    def end(self) -> None:
        """Leave no workflow behind; its jobs end with the cluster."""
        for process in self._started:
            process.kill()
            process.wait()

    def cancel(self, rule: str) -> None:
        """Cancel the job of a rule: it is the comment of the job that names it."""
        for job in self.cluster.ask("squeue", "-h", "-o", "%i %k").splitlines():
            if job.endswith(f" rule_{rule}"):
                self.cluster.ask("scancel", job.split()[0])

    def accounts(self) -> list[dict[str, str]]:
        """Return what the cluster says of each job, once all have ended and are accounted for."""

        def table() -> list[dict[str, str]]:
            rows = self.cluster.ask("sacct", "-XnP", f"--format={','.join(ACCOUNTED)}").splitlines()
            return [dict(zip(ACCOUNTED, row.split("|"), strict=True)) for row in rows]

        wait_until(lambda: all(job["End"] != "Unknown" for job in table()))
        return table()

    def states(self, rule: str) -> list[str]:
        """Return the states in which the jobs of a rule have ended."""
        ours = [job for job in self.accounts() if job["Comment"].startswith(f"rule_{rule}")]
        return [job["State"].split()[0] for job in ours]

    def is_begun(self, point: str) -> bool:
        """Return whether a run has saved a state and is not at its end."""
        run = self.runs / f"{point}.nc"
        return run.with_name(f".{run.name}.state").exists() and not run.exists()

    def freeze(self, *points: str) -> bool:
        """Stop the process that runs one of some points, if it is in the first half of that.

        No machine is too fast then: a signal of Slurm lets the process go on, and ends it.
        """
        for point in filter(self.is_begun, points):
            with suppress(FileNotFoundError):
                said = json.loads(progress_file(self.runs / f"{point}.nc").read_text("utf-8"))
                if 2 * said["done"] < said["total"]:
                    os.kill(said["pid"], signal.SIGSTOP)
                    return True
        return False


@pytest.fixture
def submitted(cluster, python, tmp_path) -> Iterator[Submitted]:
    (tmp_path / STUDY.name).write_bytes(STUDY.read_bytes())
    submitted = Submitted(cluster, python, tmp_path)
    yield submitted
    submitted.end()


@pytest.fixture(scope="module")
def local(tmp_path_factory) -> Path:
    """The results of the study as this machine computes them without a cluster."""
    tree = tmp_path_factory.mktemp("local")
    (tree / STUDY.name).write_bytes(STUDY.read_bytes())
    done = snakemake(tree, "dataset", study=STUDY.name)
    assert done.returncode == 0, done.stderr
    return tree / "results" / "cluster"


def test_nothing_outlives_a_command_beside_a_cluster(cluster, tmp_path):
    """It is asked to end; `cluster` has installed what it needs."""
    began = tmp_path / "began"
    command = ["sh", "-c", f"touch {began}; exec sleep 100000"]
    beside = psutil.Popen([sys.executable, "-m", "tests.slurm", *command], cwd=ROOT)
    wait_until(began.exists, beside)
    started = beside.children()
    assert {"munged", "slurmd", "slurmctld"} <= {process.name() for process in started}
    beside.terminate()
    assert beside.wait() == 128 + signal.SIGTERM
    assert not any(process.is_running() for process in started)


def test_a_study_with_ended_jobs_comes_to_the_dataset_of_a_local_one(local, submitted):
    points = load_study(STUDY).points
    (long,) = (name for name, point in points.items() if point.parameters.system == "chute")
    runs = submitted.runs

    # The long run meets a limit of a minute; the batch is cancelled halfway.
    workflow = submitted.start("--set-resources", "run:runtime=1")
    wait_until(lambda: submitted.freeze(long), workflow)
    ((batch, members),) = json.loads((runs / ".batches").read_text(encoding="utf-8")).items()
    assert set(members) == set(points) - {long}
    wait_until(lambda: any((runs / f"{name}.nc").exists() for name in members), workflow)
    wait_until(lambda: submitted.freeze(*members), workflow)
    submitted.cancel(batch)
    assert workflow.wait() == 1, submitted.said()
    assert (submitted.states(batch), submitted.states("run")) == (["CANCELLED"], ["TIMEOUT"])
    assert submitted.is_begun(long)
    lines = submitted.said().splitlines()
    for name, state in ((batch, "CANCELLED"), (long, "TIMEOUT")):
        (line,) = (line for line in lines if line.startswith(f"{name}: job failed"))
        assert state in line and line.endswith("terminated; the next start continues it")

    # The command that checks the study first, without the limit, computes what is left, each from
    # where it was.
    finished = {path: path.stat().st_ino for path in runs.glob("*.nc")}
    assert 0 < len(finished) < len(members)
    assert submitted.start(checked=True).wait() == 0, submitted.said()
    assert {path: path.stat().st_ino for path in finished} == finished
    log = runs.parent / "logs" / "runs" / f"{long}.log"
    assert "continued from a checkpoint" in log.read_text(encoding="utf-8")
    assert jobs(plan(submitted.tree, study=STUDY.name)) == {}

    for name in ("dataset.nc", *(f"runs/{point}.nc" for point in points)):
        assert digest(runs.parent / name) == digest(local / name), name
    assert (runs.parent / "report.html").stat().st_size > 0

    # Every job was accounted for, with the memory and the time that its rule asks for.
    found = submitted.accounts()
    rules = [job["Comment"].removeprefix("rule_").partition("_")[0] for job in found]
    assert sorted(rules) == sorted(
        ["warm", "run", "run", "batch", "batch", "dataset", "claims", "figures", "report"]
    )
    assert {job["Account"] for job in found} == {ACCOUNT}
    assert {job["Partition"] for job in found} == {PARTITION}
    assert {job["State"] for job in found[3:]} == {"COMPLETED"}
    assert {job["TimelimitRaw"] for job in found if job["Comment"].startswith("rule_run_")} == {
        "1",
        "10",
    }
    assert all(int(job["ReqMem"].removesuffix("M")) >= 700 for job in found)

    # Folders of logs stay: another study in the same folder may be about to need them.
    assert (submitted.tree / ".snakemake" / "slurm_logs" / "rule_warm").is_dir()


def test_processes_of_another_engine_are_tasks_of_a_job(submitted):
    pytest.importorskip("lammps")
    base = {"law": "spring_dashpot", "depth": 2, "cell": 5, "transient": 2, "average": 2}
    series = {"name": "one", "system": "chute", "base": base | {"engine": "lammps", "ranks": 2}}
    path = submitted.tree / STUDY.name
    path.write_text(json.dumps({"study": "cluster", "series": [series]}))
    (point,) = load_study(path).points
    assert submitted.start("runs").wait() == 0, submitted.said()
    assert (submitted.runs / f"{point}.nc").is_file()
    (job,) = (one for one in submitted.accounts() if one["Comment"].startswith("rule_run_mpi"))
    assert (job["State"], job["AllocCPUS"]) == ("COMPLETED", "2")
