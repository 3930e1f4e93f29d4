"""The key ``surrogate`` of a study: what it makes, and what it refuses before any run."""

import pytest

from sim.base.errors import InputError
from sim.report.points import as_json, as_table
from sim.study.load import load_study, parse_study
from sim.study.surrogate import COUNTED, MOST_ROUNDS

DESIGN = {
    "kind": "sobol",
    "points": 16,
    "over": {
        "friction": [0.3, 0.6],
        "stiffness": {"between": [100, 10000], "scale": "log"},
        "law": {"choices": ["walton_braun", "hertz"]},
    },
}


def study(surrogate=(), series=None, **others):
    wide = {"name": "wide", "system": "chute", "design": DESIGN} | (series or {})
    entries = [{"name": "speed", "series": "wide"} | one for one in surrogate or [{}]]
    return parse_study(
        {"study": "asks", "series": [wide], "surrogate": entries} | others, "asks.yaml", None
    )


def test_a_surrogate_has_the_ranges_and_scales_of_its_design():
    (speed,) = study().surrogates
    assert [axis.name for axis in speed.axes] == ["friction", "stiffness", "law"]
    assert [axis.scale for axis in speed.axes] == ["linear", "log", "linear"]
    assert (speed.axes[1].low, speed.axes[1].high) == (100, 10000)
    assert speed.axes[2].choices == ("walton_braun", "hertz") and not speed.has_rounds
    assert (speed.observable, speed.system) == ("velocity", "chute")
    assert speed.mean_regimes == COUNTED == ("steady", "mixed", "undetermined")


def test_a_surrogate_goes_through_a_grid_and_ignores_how_its_points_are_computed():
    grid = {"friction": [0.3, 0.4, 0.6], "depth": [2, 5], "seed": [1, 2]}
    flows = {"name": "wide", "system": "chute", "grid": grid}
    asked = {"study": "asks", "series": [flows], "surrogate": [{"name": "speed", "series": "wide"}]}
    (speed,) = parse_study(asked, "asks.yaml", None).surrogates
    ranges = {axis.name: (axis.low, axis.high) for axis in speed.axes}
    assert ranges == {"friction": (0.3, 0.6), "depth": (2, 5)}


def test_every_surrogate_has_its_pictures():
    asked = study()
    kinds = {name: spec.kind for name, spec in asked.plots.items()}
    assert kinds == {
        "speed-friction": "section",
        "speed-stiffness": "section",
        "speed-friction-stiffness": "surface",
        "speed-agreement": "agreement",
    }
    assert all(len(asked.figures[name]) == 16 for name in kinds)


def test_rounds_are_open_and_their_cost_is_told():
    asked = study([{"error": 0.05, "budget": 2}])
    assert asked.rounds == MOST_ROUNDS and study().rounds == 0
    line = "surrogate speed: rounds of 4 points may add up to 2 core hours, until its error is 5 %"
    assert line in as_table(asked) and "rounds of refinement" not in as_table(asked)
    assert '"surrogates_core_hours": 2' in as_json(asked)


def test_further_points_are_those_of_a_larger_design():
    asked = study([{"error": 0.05, "budget": 2}])
    larger = study(series={"design": DESIGN | {"points": 24}})
    (speed,) = asked.surrogates
    first = speed.next_batch(asked.points)
    assert list(first) == list(larger.points)[16:20]
    assert speed.added_points(asked.points) == {}
    known = {**asked.points, **first}
    assert list(speed.added_points(known)) == list(first)
    assert list(speed.next_batch(known)) == list(larger.points)[20:]


@pytest.mark.parametrize(
    ("surrogate", "message"),
    [
        ([{"series": "wild"}], "surrogate[0].series: got 'wild'; allowed: one of wide"),
        (
            [{"observable": "velocty"}],
            "surrogate[0].observable: got 'velocty'; did you mean",
        ),
        ([{}, {}], "surrogate[1].name: got 'speed'; allowed: a name that no other surrogate has"),
        (
            [{"error": 0.1}],
            "surrogate[0].budget: got nothing; allowed: a number, as error is given",
        ),
        ([{"budget": 1}], "surrogate[0].error: got nothing; allowed: a number, as budget is given"),
        ([{"error": 0}], "surrogate[0].error: got 0"),
        ([{"regimes": ["fast"]}], "surrogate[0].regimes[0]: got 'fast'"),
        ([{"batch": 0}], "surrogate[0].batch: got 0"),
    ],
)
def test_what_is_wrong_is_refused(surrogate, message):
    with pytest.raises(InputError) as error:
        study(surrogate)
    assert f"asks.yaml: {message}" in str(error.value)


@pytest.mark.parametrize(
    ("series", "surrogate", "message"),
    [
        ({"design": DESIGN | {"points": 3}}, {}, "wide of 3 points'; allowed: a series of 9 to"),
        (
            {"design": DESIGN | {"kind": "latin_hypercube"}},
            {"error": 0.1, "budget": 1},
            "got 'wide'; allowed: with error, a series with a design of kind sobol or random",
        ),
    ],
)
def test_series_that_cannot_be_asked_are_refused(series, surrogate, message):
    with pytest.raises(InputError) as error:
        study([surrogate], series)
    assert message in str(error.value)


def test_a_surrogate_does_not_take_the_name_of_a_plot():
    plots = [{"name": "speed-agreement", "x": "friction", "series": ["wide"]}]
    with pytest.raises(InputError, match="no other figure is called speed-agreement"):
        study(plots=plots)


def test_surrogates_of_parts_belong_to_the_study(tmp_path):
    part = "study: part\nseries:\n  - {name: wide, system: chute, grid: {depth: [2, 3, 4, 5, 6]}}\n"
    (tmp_path / "part.yaml").write_text(part + "surrogate: [{name: speed, series: wide}]\n")
    (tmp_path / "whole.yaml").write_text("study: whole\nparts: [part.yaml]\n")
    (speed,) = load_study(tmp_path / "whole.yaml", None).surrogates
    assert speed.name == "speed" and [axis.name for axis in speed.axes] == ["depth"]
