"""An engine of a plug-in: one call, and points, runs and refusals know it."""

import os
import subprocess
import sys

import yaml

from tests.made.processes import ROOT

PLUGIN = """\
import sim


def make(p, replicate, substeps):
    from sim.engine.systems import build_own

    return build_own(p, replicate, substeps)


def refuses(p):
    if p.bumps:
        yield "bumps", "0"


sim.flow_engine(
    "mine", description="one of mine", make=make, refuses=refuses, lacks=["stored_energy"]
)
"""

SCRIPT = """\
import sim

sim.load_plugins("mine.py")
values = {"depth": 1, "cell": 5, "transient": 1, "average": 1, "progress": False}
run = sim.simulate("chute", engine="mine", **values)
print(str(run.engine.values)[:5], "mean_velocity" in run)
try:
    sim.simulate("chute", engine="mine", bumps=1, **values)
except sim.InputError as error:
    print(error)
"""


#: Runs a study of two points, one of which the engine refuses, and makes its dataset.
STUDY = """\
from pathlib import Path
from sim.dataset.build import build
from sim.engine.run import run_point
from sim.study.load import load_study

for key, one in load_study("small.yaml").points.items():
    path = Path("results/small/runs", f"{key}.nc")
    path.parent.mkdir(parents=True, exist_ok=True)
    run_point(one.parameters, path, quiet=True)
build("small.yaml", "results")
"""


def run(folder, *command):
    return subprocess.run(
        [sys.executable, *command],
        cwd=folder,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
    )


def test_a_second_opinion_of_a_plug_in(tmp_path):
    (tmp_path / "mine.py").write_text(PLUGIN)
    base = {"depth": 1, "cell": 5, "transient": 2, "average": 4}
    series = {"name": "one", "system": "chute", "base": base, "grid": {"bumps": [0, 1]}}
    study = {"study": "small", "plugins": ["mine.py"], "series": [series]}
    (tmp_path / "small.yaml").write_text(yaml.safe_dump(study))
    assert (made := run(tmp_path, "-c", STUDY)).returncode == 0, made.stderr
    ask = ("-m", "sim", "second-opinion", "small.yaml", "--share", "1")
    several = run(tmp_path, *ask)
    assert several.returncode == 2
    assert several.stderr.endswith("--engine: got nothing; allowed: one of lammps, mine\n")
    told = run(tmp_path, *ask, "--engine", "mine")
    assert told.returncode == 0, told.stderr
    # The plug-in calls the loop of this program.
    assert "over 1 point the ratio of mean velocities, mine over talus, is 1" in told.stdout
    report = "from sim.report.page import build; build('small.yaml', 'results')"
    assert (made := run(tmp_path, "-c", report)).returncode == 0, made.stderr
    page = (tmp_path / "results" / "small" / "report.html").read_text(encoding="utf-8")
    assert "mine over talus" in page and "lammps over talus" not in page
    assert run(tmp_path, "-m", "sim", "orphans", "small.yaml").stdout == "none\n"


def test_a_plug_in_adds_an_engine(tmp_path):
    (tmp_path / "mine.py").write_text(PLUGIN)
    done = run(tmp_path, "-c", SCRIPT)
    assert done.returncode == 0, done.stderr
    first, second = done.stdout.splitlines()
    assert first == "mine. True"
    assert second.endswith("bumps: got 1; allowed: 0 with engine: mine")
