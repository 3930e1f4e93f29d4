"""Results in Python: the table of what they hold, grids over parameters, plots."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

import sim
from sim.dataset.results import COLUMNS
from sim.figures.render import draw
from sim.report.results import LabelledResults
from sim.study.load import parse_study
from tests.made.results import made_point, made_results
from tests.test_published import STUDIES

GRID = [
    made_point("chute", {"velocity": depth * friction}, depth=depth, friction=friction)
    for depth in (1.5, 2.0)
    for friction in (0.3, 0.4, 0.5)
]
BELT = made_point("belt", {"velocity": 0.1}, frequency=30)


def results_of(*points) -> LabelledResults:
    made = made_results(*points)
    names = np.array([str(system) for system in made.dataset["system"].values], object)
    dataset = made.dataset.assign_coords(series=("point", names))
    table = pd.DataFrame(columns=COLUMNS)
    return LabelledResults(**vars(replace(made, dataset=dataset, boundaries=table)))


def test_a_grid_has_the_mean_and_the_interval_of_each_point():
    found = results_of(*GRID[:-1], BELT)
    grid = found.to_grid(system="chute")
    assert grid.dims == ("depth", "friction") and grid.units == "m s-1"
    assert grid.sel(depth=2, friction=0.4).item() == pytest.approx(0.8)
    assert np.isnan(grid.sel(depth=2, friction=0.5)) and grid.notnull().sum() == 5
    rows = found.dataset.set_index(point=["depth", "friction"])
    expected = rows.point_half_width.sel(point=(1.5, 0.3)).item()
    assert grid.half_width.sel(depth=1.5, friction=0.3).item() == pytest.approx(expected)
    assert grid.half_width.units == "m s-1"
    assert grid.regime.sel(depth=1.5, friction=0.3) == "steady" and (grid.caveat == "").all()


def test_what_was_measured_of_failed_runs_is_in_no_mean_of_a_study(monkeypatch):
    lost = {"status": ["completed", "failed"], "velocity": [1.0, np.nan], "base_shear": [1.0, 9e9]}
    points = [GRID[0], made_point("chute", lost, replicates=2, depth=3), BELT]
    monkeypatch.setattr("sim.dataset.results.load_results", lambda _: results_of(*points))
    with pytest.warns(UserWarning, match="mine: runs of 1 of 3 points failed"):
        found = sim.load("mine")
    dataset = found.dataset.sel(point=points[1].id)
    assert dataset.base_shear.values[:2] == pytest.approx([1, np.nan], nan_ok=True)
    assert dataset.steps.values[:2].all()


@pytest.mark.parametrize(
    ("points", "arguments", "message"),
    [
        (GRID, ("speed",), "to_grid: observable: got 'speed'; did you mean velocity?"),
        ([*GRID, BELT], (), "results: system: got nothing; allowed: one of chute, belt"),
        (GRID, ("velocity", "belt"), "results: system: got 'belt'; allowed: one of chute"),
        (GRID, ("velocity", "", "b"), "results: series: got 'b'; allowed: one of chute"),
        (GRID[:1], (), "to_grid: got '1 point'; allowed: results whose points vary a parameter"),
        (
            [*GRID, made_point("chute", {"velocity": 1.0}, depth=1.5, friction=0.3, seed=7)],
            (),
            "to_grid: got '2 points at depth 1.5, friction 0.3'; allowed: one point at each place: "
            "these differ in seed",
        ),
        (
            [
                made_point("chute", {"velocity": 1.0}, depth=1 + n, friction=0.3 + n / 50)
                for n in range(4)
            ],
            (),
            "to_grid: got '4 points at 16 places of depth, friction'; allowed: a grid, as of one",
        ),
    ],
)
def test_what_is_no_grid_is_refused(points, arguments, message):
    with pytest.raises(sim.InputError) as refused:
        results_of(*points).to_grid(*arguments)
    assert str(refused.value).startswith(message)


def test_the_table_is_short_and_says_what_there_is():
    lines = repr(results_of(*GRID, BELT)).splitlines()
    assert len(lines) <= 15 and lines[0].split()[:2] == ["study", "made:"]
    assert lines[1].split() == ["chute", "6", "points,", "30", "runs"]
    assert " ".join(lines[3].split()) == "varied depth (1.5, 2); friction (0.3, 0.4, 0.5)"
    assert "velocity" in lines[4] and "velocity_error" not in lines[4]
    found = results_of(*GRID)
    named = replace(found, dataset=found.dataset.assign_attrs(title="a < b"))
    text = named._repr_html_()
    assert text.startswith("<table>") and "a &lt; b" in text and "6 points, 30 runs" in text


@pytest.mark.parametrize("study", STUDIES, ids=lambda path: path.name)
def test_a_study_of_one_system_has_no_columns_of_others(study):
    found = sim.load(study)
    (system,) = set(found.dataset["system"].values)
    foreign = {"chute": "frequency", "belt": "friction"}[system]
    assert foreign not in found.dataset
    assert found.of(system).identical(found.dataset)
    assert len(repr(found).splitlines()) <= 15


def test_a_plot_is_that_of_a_study_file():
    keys = {"x": "friction", "curves": "depth", "log": ["y"]}
    series = {"name": "chute", "system": "chute", "base": {"replicates": 5}}
    series["grid"] = {"depth": [1.5, 2.0], "friction": [0.3, 0.4, 0.5]}
    text = {"study": "s", "series": [series], "plots": [keys | {"name": "v"}]}
    study = parse_study(text, "s", None)
    found = results_of(*GRID, BELT)
    shown = []
    for figure in (found.plot(**keys, system="chute"), draw(study.plots["v"], found)):
        (axes,) = figure.axes
        lines = [line.get_xydata().tolist() for line in axes.lines]
        shown.append((axes.get_xlabel(), axes.get_ylabel(), lines))
    assert shown[0] == shown[1]
    heights = [y for line in shown[0][2] if len(line) == 3 for _, y in line]
    assert heights[:3] == pytest.approx([0.45, 0.6, 0.75])


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"x": "mu"}, "results: plot.x: got 'mu'; did you mean friction?"),
        ({"x": "friction", "hue": "depth"}, "results: plot.hue: unknown key, got 'depth'; did you"),
        ({"x": "friction", "series": ["a"]}, "results: plot.series: got 'a'; allowed: one of ch"),
        ({}, "results: plot.x: got nothing; allowed: a parameter"),
    ],
)
def test_a_mistake_in_a_plot_is_that_of_a_study_file(keys, message):
    with pytest.raises(sim.InputError) as refused:
        results_of(*GRID).plot(**keys)
    assert str(refused.value).startswith(message)
