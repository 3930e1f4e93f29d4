"""Surrogates, sensitivities, propagations, calibrations: what is asked before anything runs."""

import re
from pathlib import Path

import pytest

import sim
from sim.base.errors import InputError
from sim.figures import kinds as kinds_module
from sim.report.points import as_json, as_table
from sim.study.feed import LEADS, TITLES
from sim.study.file import QUESTIONS
from sim.study.load import Study, load_study, parse_study
from sim.study.reference import reference_text
from sim.study.surrogate import COUNTED, MOST_ROUNDS

RANGES = {"friction": [0.2, 0.8], "restitution": [0.6, 0.98], "angle": [14, 20]}
WIDE = {
    "name": "wide",
    "system": "chute",
    "base": {"depth": 5},
    "design": {"kind": "sobol", "points": 16, "over": RANGES},
}
SCREENED = WIDE | {"name": "many", "design": WIDE["design"] | {"kind": "morris", "points": 40}}
STIFFNESS = {"between": [100, 10000], "scale": "log"}
MIXED = {"stiffness": STIFFNESS, "law": {"choices": ["walton_braun", "hertz"]}}
SPEED = {"name": "speed", "series": "wide"}
CALIBRATE = {
    "name": "beads",
    "data": "exp.csv",
    "surrogate": "speed",
    "parameters": {"friction": [0.2, 0.8], "restitution": [0.6, 0.9]},
}
TABLE = """angle (deg), velocity (mm/s), velocity_error, note
15, 200, 5, slow
17, 300, 6, "fast, or so"
"""


@pytest.fixture
def parse(tmp_path):
    def parse(table: str = TABLE, **keys) -> Study:
        (tmp_path / "exp.csv").write_text(table)
        mapping = {"study": "s", "series": [WIDE, SCREENED], "surrogate": [SPEED]} | keys
        return parse_study(mapping, tmp_path / "study.yaml", None)

    return parse


def with_design(**changes) -> list[dict]:
    return [WIDE | {"design": WIDE["design"] | changes}]


def test_a_surrogate_goes_through_a_grid_and_ignores_how_its_points_are_computed(parse):
    grid = {"friction": [0.3, 0.4, 0.6], "depth": [2, 5], "seed": [1, 2]}
    (speed,) = parse(series=[{"name": "wide", "system": "chute", "grid": grid}]).surrogates
    ranges = {axis.name: (axis.low, axis.high) for axis in speed.axes}
    assert ranges == {"friction": (0.3, 0.6), "depth": (2, 5)}
    assert (speed.observable, speed.system, speed.mean_regimes) == ("velocity", "chute", COUNTED)
    study = parse(series=with_design(over={"friction": [0.3, 0.6]} | MIXED))
    (speed,) = study.surrogates
    assert [axis.name for axis in speed.axes] == ["friction", "stiffness", "law"]
    assert (speed.axes[1].scale, speed.axes[2].choices) == ("log", ("walton_braun", "hertz"))
    assert {name: spec.kind for name, spec in study.plots.items()} == {
        "speed-friction": "section",
        "speed-stiffness": "section",
        "speed-friction-stiffness": "surface",
        "speed-agreement": "agreement",
    }


def test_rounds_add_the_points_of_a_larger_design_and_their_cost_is_told(parse):
    asked = parse(series=[WIDE], surrogate=[SPEED | {"error": 0.05, "budget": 2}])
    assert asked.rounds == MOST_ROUNDS and parse().rounds == 0
    line = "surrogate speed: rounds of 4 points may add up to 2 core hours, until its error is 5 %"
    assert line in as_table(asked) and "rounds of refinement" not in as_table(asked)
    assert '"surrogates_core_hours": 2' in as_json(asked)
    larger = list(parse(series=with_design(points=24)).points)
    (speed,) = asked.surrogates
    first = speed.next_batch(asked.points)
    assert list(first) == larger[16:20] and speed.added_points(asked.points) == {}
    known = {**asked.points, **first}
    assert list(speed.added_points(known)) == list(first)
    assert list(speed.next_batch(known)) == larger[20:]


def test_surrogates_of_parts_belong_to_the_study(tmp_path):
    part = "study: part\nseries:\n  - {name: wide, system: chute, grid: {depth: [2, 3, 4, 5, 6]}}\n"
    (tmp_path / "part.yaml").write_text(part + "surrogate: [{name: speed, series: wide}]\n")
    (tmp_path / "whole.yaml").write_text("study: whole\nparts: [part.yaml]\n")
    (speed,) = load_study(tmp_path / "whole.yaml", None).surrogates
    assert speed.name == "speed" and [axis.name for axis in speed.axes] == ["depth"]


def test_a_sensitivity_is_of_a_surrogate_or_of_the_runs_of_a_design(parse):
    entry = {"name": "matters", "surrogate": "speed"}
    screen = {"name": "screen", "series": "many", "observable": "velocity"}
    study = parse(sensitivity=[entry, entry | {"name": "others", "surrogate_error": 0.3}, screen])
    one, other, screening = study.questions[1:]
    assert (one.surrogate_error, other.surrogate_error) == (None, 0.3)
    assert one.file == "sensitivity/matters.csv" and one.of.name == "speed" and not one.design
    assert {"matters-indices", "matters-interactions", "screen-screening"} <= set(study.plots)
    assert study.plots["matters-indices"].answer.file == one.file
    assert study.questions[0].file == "surrogates/speed.nc"
    assert screening.is_screening and screening.of.mean_regimes == COUNTED
    assert screening.series == "many" and "screen-indices" not in study.plots


def test_a_propagation_is_spread_as_a_design_or_as_it_says(parse):
    by_runs = {"name": "runs", "series": "wide", "exceeds": [0.5]}
    model = {"name": "model", "surrogate": "speed"}
    narrow = {"mean": 16, "deviation": 1, "between": [14, 18]}
    other = model | {"name": "other", "over": {"angle": narrow, "friction": [0.3, 0.4]}}
    runs, same, changed = parse(propagate=[by_runs, model, other]).questions[1:]
    assert runs.file == "propagation/runs.csv" and runs.design.size == 16
    assert runs.quantiles == [0.05, 0.25, 0.5, 0.75, 0.95] and same.axes == same.of.axes
    friction, _, angle = changed.axes
    assert (friction.low, friction.high, angle.normal) == (0.3, 0.4, (16, 1))
    assert len({repr(one.settings) for one in (runs, same, changed)}) == 3
    conditions = with_design(where=["friction < restitution"])
    assert parse(series=conditions, propagate=[model]).questions[1].where == (
        "friction < restitution",
    )
    assert parse(propagate=[model]).plots["model-spread"].kind == "spread"


def test_a_question_stands_in_every_place():
    """The places that a new question touches: docs/architecture.md names them."""
    assert list(QUESTIONS) == ["surrogate", "sensitivity", "propagate", "calibrate"]
    root = Path(sim.__file__).parent
    for kind in QUESTIONS.values():
        for place in ("study/feed.py", "surrogates/inquiries.py"):
            cases = re.findall(r"case (.*):", (root / place).read_text())
            assert any(f"{kind.__name__}()" in case for case in cases), (kind, place)
        assert f"### Keys of a {kind.noun()}\n" in reference_text()
    pictures = [name for names in kinds_module._ANSWERS.values() for name in names]
    assert set(pictures) == set(TITLES) == set(LEADS)


def test_measurements_come_in_the_units_of_talus(parse, tmp_path):
    study = parse(calibrate=[CALIBRATE])
    (one,) = study.questions[1:]
    assert one.values == pytest.approx((0.2, 0.3)) and one.errors == pytest.approx((0.005, 0.006))
    assert one.conditions == {"angle": (15, 17)} and one.ranges["restitution"] == (0.6, 0.9)
    assert study.data == (tmp_path / "exp.csv",)
    assert {"beads-posterior", "beads-predictions", "beads-experiment"} <= set(study.plots)
    table = "angle,V,s\n15,20,1\n17,30,2\n"
    named = {"observable": "V", "error": "s", "units": {"V": "cm/s", "angle": "deg"}}
    (_, other) = parse(table, calibrate=[CALIBRATE | named]).questions
    assert other.values == pytest.approx(one.values)
    assert other.errors == pytest.approx((0.01, 0.02))
    for edited, keys in (
        (TABLE.replace("300", "310"), {}),
        (TABLE, {"discrepancy": False}),
        (TABLE, {"surrogate_error": 0.5}),
    ):
        (_, other) = parse(edited, calibrate=[CALIBRATE | keys]).questions
        assert other.settings != one.settings


def test_columns_may_say_what_was_run_and_rows_are_no_more_than_a_posterior_can_take(parse):
    for name, value in {"law": "walton_braun", "orientations": "True", "depth": "5.0"}.items():
        parse(TABLE.replace("note", name).replace('"fast, or so"', value).replace("slow", value))
    table = TABLE.splitlines()[0] + "\n" + "15, 200, 5, slow\n" * 1001
    allowed = "got 1001; allowed: 1,000 or fewer; average those made under equal conditions"
    with pytest.raises(InputError, match=f"exp.csv: measurements: {allowed}"):
        parse(table, calibrate=[CALIBRATE])
