"""Studies under several readings of the papers: their points, and the points in figures."""

import pytest

from sim.base.errors import InputError
from sim.study.load import parse_study


def study(readings, **rest):
    return parse_study({"study": "s", "readings": readings} | rest, "study.yaml", None)


SERIES = {"name": "a", "system": "belt"}
MASSES = {"belt": {"damping_mass": ["reduced", "own"]}}


def test_every_series_has_the_points_of_each_reading():
    grid, case = {"frequency": [20, 80]}, {"frequency": 50}
    found = study(MASSES, series=[SERIES | {"grid": grid, "cases": [case]}])
    points = [(p.parameters.damping_mass, p.parameters.frequency) for p in found.points.values()]
    assert points == [(mass, f) for mass in ("reduced", "own") for f in (20, 80, 50)]


def test_readings_of_several_parameters_combine():
    several = {"belt": {"damping_mass": ["own", "reduced"], "belt_ghost": ["below", "centred"]}}
    found = study(several, series=[SERIES])
    names = "damping_mass", "belt_ghost"
    points = {tuple(getattr(p.parameters, n) for n in names) for p in found.points.values()}
    assert points == {(m, g) for m in ("own", "reduced") for g in ("below", "centred")}


def test_figures_show_the_first_reading_but_those_that_tell_them_apart():
    figures = ["gallas_1a", "readings_1a"]
    found = study(MASSES, series=[SERIES | {"grid": {"frequency": [20, 80]}, "figures": figures}])
    shown = {name: [found.points[one] for one in ids] for name, ids in found.figures.items()}
    assert {p.parameters.damping_mass for p in shown["gallas_1a"]} == {"reduced"}
    assert len(shown["readings_1a"]) == 4


def test_a_series_may_have_a_reading_of_its_own():
    found = study(MASSES, series=[SERIES | {"base": {"damping_mass": "own"}}])
    assert [p.parameters.damping_mass for p in found.points.values()] == ["own"]


def test_boundaries_are_looked_for_under_the_first():
    boundary = {"of": "transport", "along": "frequency", "range": [10, 26], "tolerance": 4}
    found = study(MASSES, boundaries=[SERIES | boundary])
    assert len(found.boundaries) == 1
    assert {p.parameters.damping_mass for p in found.points.values()} == {"reduced"}


def test_other_systems_know_nothing_of_them():
    found = study(MASSES, series=[{"name": "b", "system": "chute"}])
    assert len(found.points) == 1


@pytest.mark.parametrize(
    ("readings", "message"),
    [
        ({"belt": {"frequency": [10, 20]}}, "readings.belt.frequency: unknown key"),
        ({"belt": {"damping_mass": ["mean"]}}, "readings.belt.damping_mass[0]: got 'mean'"),
        ({"belt": {}}, "readings.belt: got {}"),
    ],
)
def test_mistakes_are_named(readings, message):
    with pytest.raises(InputError) as raised:
        study(readings, series=[SERIES])
    assert message in str(raised.value)


def test_points_of_all_readings_count_against_the_limit():
    grid = {"frequency": [10 + 0.001 * n for n in range(60_000)]}
    with pytest.raises(InputError, match="120,000 points"):
        study(MASSES, series=[SERIES | {"grid": grid}])
