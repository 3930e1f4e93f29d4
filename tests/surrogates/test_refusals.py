"""Questions that the runs cannot answer: what files, pictures and commands say of them."""

from collections.abc import Sequence
from itertools import cycle
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from sim.base.errors import InputError
from sim.base.seals import DamagedError
from sim.dataset.build import build
from sim.dataset.rounds import read_round
from sim.figures.render import draw_figures
from sim.report.predict import predict
from sim.report.results import load
from sim.report.status import as_text, survey
from sim.study.load import load_study
from sim.surrogates import answers, inquiries
from sim.surrogates.answers import Refusal, refusal_in, save_refusal
from sim.surrogates.rounds import write_round
from tests.made.runs import write_run

STUDY = """\
study: made
series:
  - name: wide
    system: chute
    base: {replicates: 2}
    design:
      kind: sobol
      points: POINTS
      over: {friction: [0.3, 0.6], angle: [14, 18]}
  - name: blocks
    system: chute
    base: {replicates: 2}
    design:
      kind: saltelli
      points: 32
      over: {friction: [0.3, 0.6], angle: [14, 18]}
plots:
  - {name: seen, kind: scatter, series: [wide], x: friction}
surrogate:
  - {name: speed, series: wide, error: 0.1, budget: 1.0e+5, batch: 3}
  - {name: any-regime, series: wide, regimes: [accelerating, arrested]}
sensitivity:
  - {name: matters, surrogate: speed}
  - {name: direct, series: blocks}
calibrate:
  - {name: beads, data: exp.csv, surrogate: speed, parameters: {friction: [0.3, 0.6]}}
"""

#: What is said of the surrogate without a mean, and of what is asked of it.
NO_MEAN = (
    "surrogate speed: no mean, as 0 of 8 points of series wide count "
    "(steady or mixed or undetermined)"
)


def make(folder: Path, points: int, regimes: Sequence[str], study: str = STUDY) -> Path:
    """Write a study and its runs, of some regimes in turn; return the study file."""
    (folder / "exp.csv").write_text("angle, velocity, velocity_error\n15, 0.5, 0.02\n")
    path = folder / "made.yaml"
    path.write_text(study.replace("POINTS", str(points)))
    run(folder, [one.parameters for one in load_study(path, folder).points.values()], regimes)
    return path


def run(folder: Path, points, regimes: Sequence[str]) -> None:
    for one, regime in zip(points, cycle(regimes), strict=False):
        speed = 0.0 if regime == "arrested" else one.angle / 10 - one.friction
        write_run(folder / "made" / "runs", one, speed * np.array([0.99, 1.01]), regime=regime)


@pytest.fixture(scope="module")
def asked(tmp_path_factory):
    """Return study file and lines of a study in which every flow stops or runs away."""
    folder = tmp_path_factory.mktemp("asked")
    path = make(folder, 8, ("arrested", "accelerating"))
    build(path, folder)
    lines = inquiries.build(path, folder)
    study = load_study(path, folder)
    draw_figures(
        list(study.entries),
        folder / "made" / "dataset.nc",
        folder / "made" / "figures",
        study_path=path,
    )
    return path, lines


def test_each_question_says_in_its_words_why_it_has_no_answer(asked):
    path, lines = asked
    assert lines[0].startswith(f"{NO_MEAN} and 6 are needed; left out are 4 accel")
    assert lines[1].startswith("surrogate any-regime: 8 points, error ")
    assert lines[2].startswith(f"sensitivity matters: no indices without its surrogate; {NO_MEAN}")
    assert lines[3].startswith("sensitivity direct: no indices, as 0 of 8 blocks of 4 points have")
    assert lines[4].startswith(f"calibration beads: no posterior without its surrogate; {NO_MEAN}")
    assert all("\n" not in line for line in lines)
    study = load_study(path, path.parent)
    assert as_text(survey(study, path.parent)).endswith("\n".join(lines))
    with xr.open_dataset(path.parent / "made" / "calibration" / "beads.nc") as file:
        assert file.attrs["refusal"] == lines[4]


ODD = """\
study: made
series:
  - name: wide
    system: chute
    base: {replicates: 2}
    design: {kind: sobol, points: 8, over: {friction: [0.3, 0.6], angle: [14, 18]}}
surrogate:
  - {name: speed, series: wide, error: 0.1, budget: 1}
  - {name: force, series: wide, observable: base_normal}
"""


@pytest.mark.parametrize("size", [1e140, 1e-140])
def test_values_of_an_odd_size_are_refused_by_name_and_take_no_other_answer(tmp_path, size):
    path = tmp_path / "made.yaml"
    path.write_text(ODD)
    for one in load_study(path, tmp_path).points.values():
        speeds = size * (1 + one.parameters.friction) * np.array([0.99, 1.01])
        write_run(tmp_path / "made" / "runs", one.parameters, speeds)
    build(path, tmp_path)
    lines = inquiries.build(path, tmp_path)
    assert lines[0].startswith("surrogate speed: no mean, as velocity is ")
    assert lines[1].startswith("surrogate force: 8 points, error ")
    assert not read_round(write_round(path, 1, tmp_path))


def test_pictures_without_an_answer_say_so_and_all_others_stand(asked):
    path, lines = asked
    figures = path.parent / "made" / "figures"
    study = load_study(path, path.parent)
    assert len(study.plots) == 14
    refusals = {spec.file: line for spec, line in zip(study.questions, lines, strict=True)}
    for name, spec in study.plots.items():
        caption = (figures / f"{name}.caption.txt").read_text()
        is_refused = name != "seen" and "any-regime" not in spec.answer.file
        assert is_refused == ("Nothing is drawn: " in caption)
        table = (figures / f"{name}.csv").read_text()
        assert is_refused == table.startswith("refusal\n")
        if is_refused:
            line = refusals[spec.answer.file]
            assert line in caption and line in table.replace('"', "")
            drawn = (figures / f"{name}.svg").read_text()
            assert all(word in drawn for word in line.split()[:3])
        assert (figures / f"{name}.png").stat().st_size


def test_predictions_are_refused_with_one_line(asked):
    path, _ = asked
    at = ["friction=0.4", "angle=15"], "table", path.parent

    def ask(name):
        return predict(path, at[0], name, False, *at[1:])

    with pytest.raises(InputError, match=NO_MEAN.partition(",")[0]):
        ask("speed")
    with pytest.raises(InputError, match=NO_MEAN.partition(",")[0]):
        load(path.parent / "made").surrogate("speed")
    # Both are of the velocity, so a name must tell which is meant.
    with pytest.raises(InputError, match="allowed: one of any-regime, speed"):
        ask("velocity")
    assert "any-regime" in ask("any-regime")


def test_rounds_buy_what_a_mean_lacks(tmp_path):
    text = STUDY.partition("sensitivity:")[0]
    text = "\n".join(line for line in text.splitlines() if "any-regime" not in line)
    path = make(tmp_path, 2, ("steady",), text)
    lines = _answer(path)
    assert lines[0].startswith("surrogate speed: no mean, as 2 of 2 points of series wide count")
    numbers = []
    while added := read_round(write_round(path, len(numbers) + 1, tmp_path)):
        numbers.append(len(added))
        run(tmp_path, added.values(), ("steady",))
    assert numbers[0] == 3
    assert _answer(path)[0].startswith(f"surrogate speed: {2 + sum(numbers)} points, error ")
    with pytest.raises(InputError, match="allowed: a series of 6 to 3,000 points"):
        path.write_text(path.read_text().replace("error: 0.1, budget: 1.0e+5, ", ""))
        load_study(path, tmp_path)


def _answer(path: Path) -> list[str]:
    build(path, path.parent)
    return inquiries.build(path, path.parent)


def test_a_table_and_a_refusal_take_each_others_place(tmp_path):
    path, indices = (
        tmp_path / "matters.csv",
        pd.DataFrame([{"parameter": "friction", "doubt": ""}]).astype({"doubt": object}),
    )
    for _ in range(2):
        save_refusal(Refusal('no indices, as "0 of 8"\x1b[2J'), path)
        assert refusal_in(path) == 'no indices, as "0 of 8" [2J'
        answers.save_table(indices, path)
        assert not refusal_in(path) and answers.load_table(path).equals(indices)


def test_a_kill_between_a_table_and_the_note_of_its_checksum_damages_nothing(tmp_path, monkeypatch):
    path, indices = (
        tmp_path / "matters.csv",
        pd.DataFrame([{"parameter": "friction", "doubt": ""}]).astype({"doubt": object}),
    )
    answers.save_table(indices, path)
    replace = Path.replace

    def replace_note_alone(self, target):
        if target == path:
            raise KeyboardInterrupt
        return replace(self, target)

    monkeypatch.setattr(Path, "replace", replace_note_alone)
    with pytest.raises(KeyboardInterrupt):
        save_refusal(Refusal("no indices"), path)
    assert answers.load_table(path).equals(indices)
    path.write_text(path.read_text().replace("friction", "fraction"))
    with pytest.raises(DamagedError, match="its checksum is wrong"):
        answers.load_table(path)
    assert not refusal_in(path)
