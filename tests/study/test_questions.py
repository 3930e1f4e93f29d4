"""The key ``surrogate`` of a study: what it makes, and what it refuses before any run."""

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


def test_a_surrogate_goes_through_a_grid_and_ignores_how_its_points_are_computed():
    grid = {"friction": [0.3, 0.4, 0.6], "depth": [2, 5], "seed": [1, 2]}
    flows = {"name": "wide", "system": "chute", "grid": grid}
    asked = {"study": "asks", "series": [flows], "surrogate": [{"name": "speed", "series": "wide"}]}
    (speed,) = parse_study(asked, "asks.yaml", None).surrogates
    ranges = {axis.name: (axis.low, axis.high) for axis in speed.axes}
    assert ranges == {"friction": (0.3, 0.6), "depth": (2, 5)}
    assert (speed.observable, speed.system, speed.mean_regimes) == ("velocity", "chute", COUNTED)
    (speed,) = study().surrogates
    assert [axis.name for axis in speed.axes] == ["friction", "stiffness", "law"]
    assert (speed.axes[1].scale, speed.axes[2].choices) == ("log", ("walton_braun", "hertz"))
    kinds = {name: spec.kind for name, spec in study().plots.items()}
    assert kinds == {
        "speed-friction": "section",
        "speed-stiffness": "section",
        "speed-friction-stiffness": "surface",
        "speed-agreement": "agreement",
    }


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


def test_surrogates_of_parts_belong_to_the_study(tmp_path):
    part = "study: part\nseries:\n  - {name: wide, system: chute, grid: {depth: [2, 3, 4, 5, 6]}}\n"
    (tmp_path / "part.yaml").write_text(part + "surrogate: [{name: speed, series: wide}]\n")
    (tmp_path / "whole.yaml").write_text("study: whole\nparts: [part.yaml]\n")
    (speed,) = load_study(tmp_path / "whole.yaml", None).surrogates
    assert speed.name == "speed" and [axis.name for axis in speed.axes] == ["depth"]
