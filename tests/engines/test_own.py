"""An engine of a plug-in: one call, and points, runs and refusals know it."""

import yaml

from sim.__main__ import main
from sim.dataset.build import build as build_dataset
from sim.engine.run import run_point
from sim.report.page import build as build_report
from sim.study.load import load_study
from tests.made.plugins import restore_plugins
from tests.made.processes import refusal

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


def test_a_second_opinion_of_a_plug_in(tmp_path, monkeypatch, capsys):
    """The plug-in calls the loop of this program; it refuses one of two points."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine.py").write_text(PLUGIN)
    base = {"depth": 1, "cell": 5, "transient": 2, "average": 4}
    series = {"name": "one", "system": "chute", "base": base, "grid": {"bumps": [0, 1]}}
    study = {"study": "small", "plugins": ["mine.py"], "series": [series]}
    (tmp_path / "small.yaml").write_text(yaml.safe_dump(study))
    with restore_plugins():
        runs = tmp_path / "results" / "small" / "runs"
        runs.mkdir(parents=True)
        for key, one in load_study("small.yaml").points.items():
            run_point(one.parameters, runs / f"{key}.nc", quiet=True)
        build_dataset("small.yaml", "results")
        ask = ("second-opinion", "small.yaml", "--share", "1")
        told = refusal(capsys, *ask)
        assert told.endswith("--engine: got nothing; allowed: one of lammps, mine")
        assert main([*ask, "--engine", "mine"]) == 0
        told = capsys.readouterr().out
        assert "over 1 point the ratio of mean velocities, mine over talus, is 1" in told
        build_report("small.yaml", "results")
        page = (runs.parent / "report.html").read_text(encoding="utf-8")
        assert "mine over talus" in page and "lammps over talus" not in page
        assert main(["orphans", "small.yaml"]) == 0
        assert capsys.readouterr().out == "none\n"
