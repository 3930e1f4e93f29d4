"""Numbers with units, and keys in place of parameters: points have plain numbers and parameters."""

from math import cos, pi, radians, sin, tan

import pytest

import sim
from sim.parameters import SYSTEMS, parse_point, point_id
from sim.parameters.in_place import given_by, plain_numbers, scales
from sim.parameters.roles import declarations
from sim.study.load import parse_study, points

DIAMETER = 0.008
SIZES = {"diameter": DIAMETER, "density": 1300, "frequency": 25}

#: A unit of each kind, and how many of the SI unit it makes.
UNITS = {
    "m": ("mm", 1e-3),
    "kg": ("g", 1e-3),
    "Hz": ("rpm", 1 / 60),
    "s": ("ms", 1e-3),
    "s-1": ("1/ms", 1e3),
    "m s-1": ("cm/s", 1e-2),
    "m s-2": ("mm/s²", 1e-3),
    "m2 s-2": ("mm^2/s^2", 1e-6),
    "N m-1": ("kN/m", 1e3),
    "kg m-3": ("g/cm³", 1e3),
    "Pa": ("MPa", 1e6),
    "degree": ("rad", 180 / pi),
    "1": ("%", 1e-2),
}


def sizes_of(system: str) -> dict[str, float]:
    return {name: SIZES[name] for name in SIZES if name in SYSTEMS[system].model_fields}


@pytest.mark.parametrize("system", SYSTEMS)
def test_each_number_may_have_a_unit_of_its_kind(system):
    model = SYSTEMS[system]
    point = parse_point({"system": system} | sizes_of(system), "p.yaml")
    known = scales(vars(point))
    texts, plain = {}, {}
    for name, row in declarations(model).items():
        if model.model_fields[name].annotation is float and row.scale != "r_i + r_j":
            size, unit = known[row.scale] if row.scale else (1.0, row.unit)
            other, factor = UNITS[unit]
            texts[name] = f"3 {other}"
            plain[name] = float(f"{3 * factor / size:.12g}")
    assert len(texts) > 20
    assert plain_numbers(texts, model, known) == pytest.approx(plain, rel=1e-11)
    assert plain_numbers({name: "3 K" for name in texts}, model, known) == dict.fromkeys(
        texts, "3 K"
    )


@pytest.mark.parametrize(
    ("given", "plain"),
    [
        ({"diameter": "8 mm", "cell": "8 cm", "mass": "0.35 g"}, {"cell": 10.0, "mass": 0.00035}),
        ({"diameter": "8 mm", "cell": ["8 cm", "4 cm"]}, {"cell": 10.0, "cell_across": 5.0}),
        ({"frequency": "30 Hz", "transient": "2 s"}, {"frequency": 30.0, "transient": 60.0}),
        ({"angle": "20°", "gravity": "9.81 m/s²"}, {"angle": 20.0, "gravity": 9.81}),
        ({"diameter": "2 mm", "stroke": "4 mm", "vibration_angle": "30 deg"}, {"amplitude": 0.5}),
    ],
)
@pytest.mark.filterwarnings("ignore::UserWarning")
def test_ids_are_those_of_plain_numbers_by_each_door(given, plain):
    point = parse_point({"system": "conveyor"} | given, "p.yaml")
    same = {name: getattr(point, name) for name in declarations(type(point))}
    assert {name: same[name] for name in plain} == plain
    assert point_id(parse_point(same, "p.yaml")) == point_id(point)
    series = {"name": "a", "system": "conveyor"}
    lists = {name: [value] for name, value in given.items() if not isinstance(value, list)}
    for keys in ({"base": given}, {"cases": [given]}, {"grid": lists, "base": given}):
        assert [*points({"study": "s", "series": [series | keys]}).index] == [point_id(point)]
    flow = sim.Flow("conveyor", depth=0.2, **given)
    assert flow.parameters.diameter == point.diameter


@pytest.mark.filterwarnings("ignore::UserWarning")
def test_units_stand_in_grids_ranges_conditions_and_designs():
    grid = {"diameter": ["8 mm", 0.004], "amplitude": {"start": "1 mm", "stop": "2 mm", "num": 2}}
    change = {"when": {"amplitude": ["1 mm"], "diameter": ["8 mm"]}, "set": {"friction": 0.7}}
    series = {"name": "a", "system": "conveyor", "grid": grid, "overrides": [change]}
    table = points({"study": "s", "series": [series]})
    assert table.amplitude.tolist() == [0.125, 0.25, 0.25, 0.5]
    assert table.friction.tolist() == [0.7, 0.4, 0.4, 0.4]
    design = {"kind": "sobol", "points": 4, "over": {"frequency": ["900 rpm", "30 Hz"]}}
    (axis,) = (
        parse_study(
            {"study": "s", "series": [{"name": "a", "system": "conveyor", "design": design}]},
            "s",
            None,
        )
        .designs["a"]
        .axes
    )
    assert (axis.low, axis.high) == (15, 30)


@pytest.mark.parametrize("angle", [20, 45, 90])
@pytest.mark.parametrize("system", ["belt", "conveyor"])
def test_a_stroke_is_twice_the_amplitude_along_the_line_of_motion(system, angle):
    given = {"system": system, "vibration_angle": angle}
    point = parse_point(given | {"stroke": 2}, "p.yaml")
    assert point.amplitude == pytest.approx(sin(radians(angle)))
    if system == "conveyor":
        same = parse_point(given | {"amplitude": point.amplitude}, "p.yaml")
        assert same.amplitude_along == pytest.approx(point.amplitude_along, abs=1e-12)
        assert point.amplitude_along == pytest.approx(cos(radians(angle)), abs=1e-12)
        assert (point.amplitude_along == 0) == (angle == 90)
        alone = parse_point(given, "p.yaml")
        assert alone.amplitude_along == pytest.approx(1 / tan(radians(angle)), abs=1e-11)
    assert given_by(SYSTEMS[system], "stroke")[0] == "amplitude"


@pytest.mark.parametrize(
    ("base", "later", "amplitudes"),
    [
        ({"stroke": 2}, {"amplitude": [0.5]}, (0.5, 1.0)),
        ({"stroke": 2, "vibration_angle": 45}, {"amplitude": [0.5]}, (0.5, 0.5)),
        ({"amplitude": 3, "amplitude_along": 3}, {"stroke": [2]}, (0.5**0.5, 0.5**0.5)),
        ({"amplitude_along": 3}, {"vibration_angle": [45]}, (1.0, 1.0)),
        ({"vibration_angle": 30}, {"amplitude_along": [3]}, (1.0, 3.0)),
    ],
)
def test_what_is_given_later_replaces_what_is_given_earlier(base, later, amplitudes):
    series = {"name": "a", "system": "conveyor", "base": base, "grid": later}
    table = points({"study": "s", "series": [series]})
    (row,) = zip(table.amplitude, table.amplitude_along, strict=True)
    assert row == pytest.approx(amplitudes)
