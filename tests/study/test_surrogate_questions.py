"""Sensitivities and calibrations of a study: what is asked, and what is refused before it runs."""

import pytest

from sim.base.errors import InputError
from sim.study.load import Study, parse_study
from sim.study.surrogate import COUNTED

WIDE = {
    "name": "wide",
    "system": "chute",
    "base": {"depth": 5},
    "design": {
        "kind": "sobol",
        "points": 16,
        "over": {"friction": [0.2, 0.8], "restitution": [0.6, 0.98], "angle": [14, 20]},
    },
}
SCREENED = WIDE | {"name": "many", "design": WIDE["design"] | {"kind": "morris", "points": 40}}
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


def message(parse, *arguments, **keys) -> str:
    with pytest.raises(InputError) as caught:
        parse(*arguments, **keys)
    assert "\n" not in str(caught.value)
    return str(caught.value)


def test_a_sensitivity_of_a_surrogate_has_its_pictures(parse):
    entry = {"name": "matters", "surrogate": "speed"}
    study = parse(sensitivity=[entry, entry | {"name": "all-the-same", "surrogate_error": 0.3}])
    one, other = study.questions[1:]
    assert (one.surrogate_error, other.surrogate_error) == (None, 0.3)
    assert one.file == "sensitivity/matters.csv" and one.of.name == "speed" and not one.design
    assert {"matters-indices", "matters-interactions"} <= set(study.plots)
    assert study.plots["matters-indices"].answer.file == one.file
    files = [question.file for question in study.questions]
    assert files == ["surrogates/speed.nc", one.file, other.file]


def test_a_sensitivity_of_a_design_takes_its_runs(parse):
    study = parse(sensitivity=[{"name": "screen", "series": "many", "observable": "velocity"}])
    (one,) = study.questions[1:]
    assert one.is_screening and one.of.mean_regimes == COUNTED and one.series == "many"
    assert "screen-screening" in study.plots and "screen-indices" not in study.plots


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


def test_columns_of_parameters_may_say_what_was_run(parse):
    for name, value in {"law": "walton_braun", "orientations": "True", "depth": "5.0"}.items():
        parse(TABLE.replace("note", name).replace('"fast, or so"', value).replace("slow", value))


def test_more_measurements_than_a_posterior_can_take_are_refused(parse):
    table = TABLE.splitlines()[0] + "\n" + "15, 200, 5, slow\n" * 1001
    allowed = "got 1001; allowed: 1,000 or fewer; average those made under equal conditions"
    assert f"exp.csv: measurements: {allowed}" in message(parse, table, calibrate=[CALIBRATE])
