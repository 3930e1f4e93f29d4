"""Answers of a study with made-up runs, some refused: their numbers, and what every view tells."""

import ast
import shutil
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import xarray as xr

import sim
from sim.base.errors import InputError
from sim.base.seals import DamagedError
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
from sim.report.status import as_text, survey
from sim.study.file import QUESTIONS
from sim.study.load import load_study
from sim.surrogates import answers, inquiries, storage
from sim.surrogates.answers import (
    Refusal,
    caveats_in,
    refusal_in,
    save_refusal,
)
from sim.surrogates.posterior import summarize
from sim.surrogates.storage import answer_files, load_surrogate, summary_lines
from tests.made.runs import write_run
from tests.made.surrogates import rough_answers

OVER = "{friction: [0.3, 0.8], restitution: [0.6, 0.95], angle: [14, 18]}"
STUDY = f"""\
study: asked
defaults: {{chute: {{depth: 5, replicates: 2}}}}
series:
  - {{name: wide, system: chute, design: {{kind: sobol, points: 16, over: {OVER}}}}}
  - {{name: many, system: chute, design: {{kind: morris, points: 40, over: {OVER}}}}}
  - {{name: blocks, system: chute, design: {{kind: saltelli, points: 40, over: {OVER}}}}}
  - {{name: few, system: chute, base: {{restitution: 0.8}},
     grid: {{friction: [0.3, 0.55, 0.8], angle: [14, 18]}}}}
plots:
  - {{name: seen, kind: scatter, series: [wide], x: friction}}
surrogate: [{{name: speed, series: wide}}, {{name: gone, series: few, regimes: [accelerating]}}]
sensitivity:
  - {{name: matters, surrogate: speed}}
  - {{name: screening, series: many}}
  - {{name: direct, series: blocks}}
  - {{name: none, surrogate: gone}}
  - {{name: lost, series: blocks, regimes: [accelerating]}}
propagate:
  - {{name: spread, surrogate: speed, exceeds: [1.5]}}
  - {{name: apart, series: wide}}
  - {{name: vague, surrogate: gone}}
calibrate:
  - {{name: beads, data: exp.csv, surrogate: speed, parameters: {{friction: [0.3, 0.8]}}}}
  - {{name: dust, data: exp.csv, surrogate: gone, parameters: {{friction: [0.3, 0.8]}}}}
"""

#: The friction of the material that was "measured", and the restitution that is known of it.
FRICTION, RESTITUTION = 0.55, 0.8

#: What each run says of itself.
DOUBT = "overlaps are large"

#: Variances of friction, restitution and angle, evenly spread.
SHARES = np.array([0.5**2, 0.0, 0.4**2]) / (0.5**2 + 0.4**2)

#: What is said of the surrogate without a mean, and of what is asked of it.
NO_MEAN = "surrogate gone: no mean, as 0 of 6 points of series few count (accelerating)"

#: How the lines of all answers begin.
LINES = (
    "surrogate speed: 16 points, error ",
    f"{NO_MEAN} and 6 are needed; left out are 6 steady",
    "sensitivity matters: total index of friction 0.6",
    "sensitivity screening: mean size of the effect of friction 0.5",
    "sensitivity direct: total index of angle ",
    f"sensitivity none: no indices without its surrogate; {NO_MEAN}",
    "sensitivity lost: no indices, as 0 of 8 blocks of 5 points have",
    "propagation spread: mean 1.0",
    "propagation apart: mean 1.0",
    f"propagation vague: no spread without its surrogate; {NO_MEAN}",
    "calibration beads: friction = 0.5",
    f"calibration dust: no posterior without its surrogate; {NO_MEAN}",
)

AT = ("friction=0.5", "restitution=0.8", "angle=16")


def velocity(friction, angle):
    """Return the velocity of a made-up flow, which the restitution does not change."""
    return angle / 10 - friction


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    """Return the results of the study, with pictures and report; a point of `many` has failed."""
    place = tmp_path_factory.mktemp("asked")
    rows = "".join(
        f"{angle}, {RESTITUTION}, {velocity(FRICTION, angle):.4f}, 0.02\n" for angle in (15, 17)
    )
    (place / "exp.csv").write_text(f"angle, restitution, velocity, velocity_error\n{rows}")
    file = place / "asked.yaml"
    file.write_text(STUDY)
    study = load_study(file, place)
    lost = study.series["many"][5]
    for key, point in study.points.items():
        speed = velocity(point.parameters.friction, point.parameters.angle) * np.array(
            [0.999, 1.001]
        )
        failed = (0, 1) if key == lost else ()
        write_run(place / "asked" / "runs", point.parameters, speed, failed=failed, caveat=DOUBT)
    dataset = build_dataset(file, place)
    with rough_answers():
        inquiries.build(file, place)
    figures = dataset.parent / "figures"
    draw_figures(list(study.entries), dataset, figures, code="x", study_path=file)
    write_claims([], "asked", dataset.parent)
    page.build(file, place)
    return dataset.parent


def _study(folder: Path):
    return load_study(folder.parent / "asked.yaml", folder.parent)


def test_each_question_says_in_a_line_what_it_found_or_why_it_has_no_answer(folder):
    study = _study(folder)
    lines = summary_lines(study, folder)
    assert len(lines) == len(LINES)
    for line, start in zip(lines, LINES, strict=True):
        assert line.startswith(start) and "\n" not in line
    assert as_text(survey(study, folder.parent)).endswith("\n".join(lines))
    with xr.open_dataset(folder / "calibration" / "dust.nc") as file:
        assert file.attrs["refusal"] == lines[-1]


def test_an_answer_whose_file_has_changed_is_told_as_damaged(folder, tmp_path):
    study, copy = _study(folder), Path(shutil.copytree(folder, tmp_path / "asked"))
    told = zip(study.questions, summary_lines(study, folder), strict=True)
    answered = [copy / question.file for question, line in told if ": no " not in line]
    for path in answered:
        content = bytearray(path.read_bytes())
        content[len(content) // 3] ^= 1
        path.write_bytes(content)
    damaged = [
        line for line in summary_lines(study, copy) if line.endswith("damaged; rerun the study")
    ]
    assert len(damaged) == len(answered) == 7


@pytest.mark.parametrize(
    ("name", "index", "values", "within", "blocks", "left_out"),
    [
        ("matters", "first", SHARES, 0.03, None, 0),
        ("matters", "total", SHARES, 0.03, None, 0),
        ("direct", "total", SHARES, 0.35, 8, 0),
        ("screening", "mu", [-0.5, 0, 0.4], 0.01, 9, 1),
    ],
)
def test_indices_are_those_of_the_function(folder, name, index, values, within, blocks, left_out):
    table = pd.read_csv(folder / "sensitivity" / f"{name}.csv").query(f"index == '{index}'")
    assert table["value"].to_numpy() == pytest.approx(np.array(values), abs=within)
    assert set(table["left_out"]) == {left_out}
    assert blocks is None or set(table["blocks"]) == {blocks}


def test_a_calibration_has_the_friction_of_the_material_and_tells_of_its_surrogate(folder):
    groups = storage.load_posterior(folder / "calibration" / "beads.nc")
    (row,) = summarize(groups).itertuples()
    assert row.low < FRICTION < row.high and row.informed
    assert groups["constant_data"]["restitution"].values.tolist() == [RESTITUTION] * 2
    about = groups["observed_data"].attrs
    assert about["surrogate_error"] == load_surrogate(folder / "surrogates" / "speed.nc").error
    assert about["surrogate_points"] == about["points"] == 16
    assert about["uncounted"] == 0 and about["regimes"] == "steady"


def test_a_question_asks_for_a_surrogate_that_is_sure(folder):
    unsure, lack = load_surrogate(folder / "surrogates" / "speed.nc"), "calibration: no posterior"
    unsure.__dict__["error"] = 0.25
    inquiries.require_small_error(unsure, 0.3, lack)
    with pytest.raises(Refusal, match=f"{lack}, as the error of surrogate speed is above 20 % "):
        inquiries.require_small_error(unsure, None, lack)


def ask(folder: Path, name: str | None = "speed", study: str = "", format: str = "table") -> str:
    """Return what a study predicts, the one of the answers or one that has changed since."""
    file = folder.parent / ("changed.yaml" if study else "asked.yaml")
    file.write_text(study or STUDY)
    return predict(file, AT, name, False, format, folder.parent)


@pytest.mark.parametrize(
    ("old", "new", "name", "message"),
    [
        ("points: 16", "points: 12", "speed", "point chute-depth5-.*: not as in .*; run the study"),
        ("name: speed", "regimes: [mixed], name: speed", "speed", "surrogate speed"),
        ("speed", "pace", "pace", "surrogate pace: not as in .*asked; run the study again"),
        ("surrogate: [", "surrogate: [{name: pace, series: many}, ", "pace", "pace: not as in"),
        ("", "", "gone", NO_MEAN.partition(",")[0]),
        ("", "", "velocity", "allowed: one of gone, speed"),
    ],
)
def test_a_prediction_is_of_the_study_as_it_is_or_refused(folder, old, new, name, message):
    changed = STUDY.replace(old, new) if old else STUDY
    if name == "pace" and "speed" in changed:
        assert "surrogate speed: " in ask(folder, "speed", changed)
    with pytest.raises(InputError, match=message):
        ask(folder, name, changed)
    if not old:
        with pytest.raises(InputError, match=message):
            sim.load(folder).surrogate(name)


def test_a_new_title_changes_no_prediction(folder):
    assert ask(folder, "speed", f"title: Another\n{STUDY}") == ask(folder)


def test_pictures_show_an_answer_or_say_why_there_is_none(folder):
    study = _study(folder)
    lines = dict(
        zip((one.file for one in study.questions), summary_lines(study, folder), strict=True)
    )
    counts = {True: 0, False: 0}
    for name, spec in study.plots.items():
        text, table, drawn = (
            (folder / "figures" / f"{name}{suffix}").read_text()
            for suffix in (".caption.txt", ".csv", ".svg")
        )
        line = lines.get(spec.answer.file, "")
        is_refused = ": no " in line
        counts[is_refused] += 1
        assert is_refused == ("Nothing is drawn: " in text) == table.startswith("refusal\n")
        assert (folder / "figures" / f"{name}.png").stat().st_size
        if is_refused:
            assert line in text and line in table.replace('"', "")
            assert all(word in drawn for word in line.split()[:3])
        else:
            assert text.startswith(spec.lead)
    assert counts == {True: 11, False: 17}


def _answered(texts: list[str]) -> list[str]:
    return [text for text in texts if ": no " not in text]


def _report(folder: Path) -> list[str]:
    text = (folder / "report.html").read_text(encoding="utf-8")
    head = text[text.index('id="summary"') : text.index("</section>")]
    names = ["Surrogate speed", "Sensitivity matters", "Sensitivity direct", "Calibration beads"]
    names += ["Propagation spread", "Propagation apart"]
    return [head[head.index(name) :][:300] for name in names]


def _explored(folder: Path) -> list[str]:
    dataset, surrogate = sim.load(folder).dataset, sim.load(folder).surrogate("speed")
    runs = [run | {"page": ""} for run in run_rows(dataset, [DOUBT])]
    data = explorer_data(dataset, runs, varied_parameters(dataset), [surrogate])
    return [curve["note"] for curve in data["chute"]["curves"]]


def _pictures(folder: Path, suffix: str) -> list[str]:
    figures = folder / "figures"
    names = [name for name, spec in _study(folder).plots.items() if spec.answer.file]
    captions = {name: (figures / f"{name}.caption.txt").read_text() for name in names}
    drawn = [name for name, text in captions.items() if "Nothing is drawn" not in text]
    return [(figures / f"{name}{suffix}").read_text() for name in drawn]


def _in_python(folder: Path) -> list[str]:
    called = sim.load(folder).surrogate("speed")(friction=0.5, restitution=0.8, angle=16)
    lines = repr(sim.load(folder)).splitlines()
    kinds = [one.noun() for one in QUESTIONS.values()]
    return [called.attrs["caveats"], *(line for line in lines if line.split()[0] in kinds)]


#: Modules that read answers, and what each shows of all of them.
VIEWS = {
    "sim/report/status.py": lambda folder: summary_lines(_study(folder), folder),
    "sim/surrogates/inquiries.py": lambda folder: [
        refusal_in(path) or " ".join(caveats_in(path)) for path in answer_files(folder)
    ],
    "sim/report/page.py": _report,
    "sim/report/explorer.py": _explored,
    "sim/report/predict.py": lambda folder: [
        ask(folder),
        ask(folder, format="json"),
        predict(folder, [], "speed", False, "table", highest=True),
    ],
    "sim/report/results.py": _in_python,
    "sim/figures/render.py": lambda folder: (
        _pictures(folder, ".caption.txt") + _pictures(folder, ".csv")
    ),
    "sim/figures/surrogates.py": lambda folder: _pictures(folder, ".svg"),
    "sim/figures/calibration.py": lambda folder: _pictures(folder, ".caption.txt"),
    "sim/figures/sensitivity.py": lambda folder: _pictures(folder, ".csv"),
}

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
    texts = _answered(VIEWS[view](folder))
    assert texts and [text for text in texts if DOUBT not in text] == []


def test_a_new_kind_of_picture_tells_it_without_knowing(folder, monkeypatch, tmp_path):
    table = pd.DataFrame({"value": [1.0]})
    new = Drawing(lambda data: message_figure("new"), lambda data: table, lambda data: ["New."])
    monkeypatch.setattr(render, "drawing_of", lambda name: new)
    spec = render.find_spec("speed-agreement", _study(folder).plots)
    render.render(spec.model_copy(update={"name": "new"}), folder / "dataset.nc", tmp_path)
    for suffix in ("svg", "csv", "caption.txt"):
        assert DOUBT in (tmp_path / f"new.{suffix}").read_text()


INDICES = pd.DataFrame([{"parameter": "friction", "doubt": ""}]).astype({"doubt": object})


def test_a_table_and_a_refusal_take_each_others_place(tmp_path):
    path = tmp_path / "matters.csv"
    for _ in range(2):
        save_refusal(Refusal('no indices, as "0 of 8"\x1b[2J'), path)
        assert refusal_in(path) == 'no indices, as "0 of 8" [2J'
        answers.save_table(INDICES, path)
        assert not refusal_in(path) and storage.load_table(path).equals(INDICES)


def test_a_kill_between_a_table_and_the_note_of_its_checksum_damages_nothing(tmp_path, monkeypatch):
    path = tmp_path / "matters.csv"
    answers.save_table(INDICES, path)
    replace = Path.replace

    def replace_note_alone(self, target):
        if target == path:
            raise KeyboardInterrupt
        return replace(self, target)

    monkeypatch.setattr(Path, "replace", replace_note_alone)
    with pytest.raises(KeyboardInterrupt):
        save_refusal(Refusal("no indices"), path)
    assert storage.load_table(path).equals(INDICES)
    path.write_text(path.read_text().replace("friction", "fraction"))
    with pytest.raises(DamagedError, match="its checksum is wrong"):
        storage.load_table(path)
    assert not refusal_in(path)
