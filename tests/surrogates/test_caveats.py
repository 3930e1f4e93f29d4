"""Every view of an answer tells what is doubtful about it, those that are added later as well."""

import ast
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import sim
from sim.claims.verdict_files import write as write_claims
from sim.dataset.build import build as build_dataset
from sim.figures import render
from sim.figures.data import Drawing
from sim.figures.plot import message_figure
from sim.figures.render import draw_figures
from sim.report import page
from sim.report.explorer import explorer_data
from sim.report.predict import predict
from sim.report.runs import run_rows, varied_parameters
from sim.study.load import load_study
from sim.surrogates import inquiries
from sim.surrogates.answers import caveats_in, parted, summary_lines
from sim.surrogates.storage import answer_files
from tests.made.runs import write_run
from tests.made.surrogates import rough_answers

STUDY = """
study: weak
series:
  - name: wide
    system: chute
    base: {depth: 5, replicates: 2}
    design: {kind: sobol, points: 16, over: {friction: [0.3, 0.8], angle: [14, 18]}}
  - name: blocks
    system: chute
    base: {depth: 5, replicates: 2}
    design: {kind: saltelli, points: 32, over: {friction: [0.3, 0.8], angle: [14, 18]}}
surrogate: [{name: speed, series: wide}]
sensitivity: [{name: matters, surrogate: speed}, {name: direct, series: blocks}]
calibrate: [{name: beads, data: exp.csv, surrogate: speed, parameters: {friction: [0.3, 0.8]}}]
"""

#: What each run says of itself.
DOUBT = "overlaps are large"


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    """Return the results of a study whose runs all carry a caveat, with pictures and report."""
    place = tmp_path_factory.mktemp("weak")
    (place / "exp.csv").write_text("angle, velocity, velocity_error\n15, 0.9, 0.05\n17, 1.1, 0.05")
    file = place / "weak.yaml"
    file.write_text(STUDY)
    study = load_study(file, place)
    for point in study.points.values():
        speed = (point.parameters.angle / 10 - point.parameters.friction) * np.array([0.99, 1.01])
        write_run(place / "weak" / "runs", point.parameters, speed, caveat=DOUBT)
    dataset = build_dataset(file, place)
    with rough_answers():
        inquiries.build(file, place)
    figures = dataset.parent / "figures"
    draw_figures(list(study.entries), dataset, figures, code="x", study_path=file)
    write_claims([], "weak", dataset.parent)
    page.build(file, place)
    return dataset.parent


def _study(folder: Path):
    return load_study(folder.parent / "weak.yaml", folder.parent)


def _predicted(folder: Path, format: str) -> list[str]:
    return [predict(folder, ("friction=0.5", "angle=16"), None, False, format, folder)]


def _report(folder: Path) -> list[str]:
    text = (folder / "report.html").read_text(encoding="utf-8")
    head = text[text.index('id="summary"') : text.index("</section>")]
    return [head[head.index(name) :][:300] for name in ("Surrogate", "Sensitivity", "Calibration")]


def _explored(folder: Path) -> list[str]:
    dataset, surrogate = sim.load(folder).dataset, sim.load(folder).surrogate("speed")
    runs = run_rows(dataset, [DOUBT])
    for run in runs:
        run["page"] = ""
    data = explorer_data(dataset, runs, varied_parameters(dataset), [surrogate])
    return [curve["note"] for curve in data["chute"]["curves"]]


def _pictures(folder: Path, suffix: str) -> list[str]:
    names = [name for name, spec in _study(folder).plots.items() if spec.answer.file]
    assert len(names) == 10
    return [(folder / "figures" / f"{name}{suffix}").read_text() for name in names]


def _called(folder: Path) -> list[str]:
    return [sim.load(folder).surrogate("speed")(friction=0.5, angle=16).attrs["caveats"]]


#: Modules that read answers, and what each shows of all of them.
VIEWS = {
    "sim/report/status.py": lambda folder: summary_lines(_study(folder), folder),
    "sim/surrogates/inquiries.py": lambda folder: [
        " ".join(caveats_in(path)) for path in answer_files(folder)
    ],
    "sim/report/page.py": _report,
    "sim/report/explorer.py": _explored,
    "sim/report/predict.py": lambda folder: (
        _predicted(folder, "table") + _predicted(folder, "json")
    ),
    "sim/report/results.py": lambda folder: [
        *_called(folder),
        *(line for line in repr(sim.load(folder)).splitlines() if line.split()[0] in KINDS),
    ],
    "sim/figures/render.py": lambda folder: (
        _pictures(folder, ".caption.txt") + _pictures(folder, ".csv")
    ),
    "sim/figures/surrogate_rows.py": lambda folder: _pictures(folder, ".svg"),
    "sim/figures/calibration.py": lambda folder: _pictures(folder, ".caption.txt"),
    "sim/figures/sensitivity.py": lambda folder: _pictures(folder, ".csv"),
}
KINDS = ("surrogate", "sensitivity", "calibration")

#: Functions of which one is imported by whoever reads an answer.
READERS = {
    *("load_surrogate", "load_table", "load_posterior", "find_surrogate", "answer_files"),
    "summary_lines",
}


def test_every_module_that_reads_answers_is_a_view_here():
    root = Path(sim.__file__).parent
    reading = {
        file.relative_to(root.parent).as_posix()
        for file in root.rglob("*.py")
        for node in ast.walk(ast.parse(file.read_text()))
        if isinstance(node, ast.ImportFrom) and node.module.startswith("sim.surrogates")
        if READERS & {one.name for one in node.names}
    }
    # Explorer and pictures get what others have read.
    assert reading | {"sim/report/explorer.py", "sim/figures/render.py"} == set(VIEWS)


@pytest.mark.parametrize("view", VIEWS)
def test_every_view_tells_the_caveat(folder, view):
    texts = VIEWS[view](folder)
    assert texts and [text for text in texts if DOUBT not in text] == []


def test_a_new_kind_of_picture_tells_it_without_knowing(folder, monkeypatch, tmp_path):
    table = pd.DataFrame({"value": [1.0]})
    new = Drawing(lambda data: message_figure("new"), lambda data: table, lambda data: ["New."])
    monkeypatch.setattr(render, "drawing_of", lambda name: new)
    spec = render.find_spec("speed-agreement", _study(folder).plots)
    render.render(spec.model_copy(update={"name": "new"}), folder / "dataset.nc", tmp_path)
    for suffix in ("svg", "csv", "caption.txt"):
        assert DOUBT in (tmp_path / f"new.{suffix}").read_text()


def test_caveats_are_parted_as_they_were_joined(folder):
    for path in answer_files(folder):
        assert parted("; ".join(caveats_in(path))) == caveats_in(path)
