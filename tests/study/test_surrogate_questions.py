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
SCREENED = WIDE | {
    "name": "many",
    "design": WIDE["design"] | {"kind": "morris", "points": 40},
}
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
    one, other = study.sensitivities
    assert (one.surrogate_error, other.surrogate_error) == (None, 0.3)
    assert one.file == "sensitivity/matters.csv" and one.of.name == "speed" and not one.design
    assert {"matters-indices", "matters-interactions"} <= set(study.plots)
    assert study.plots["matters-indices"].options["answer"] == one.file
    files = [question.file for question in study.questions]
    assert files == ["surrogates/speed.nc", one.file, other.file]


def test_a_sensitivity_of_a_design_takes_its_runs(parse):
    study = parse(sensitivity=[{"name": "screen", "series": "many", "observable": "velocity"}])
    (one,) = study.sensitivities
    assert one.is_screening and one.of.mean_regimes == COUNTED and one.series == "many"
    assert "screen-screening" in study.plots and "screen-indices" not in study.plots


@pytest.mark.parametrize(
    ("entry", "text"),
    [
        ({"surrogate": "sped"}, "surrogate: got 'sped'; did you mean speed? allowed: one of speed"),
        ({}, "surrogate: got nothing; allowed: the name of a surrogate, or series: a series"),
        ({"surrogate": "speed", "series": "many"}, "series: got 'many'; allowed: none with surr"),
        ({"series": "wide"}, "series: got 'wide'; allowed: a series whose design is of kind salt"),
        ({"series": "many", "observable": "sped"}, "observable: got 'sped'; allowed: "),
        ({"surrogate": "speed", "nme": 1}, "nme: unknown key"),
        (
            {"series": "many", "surrogate_error": 0.3},
            "surrogate_error: got 0.3; allowed: none with series",
        ),
    ],
)
def test_mistakes_in_a_sensitivity_are_refused_by_their_key(parse, entry, text):
    assert f"study.yaml: sensitivity[0].{text}" in message(
        parse, sensitivity=[{"name": "m"} | entry]
    )


def test_a_design_of_few_blocks_is_refused(parse):
    few = SCREENED | {"design": SCREENED["design"] | {"points": 8}}
    found = message(parse, series=[WIDE, few], sensitivity=[{"name": "m", "series": "many"}])
    assert "series: got 'many of 8 points'; allowed: a design of 32 points or more" in found


def test_names_are_unique(parse):
    twice = [{"name": "m", "surrogate": "speed"}, {"name": "M", "series": "many"}]
    assert "sensitivity[1].name: got 'M'; allowed: a name that no other sensitivity has" in message(
        parse, sensitivity=twice
    )


def test_measurements_come_in_the_units_of_talus(parse, tmp_path):
    study = parse(calibrate=[CALIBRATE])
    (one,) = study.calibrations
    assert one.values == pytest.approx((0.2, 0.3)) and one.errors == pytest.approx((0.005, 0.006))
    assert one.conditions == {"angle": (15, 17)} and one.ranges["restitution"] == (0.6, 0.9)
    assert study.data == (tmp_path / "exp.csv",)
    assert {"beads-posterior", "beads-predictions", "beads-experiment"} <= set(study.plots)
    edited = parse(TABLE.replace("300", "310"), calibrate=[CALIBRATE]).calibrations[0]
    assert edited.settings != one.settings


def test_what_the_model_and_the_surrogate_may_lack_can_be_chosen(parse):
    (usual,) = parse(calibrate=[CALIBRATE]).calibrations
    assert usual.discrepancy and usual.surrogate_error is None
    entry = CALIBRATE | {"discrepancy": False, "surrogate_error": 0.5}
    (one,) = parse(calibrate=[entry]).calibrations
    assert not one.discrepancy and one.surrogate_error == 0.5
    assert usual.settings != one.settings


def test_columns_and_units_can_be_named_in_the_study(parse):
    table = "angle,V,s\n15,20,1\n17,30,2\n"
    entry = CALIBRATE | {"observable": "V", "error": "s", "units": {"V": "cm/s", "angle": "deg"}}
    (one,) = parse(table, calibrate=[entry]).calibrations
    assert one.values == pytest.approx((0.2, 0.3)) and one.errors == pytest.approx((0.01, 0.02))


@pytest.mark.parametrize(
    ("change", "text"),
    [
        ({"data": "no.csv"}, "no.csv: no such file"),
        ({"data": "/tmp/exp.csv"}, "calibrate[0].data: got '/tmp/exp.csv'; allowed: the name of a"),
        ({"surrogate": "fast"}, "calibrate[0].surrogate: got 'fast'; allowed: one of speed"),
        ({"parameters": {}}, "calibrate[0].parameters: got {}; allowed: a mapping of parameters"),
        (
            {"parameters": {"friction": [0.8, 0.2]}},
            "parameters.friction: got [0.8, 0.2]; allowed: two",
        ),
        ({"parameters": {"friction": 0.3}}, "calibrate[0].parameters.friction: got 0.3; allowed: "),
        (
            {"surrogate_error": 0},
            "calibrate[0].surrogate_error: got 0; allowed: a number in (0, 10]",
        ),
        ({"discrepancy": 3}, "calibrate[0].discrepancy: got 3; allowed: true or false"),
        (
            {"parameters": {"frction": [0.2, 0.8]}},
            "parameters.frction: got [0.2, 0.8]; did you mean friction?",
        ),
        (
            {"parameters": {"friction": [0.1, 0.8], "restitution": [0.6, 0.9]}},
            "parameters.friction: got [0.1, 0.8]; allowed: a range within [0.2, 0.8], that of surr",
        ),
        (
            {"parameters": {"friction": [0.2, 0.8]}},
            "exp.csv: column restitution: got nothing; allowed: a column restitution, as surrogate",
        ),
        (
            {"parameters": CALIBRATE["parameters"] | {"angle": [14, 20]}},
            "parameters.angle: got [14, 20]; allowed: parameters that exp.csv has no column of",
        ),
        (
            {"error": "sigma"},
            "exp.csv: column sigma: got nothing; allowed: a column sigma, the sta",
        ),
        (
            {"units": {"V": "m/s"}},
            "exp.csv: column V: got nothing; did you mean velocity? ",
        ),
        ({"units": {"velocity": "m/s"}}, "exp.csv: unit of column velocity: got 'm/s'; allowed: "),
    ],
)
def test_mistakes_in_a_calibration_are_refused_before_anything_runs(parse, change, text):
    assert text in message(parse, calibrate=[CALIBRATE | change])


@pytest.mark.parametrize(
    ("old", "new", "text"),
    [
        ("15,", "25,", "line 2, column angle: got '25'; allowed: a number in [14, 20] degree, the"),
        ("300, 6", "300, 0", "line 3, column velocity_error: got '0'; allowed: an error > 0"),
        ("300, 6", "300, -1", "line 3, column velocity_error: got '-1'; allowed: an error > 0"),
        ("300, 6", "300,", "line 3, column velocity_error: got nothing; allowed: an error > 0"),
        ("200", "quick", "line 2, column velocity: got 'quick'; allowed: a number"),
        ("mm/s", "mph", "unit of column velocity: got 'mph'; allowed: a unit such as m s-1"),
        ("note", "depth", "line 2, column depth: got 'slow'; allowed: 5, as all points of wide"),
        ("velocity_error", "error", "column velocity_error: got nothing; did you mean"),
    ],
)
def test_measurements_that_cannot_be_used_are_one_line(parse, old, new, text):
    assert f"exp.csv: {text}" in message(parse, TABLE.replace(old, new), calibrate=[CALIBRATE])


@pytest.mark.parametrize(
    ("name", "other", "own", "allowed"),
    [
        ("law", "hertz", "walton_braun", "walton_braun"),
        ("friction_cap", "after", "before", "before"),
        ("system", "belt", "chute", "chute"),
        ("start_from", "run.nc", "", "nothing"),
        ("orientations", "false", "True", "true"),
        ("orientations", "5", "true", "true"),
        ("depth", "5.1", "5", "5"),
        ("depth", "deep", "5.0", "5"),
        ("overlap_memory", "", "separation", "separation"),
    ],
)
def test_columns_of_parameters_say_what_was_run(parse, name, other, own, allowed):
    """Words, switches and numbers alike: measurements of other flows are not those of the runs."""
    table = TABLE.replace("note", name).replace('"fast, or so"', own)
    parse(table.replace("slow", own), calibrate=[CALIBRATE])
    found = message(parse, table.replace("slow", other), calibrate=[CALIBRATE])
    got = repr(other) if other else "nothing"
    assert f"line 2, column {name}: got {got}; allowed: {allowed}, as all points of wide" in found


@pytest.mark.parametrize(
    "change",
    [{"error": "velocity"}, {"error": "angle"}, {"observable": "angle", "error": "velocity_error"}],
)
def test_a_measurement_and_its_error_have_columns_of_their_own(parse, change):
    key = next(iter(change))
    found = message(parse, calibrate=[CALIBRATE | change])
    assert f"calibrate[0].{key}: got {change[key]!r}; allowed: a column of its own" in found


def test_more_measurements_than_a_posterior_can_take_are_refused(parse):
    table = TABLE.splitlines()[0] + "\n" + "15, 200, 5, slow\n" * 1001
    allowed = "got 1001; allowed: 1,000 or fewer; average those made under equal conditions"
    assert f"exp.csv: measurements: {allowed}" in message(parse, table, calibrate=[CALIBRATE])


def test_a_surrogate_over_words_is_refused(parse):
    words = WIDE["design"]["over"] | {"law": {"choices": ["walton_braun", "hertz"]}}
    wide = WIDE | {"design": WIDE["design"] | {"over": words}}
    asked = {"calibrate": [CALIBRATE], "sensitivity": [{"name": "m", "surrogate": "speed"}]}
    for key, entries in asked.items():
        found = message(parse, series=[wide, SCREENED], **{key: entries})
        assert f"{key}[0].surrogate: got 'speed, which varies law'; allowed: a surrogate" in found
