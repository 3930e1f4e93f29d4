"""A density in place of the mass, and sizes that are probably not meant."""

from math import pi

import pytest

import sim
from sim.parameters import SYSTEMS, parse_point, point_id
from sim.parameters.doubts import doubts, doubts_of
from sim.study.load import parse_study, points
from sim.study.papers import paper_values

DIAMETER, DENSITY = 0.008, 1300.0
MASS = DENSITY * pi / 6 * DIAMETER**3


def series(**keys) -> dict:
    return {"study": "s", "series": [{"name": "a", "system": "conveyor"} | keys]}


@pytest.mark.parametrize("system", SYSTEMS)
def test_a_point_of_a_density_is_that_of_its_mass(system):
    sized = {"system": system, "diameter": DIAMETER}
    one = parse_point(sized | {"density": DENSITY}, "p.yaml")
    other = parse_point(sized | {"mass": MASS}, "p.yaml")
    assert one == other and point_id(one) == point_id(other)
    assert one.density == pytest.approx(DENSITY)


SIZED = {"base": {"diameter": DIAMETER}}
SET = {"when": {"diameter": [DIAMETER]}, "set": {"density": DENSITY}}


@pytest.mark.parametrize(
    ("keys", "masses"),
    [
        ({"base": {"diameter": DIAMETER, "density": DENSITY}}, [MASS]),
        (SIZED | {"grid": {"density": [DENSITY, 2600]}}, [MASS, 2 * MASS]),
        ({"grid": {"diameter": [DIAMETER, 0.016], "density": [DENSITY]}}, [MASS, 8 * MASS]),
        (SIZED | {"cases": [{"density": DENSITY}]}, [MASS]),
        # What is given later replaces what is given earlier, one in place of the other.
        ({"base": {"diameter": DIAMETER, "mass": 1e-6}, "grid": {"density": [DENSITY]}}, [MASS]),
        ({"base": {"diameter": DIAMETER, "density": DENSITY}, "grid": {"mass": [1e-6]}}, [1e-6]),
        ({"grid": {"diameter": [DIAMETER]}, "overrides": [SET]}, [MASS]),
    ],
)
@pytest.mark.filterwarnings("ignore::UserWarning")
def test_a_density_stands_wherever_a_mass_does(keys, masses):
    assert points(series(**keys)).mass.tolist() == pytest.approx(masses, rel=1e-9)


@pytest.mark.filterwarnings("ignore::UserWarning")
def test_a_design_over_densities_asks_for_masses():
    over = {"density": [DENSITY, 2600], "friction": [0.1, 0.5]}
    design = {"kind": "sobol", "points": 8, "over": over}
    asked = series(base={"diameter": DIAMETER}, design=design)
    asked |= {"surrogate": [{"name": "speed", "series": "a"}]}
    study = parse_study(asked, "s.yaml", None)
    axes = {axis.name: axis for axis in study.surrogates[0].axes}
    assert axes.keys() == {"friction", "mass"}
    assert (axes["mass"].low, axes["mass"].high) == pytest.approx((MASS, 2 * MASS))
    masses = [point.parameters.mass for point in study.points.values()]
    assert MASS <= min(masses) < max(masses) <= 2 * MASS and len(set(masses)) == 8


@pytest.mark.parametrize(
    ("values", "named"),
    [
        ({}, []),
        ({"diameter": 0.008}, ["mass", "stiffness"]),
        ({"diameter": 0.008, "density": 1300}, ["stiffness"]),
        ({"diameter": 0.008, "mass": 1e-3, "stiffness": 1e4}, []),
        ({"diameter": 0.008, "density": 30, "stiffness": 1e4}, ["mass"]),
        ({"density": 99}, ["mass"]),
        ({"density": 25_001}, ["mass"]),
        ({"density": 24_999}, []),
        # Without dimension: everything is 1.
        ({"diameter": 1, "mass": 1, "gravity": 1}, []),
    ],
)
@pytest.mark.parametrize("system", ["chute", "conveyor"])
def test_sizes_that_are_probably_not_meant_are_told(system, values, named):
    point = parse_point({"system": system} | values, "p.yaml")
    assert [name for name, _ in doubts(point)] == named
    assert len(doubts_of([point, point])) == len(named)


def test_python_warns_of_them():
    what = "is a density of 5.57 kg/m³; give density or mass"
    with pytest.warns(UserWarning, match=what):
        points(series(base={"diameter": 0.008}))
    with pytest.warns(UserWarning, match=what):
        sim.Flow("chute", diameter=0.008, depth=1.5, cell=4)


def test_what_all_points_have_as_a_paper_is_listed():
    keys = {"base": {"diameter": 0.002, "mass": 1e-5}, "grid": {"friction": [0.3, 0.4]}}
    study = parse_study(series(**keys), "s.yaml", None)
    found = paper_values(point.parameters for point in study.points.values())
    texts = ["n = 5", "e = 0.85", "K1 = 100 N/m", "g = 9.8 m/s²"]
    assert found == {"Walton (1993), conveyor": texts}
    base = {"law": "spring_dashpot", "normal_damping": 900}
    study = parse_study(series(base=base, grid={"stiffness": [100, 200]}), "s.yaml", None)
    (held,) = paper_values(point.parameters for point in study.points.values()).values()
    assert "μ = 0.4" in held and "e = 0.85" not in held
    belt = paper_values([parse_point({"system": "belt", "frequency": 20}, "p")])
    assert list(belt) == ["Gallas et al. (1992), belt"] and "f = 20 Hz" in belt.popitem()[1]
