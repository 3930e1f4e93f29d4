"""Answers of a study with made-up runs: indices of a surrogate and of designs, a calibration."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from sim.base.errors import InputError
from sim.dataset.build import build
from sim.figures.render import find_spec, render
from sim.report.predict import predict
from sim.study.load import load_study
from sim.surrogates import answers, calibration, inquiries
from sim.surrogates.posterior import summarize
from sim.surrogates.refusals import Refusal
from sim.surrogates.storage import load
from tests.made.runs import write_run
from tests.made.surrogates import rough_answers

STUDY = """
study: asked
series:
  - &wide
    name: wide
    system: chute
    base: {depth: 5, replicates: 2}
    design:
      kind: sobol
      points: 16
      over: {friction: [0.3, 0.8], restitution: [0.6, 0.95], angle: [14, 18]}
  - <<: *wide
    name: many
    design:
      kind: morris
      points: 40
      over: {friction: [0.3, 0.8], restitution: [0.6, 0.95], angle: [14, 18]}
  - <<: *wide
    name: blocks
    design:
      kind: saltelli
      points: 40
      over: {friction: [0.3, 0.8], restitution: [0.6, 0.95], angle: [14, 18]}
surrogate: [{name: speed, series: wide}]
sensitivity:
  - {name: matters, surrogate: speed}
  - {name: screening, series: many}
  - {name: direct, series: blocks}
calibrate:
  - {name: beads, data: exp.csv, surrogate: speed, parameters: {friction: [0.3, 0.8]}}
"""

#: The friction of the material that was "measured", and the restitution that is known of it.
FRICTION, RESTITUTION = 0.55, 0.8


def velocity(friction, angle):
    """Return the velocity of a made-up flow, which the restitution does not change."""
    return angle / 10 - friction


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    """Return the results of the study, in which a point of the screening has failed."""
    place = tmp_path_factory.mktemp("asked")
    rows = "".join(
        f"{angle}, {RESTITUTION}, {velocity(FRICTION, angle):.4f}, 0.02\n" for angle in (15, 17)
    )
    (place / "exp.csv").write_text(f"angle, restitution, velocity, velocity_error\n{rows}")
    (place / "study.yaml").write_text(STUDY)
    study = load_study(place / "study.yaml", place)
    lost = study.series["many"][5]
    for key, point in study.points.items():
        parameters = point.parameters
        speed = velocity(parameters.friction, parameters.angle) * np.array([0.999, 1.001])
        failed = (0, 1) if key == lost else ()
        write_run(place / "asked" / "runs", parameters, speed, failed=failed)
    build(place / "study.yaml", place)
    with rough_answers():
        lines = answers.build(place / "study.yaml", place)
    assert lines[1].startswith("sensitivity matters: total index of friction 0.6")
    assert lines[-1].startswith("calibration beads: friction = 0.5")
    return place / "asked"


@pytest.mark.parametrize(
    ("old", "new", "name", "message"),
    [
        (
            "points: 16",
            "points: 12",
            "speed",
            "point chute-depth5-.*: not as in .*; run the study again",
        ),
        (
            "surrogate: [{name: speed",
            "surrogate: [{regimes: [mixed], name: speed",
            "speed",
            "surrogate speed",
        ),
        (
            "name: speed",
            "name: pace",
            "pace",
            "surrogate pace: not as in .*asked; run the study again",
        ),
    ],
)
def test_predictions_of_a_study_that_has_changed_are_refused(folder, old, new, name, message):
    place = folder.parent
    changed = place / "changed.yaml"
    changed.write_text(STUDY.replace(old, new).replace("surrogate: speed", f"surrogate: {name}"))

    def ask(file: Path) -> str:
        at = ("friction=0.5", "restitution=0.8", "angle=16")
        return predict(file, at, None, False, "table", place)

    assert "velocity" in ask(place / "study.yaml")
    with pytest.raises(InputError, match=message):
        ask(changed)


def test_a_prediction_asks_for_its_own_surrogate_alone(folder):
    place = folder.parent
    more = place / "more.yaml"
    asked = "surrogate: [{name: speed, series: wide}"
    more.write_text(STUDY.replace(asked, f"{asked}, {{name: pace, series: many}}"))
    at = ("friction=0.5", "restitution=0.8", "angle=16")
    assert "surrogate speed: " in predict(more, at, "speed", False, "table", place)
    with pytest.raises(InputError, match="surrogate pace: not as in"):
        predict(more, at, "pace", False, "table", place)


def table(folder: Path, name: str, index: str) -> pd.DataFrame:
    rows = pd.read_csv(folder / "sensitivity" / f"{name}.csv").set_index(["index", "parameter"])
    return rows.loc[index]


#: Variances of friction and angle, evenly spread.
SHARES = np.array([0.5**2, 0.0, 0.4**2]) / (0.5**2 + 0.4**2)


def test_indices_of_the_surrogate_are_those_of_the_function(folder):
    for index in ("first", "total"):
        found = table(folder, "matters", index)
        assert found["value"].to_numpy() == pytest.approx(SHARES, abs=0.03)
        assert (found["left_out"] == 0).all()


def test_indices_of_the_runs_are_those_of_the_function(folder):
    found = table(folder, "direct", "total")
    assert found["value"].to_numpy() == pytest.approx(SHARES, abs=0.35)
    assert set(found["blocks"]) == {8}


def test_a_screening_leaves_out_the_trajectory_of_a_run_that_failed(folder):
    found = table(folder, "screening", "mu")
    assert found["value"].to_numpy() == pytest.approx([-0.5, 0, 0.4], abs=0.01)
    assert set(found["blocks"]) == {9} and set(found["left_out"]) == {1}


def test_the_calibration_has_the_friction_of_the_material(folder):
    groups = calibration.load(folder / "calibration" / "beads.nc")
    (row,) = summarize(groups).itertuples()
    assert row.low < FRICTION < row.high and row.informed
    assert groups["constant_data"]["restitution"].values.tolist() == [RESTITUTION] * 2


def test_a_calibration_tells_of_its_surrogate_and_asks_for_one_that_is_sure(folder):
    groups = calibration.load(folder / "calibration" / "beads.nc")
    about = groups["observed_data"].attrs
    surrogate = load(folder / "surrogates" / "speed.nc")
    assert about["surrogate_error"] == surrogate.error
    assert about["surrogate_points"] == about["points"] == 16
    assert about["uncounted"] == 0 and about["regimes"] == "steady"
    unsure = replace(surrogate)
    unsure.__dict__["error"] = 0.25
    inquiries.require_small_error(unsure, 0.3, "calibration beads: no posterior")
    with pytest.raises(
        Refusal, match="no posterior, as the error of surrogate speed is above 20 % "
    ):
        inquiries.require_small_error(unsure, None, "calibration beads: no posterior")


def test_every_picture_of_an_answer_is_drawn(folder, tmp_path):
    study = load_study(folder.parent / "study.yaml", folder.parent)
    endings = ("indices", "interactions", "screening", "posterior", "predictions", "experiment")
    names = [name for name in study.plots if name.rpartition("-")[2] in endings]
    assert len(names) == 7
    for name in names:
        spec = find_spec(name, study.plots)
        files = render(spec, folder / "dataset.nc", tmp_path)
        assert all(file.stat().st_size for file in files)
        text = (tmp_path / f"{name}.caption.txt").read_text()
        assert text.startswith(spec.lead)
