"""Studies: from series to points, sharing, overrides, figures, estimates."""

import copy
import json
from pathlib import Path
from types import SimpleNamespace

import pytest

from sim.base.errors import InputError, duration
from sim.parameters import BeltParameters, ChuteParameters, parse_point, point_id
from sim.report.points import as_json, as_table, warnings
from sim.study.entries import expand_range
from sim.study.figure_spec import FIGURES
from sim.study.file import MAX_POINTS
from sim.study.load import ExtraAmounts, Study, load_study, parse_study, with_extra_amounts
from sim.study.model import estimate

EXAMPLE = {
    "study": "example",
    "title": "An example",
    "defaults": {"chute": {"transient": 100, "friction": 0.4}},
    "series": [
        {
            "name": "depth-restitution",
            "system": "chute",
            "base": {"average": 50},
            "grid": {"depth": [2.5, 5, 20], "restitution": [0.7, 0.85]},
            "cases": [{"depth": 5, "friction": 0.35}],
            "overrides": [{"when": {"depth": [20, 40]}, "set": {"cell": 4, "transient": 200}}],
            "figures": ["walton_2"],
        },
        {
            "name": "shared",
            "system": "chute",
            "base": {"average": 50, "restitution": 0.85},
            "cases": [{"depth": 5}],
        },
    ],
}


@pytest.fixture
def example() -> dict:
    return copy.deepcopy(EXAMPLE)


@pytest.fixture
def parse(tmp_path):
    def parse(mapping: dict) -> Study:
        return parse_study(mapping, "study.yaml", tmp_path / "results")

    return parse


def chute_study(**series) -> dict:
    return {"study": "s", "series": [{"name": "a", "system": "chute"} | series]}


def test_grid_and_cases_add_up(example, parse):
    study = parse(example)
    assert (study.name, study.title, study.path) == ("example", "An example", Path("study.yaml"))
    points = [point.parameters for point in study.points.values()]
    assert [(p.depth, p.restitution, p.friction) for p in points] == [
        (2.5, 0.7, 0.4),
        (2.5, 0.85, 0.4),
        (5, 0.7, 0.4),
        (5, 0.85, 0.4),
        (20, 0.7, 0.4),
        (20, 0.85, 0.4),
        (5, 0.85, 0.35),
    ]
    assert {p.average for p in points} == {50}
    assert {(p.depth, p.cell, p.transient) for p in points} == {
        *((depth, 10, 100) for depth in (2.5, 5)),
        (20, 4, 200),
    }
    assert list(study.points) == [point.id for point in study.points.values()]
    assert list(study.points) == [point_id(point) for point in points]
    assert (study.boundaries, study.rounds) == ((), 0)
    table, document = as_table(study).splitlines(), json.loads(as_json(study))
    assert [line.split()[0] for line in table[:8]] == ["id", *study.points]
    assert "on 2 cores" in next(line for line in table if line.startswith("7 points, "))
    assert document["totals"]["points"] == len(document["points"]) == 7
    assert document["totals"]["steps"] == sum(one["steps"] for one in document["points"])
    for one in document["points"]:
        assert point_id(parse_point(one["parameters"], "json")) == one["id"]


def test_a_point_of_two_series_runs_once(example, parse):
    study = parse(example)
    (shared,) = study.series["shared"]
    # It runs the larger amounts.
    example["series"][1]["base"] |= {"replicates": 5, "average": 40, "target": 0.01}
    one = parse(example).points[shared].parameters
    assert (one.replicates, one.average, one.target) == (5, 50, 0.01)
    assert shared in study.series["depth-restitution"]
    assert study.points[shared].series == ("depth-restitution", "shared")
    assert study.points[shared].figures == ("walton_2",)
    assert len(study.points) == 7


def test_later_places_win(parse):
    mapping = chute_study(
        base={"friction": 0.2, "angle": 20},
        cases=[{}, {"angle": 21}, {"angle": 22}],
        overrides=[
            {"when": {"angle": [22]}, "set": {"angle": 23, "seed": 2}},
            {"when": {"angle": [22]}, "set": {"seed": 3}},
            {"when": {"angle": [23]}, "set": {"seed": 4}},
            # They see omitted parameters.
            {"when": {"stiffness": [100], "angle": [21]}, "set": {"replicates": 2}},
        ],
    )
    mapping["defaults"] = {"chute": {"friction": 0.1, "gravity": 5}}
    points = [point.parameters for point in parse(mapping).points.values()]
    assert [(p.gravity, p.friction, p.angle, p.seed, p.replicates) for p in points] == [
        (5, 0.2, 20, 1, 1),
        (5, 0.2, 21, 1, 2),
        (5, 0.2, 23, 3, 1),
    ]


def test_the_list_of_figures_must_match_what_is_fed(example, parse):
    example["figures"] = ["walton_2"]
    study = parse(example)
    assert study.figures == {"walton_2": tuple(study.points)}
    example["figures"] = ["walton_2", "gallas_1a"]
    with pytest.raises(InputError, match=r"figures\[1\]: got 'gallas_1a'"):
        parse(example)
    example["figures"] = []
    with pytest.raises(InputError, match=r"series\[0\].figures\[0\]: got 'walton_2'"):
        parse(example)


def example_values(spec, axis: str) -> list:
    """Return two values of an axis for which a figure shows points."""
    if axis in spec.where:
        return list(spec.where[axis][:2])
    default = getattr(parse_point({"system": spec.system}, "p"), axis)
    if axis == "protocol":
        return [default, "converged"]
    return [default, 0.9 * default if default else 1]


@pytest.mark.parametrize("name", FIGURES)
def test_a_figure_needs_every_axis_and_points_that_it_shows(name, parse):
    spec = FIGURES[name]
    values = {axis: example_values(spec, axis) for axis in spec.axes}
    base = {key: value for key, value in spec.where.items() if key not in spec.axes}
    base = {key: value[0] if isinstance(value, tuple) else value for key, value in base.items()}
    first = {axis: value for axis, (value, _) in values.items()}
    for missing in spec.axes:
        others = [{axis: second} for axis, (_, second) in values.items() if axis != missing]
        cases = [first | other for other in ({}, *others)]
        series = {"name": "a", "system": spec.system, "base": base, "cases": cases}
        series["figures"] = [name]
        with pytest.raises(InputError, match=rf"{name} with {missing} = .* alone"):
            parse({"study": "s", "series": [series]})
        cases.append(first | {missing: values[missing][1]})
        assert list(parse({"study": "s", "series": [series]}).figures) == [name]
    for key, value in list(spec.where.items())[:1]:
        other = 3 + max(value if isinstance(value, tuple) else (value,))
        series = {"name": "a", "system": spec.system, "base": {key: other}, "figures": [name]}
        message = f"got '{name}'; allowed: series with a point at {key} "
        with pytest.raises(InputError, match=message):
            parse({"study": "s", "series": [series]})


BOUNDARY = {
    "name": "limit",
    "system": "chute",
    "of": "flow",
    "along": "friction",
    "range": [0.2, 1],
    "tolerance": 0.05,
    "grid": {"depth": [5, 10]},
    "figures": ["regimes_friction"],
}


def test_a_boundary_alone_is_a_study_of_its_first_round(parse):
    overrides = [{"when": {"depth": [10], "friction": [1]}, "set": {"seed": 2}}]
    study = parse({"study": "s", "boundaries": [BOUNDARY | {"overrides": overrides}]})
    points = [point.parameters for point in study.points.values()]
    assert [(p.depth, p.friction, p.friction_plane, p.seed) for p in points] == [
        (depth, friction, friction, 2 if (depth, friction) == (10, 1) else 1)
        for depth in (5, 10)
        for friction in (0.2, 0.4, 0.6, 0.8, 1)
    ]
    assert [boundary.grid for boundary in study.boundaries] == [{"depth": 5}, {"depth": 10}]
    assert study.series["limit"] == study.figures["regimes_friction"] == tuple(study.points)
    assert study.rounds == 1
    assert "2 boundaries: about 6 further points" in as_table(study)


def test_a_huge_grid_is_refused_before_it_is_made(parse):
    seeds = list(range(1001))
    grid = {"seed": seeds, "depth": [1 + 0.001 * i for i in range(1000)], "friction": [0.1] * 1000}
    with pytest.raises(InputError, match=rf"series\[0\].grid: .* at most {MAX_POINTS:,} points"):
        parse(chute_study(grid=grid))


@pytest.mark.parametrize(
    ("written", "values"),
    [
        ({"start": 0.3, "stop": 0.65, "step": 0.1}, [0.3, 0.4, 0.5, 0.6]),
        ({"start": 0.6, "stop": 0.4, "step": -0.1}, [0.6, 0.5, 0.4]),
        ({"start": 1, "stop": 2, "num": 5}, [1, 1.25, 1.5, 1.75, 2]),
    ],
)
def test_a_range_is_the_list_of_its_values(parse, written, values):
    ranged, listed = (parse(chute_study(grid={"friction": one})) for one in (written, values))
    assert ranged.points == listed.points
    # Whole numbers stay whole, and what is no range is left to others.
    assert expand_range({"start": 1, "stop": 5, "num": 3}, are_whole=True) == [1, 3, 5]
    assert expand_range([1, 2]) == [1, 2] and expand_range("a") == "a"


def test_the_study_file_comes_first_and_its_parts_in_their_order(parse, tmp_path):
    series = "series: [{{name: {}, system: chute, base: {{depth: {}}}}}]\n"
    for name, depth in (("one", 2), ("two", 3)):
        (tmp_path / f"{name}.yaml").write_text(f"study: {name}\n" + series.format(name, depth))
    path = tmp_path / "study.yaml"
    path.write_text("study: s\nparts: [two.yaml, one.yaml]\n" + series.format("c", 3))
    study = load_study(path, None)
    assert [one.name for one in study.files] == ["study.yaml", "two.yaml", "one.yaml"]
    assert list(study.series) == ["c", "two", "one"] and study.plugins == ()
    # A point of two of them is one.
    assert [point.series for point in study.points.values()] == [("c", "two"), ("one",)]


@pytest.mark.parametrize("kind", ["results", "study", "link"])
def test_results_that_cannot_be_written_are_refused(example, tmp_path, kind):
    results = tmp_path / "results"
    if kind == "link":
        results.symlink_to(tmp_path / "nowhere")
    else:
        path = results if kind == "results" else results / "example"
        path.parent.mkdir(exist_ok=True)
        path.write_text("a file")
    before = list(tmp_path.rglob("*"))
    parse_study(example, "study.yaml", tmp_path / "not" / "yet")
    assert list(tmp_path.rglob("*")) == before
    with pytest.raises(InputError, match=r"study.yaml: study: got .*; allowed: a folder that can"):
        parse_study(example, "study.yaml", results)


def test_estimates_grow_with_the_run():
    assert [duration(seconds) for seconds in (4.51, 90, 7200)] == ["4.5 s", "1.5 min", "2.0 h"]
    short = estimate(ChuteParameters(transient=10, average=10))
    assert short.particles == 500
    assert short.steps == ChuteParameters(transient=10, average=10).steps
    more = estimate(ChuteParameters(transient=10, average=10, replicates=3))
    assert more.steps == 3 * short.steps
    assert 0 < short.core_seconds < more.core_seconds
    deep = ChuteParameters(transient=10, average=10, depth=10, cell=10 / 2**0.5)
    assert estimate(deep).particles == short.particles
    assert estimate(deep).core_seconds > short.core_seconds
    # What went before counts.
    alone = estimate(BeltParameters())
    shaken = estimate(BeltParameters(prior_frequency=30, prior_cycles=7, replicates=2))
    assert shaken.steps == 2 * (alone.steps + 7 * BeltParameters().steps_per_cycle)
    assert estimate(BeltParameters(prior_cycles=7)).steps == alone.steps


def test_glued_spheres_count_and_have_a_limit():
    smooth, rough, most = (estimate(ChuteParameters(bumps=bumps)) for bumps in (0, 0.1, 0.03))
    # Circles of 0.03 σ that cover 40 % of 100 σ².
    assert ChuteParameters(bumps=0.03).glued_particles == 56_588
    assert ChuteParameters(bumps=0.1).glued_particles == 5_093
    assert rough.core_seconds > 5 * smooth.core_seconds
    assert rough.memory - smooth.memory == pytest.approx(5_093 * 4e-3, abs=1)
    # Each has 47 others within a skin, of which the neighbor list holds half the pairs.
    assert most.memory - smooth.memory == pytest.approx(56_588 * 47 / 8 * 4e-3, rel=0.01)


def test_trajectories_count_as_memory_and_on_the_disk(example, parse):
    alone, framed = (ChuteParameters(trajectory=distance) for distance in (0, 1))
    assert estimate(alone).trajectory == 0
    # 500 frames of 500 spheres, 9 numbers of 4 bytes each, in the run file and beside it.
    assert estimate(framed).trajectory == pytest.approx(18)
    more = estimate(framed).memory - estimate(alone).memory
    assert more == pytest.approx(3.5 * 9, abs=1)
    study = parse(example)
    assert "trajectories" not in as_table(study)
    example["defaults"] = {"chute": {"trajectory": 10}}
    study = parse(example)
    # A frame after each 10 √(σ/g) of a transient of 300, or 200 at a depth of 20, and 50 more.
    frames = [35, 35, 35, 35, 25, 25, 35]
    assert f"trajectories of 7 points: at most {sum(frames)} frames, " in as_table(study)
    points = json.loads(as_json(study))["points"]
    assert [point["trajectory_frames"] for point in points] == frames


def test_doubtful_points_are_pointed_out(parse, tmp_path, monkeypatch):
    monkeypatch.setattr("psutil.virtual_memory", lambda: SimpleNamespace(total=8e9))
    study = parse(chute_study(base={"cell": 3}, grid={"depth": [5, 1e6]}))
    (line,) = warnings(study, tmp_path)
    assert line.startswith("chute-depth1e06-") and "MB of memory" in line
    study = parse(chute_study(base={"diameter": 100}, grid={"depth": [2, 5]}))
    (line,) = warnings(study, tmp_path)
    assert line == "at 2 points: diameter: 100 is 100 m; if you mean 100 mm, write 0.1"
    right = parse(chute_study(base={"diameter": 0.1, "density": 1300, "stiffness": 1e4}))
    assert not [*warnings(right, tmp_path)]
    line = "warning of replicates: 2 at 1 point: the 95 % interval of two is 12.7 standard errors"
    cases = [{"replicates": 2}, {"depth": 2, "replicates": 3}]
    assert line in as_table(parse(chute_study(cases=cases)))
    assert "replicates" not in as_table(parse(chute_study(cases=cases[1:])))


def test_along_a_list_each_point_starts_from_the_one_before(parse):
    lists = {"depth": [2, 3], "angle": [18, 20, 18], "friction": [0.5]}
    sweep = {"name": "a", "system": "chute", "base": {"start_from": "previous"}, "grid": lists}
    cases = [{"angle": 30}, {"angle": 25}, {"angle": 20, "start_from": ""}]
    base = {"start_from": "previous", "replicates": 2}
    study = parse({"study": "s", "series": [sweep, sweep | {"name": "b", "base": base}]})
    ids = list(study.points)
    assert [point.parameters.depth for point in study.points.values()] == [2] * 3 + [3] * 3
    starts = [point.parameters.start_from for point in study.points.values()]
    assert starts == ["", *ids[:2], "", *ids[3:5]]
    assert all(point.parameters.replicates == 2 for point in study.points.values())
    study = parse(chute_study(base={"start_from": "previous"}, cases=cases))
    ids = list(study.points)
    assert [one.parameters.start_from for one in study.points.values()] == ["", ids[0], ""]


def test_what_points_start_from_is_bought_as_many_replicates_as_they(parse):
    series = [{"name": "a", "system": "chute"}]
    first = next(iter(parse({"study": "s", "series": series}).points))
    for name in ("b", "c"):
        base = {"angle": 20 + len(series), "start_from": first}
        series.append({"name": name, "system": "chute", "base": base})
        study = parse({"study": "s", "series": series})
        *_, first = study.points
    longer = with_extra_amounts(study.points, ExtraAmounts({first: {"replicates": 5.0}}))
    assert [point.parameters.replicates for point in longer.values()] == [5, 5, 5]
