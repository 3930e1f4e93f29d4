"""Points: equal numbers, names that read well and differ, descriptions of all parameters."""

import re

import pytest

from sim.base.yaml import parse_yaml
from sim.parameters import (
    AMOUNTS,
    SYSTEMS,
    BeltParameters,
    ChuteParameters,
    ConveyorParameters,
    amounts,
    as_yaml,
    canonical_json,
    canonical_values,
    complete_values,
    defaults_of_added,
    field_info,
    parse_point,
    point_id,
)


def test_amounts_are_those_that_have_an_effect():
    names = {"replicates", "average", "target"}
    assert amounts(ChuteParameters(protocol="published")).keys() == names
    assert amounts(ChuteParameters(protocol="converged")).keys() == names | {"limit"}


def test_equal_numbers_are_one_point():
    for first, second in [(0.1 + 0.2, 0.3), (0.7 * 0.5, 0.35), (1, 1.0), (0.0, -0.0)]:
        one, other = ChuteParameters(friction=first), ChuteParameters(friction=second)
        assert point_id(one) == point_id(other)
    assert point_id(ChuteParameters(friction_plane=0.4)) == point_id(ChuteParameters())


def test_ids_show_what_differs_from_the_paper_and_hide_what_is_numerical():
    chute = point_id(ChuteParameters(depth=1.24, restitution=0.7))
    assert chute.startswith("chute-depth1.24-friction0.4-restitution0.7-stiffness100-")
    steep = point_id(ChuteParameters(angle=18, transient=10, friction_plane=0.3))
    assert re.fullmatch(r"chute-.*-stiffness100-friction_plane0.3-angle18-[0-9a-f]{8}", steep)
    verlet = point_id(BeltParameters(integrator="verlet", steps_per_cycle=4000))
    assert re.fullmatch(r"belt-.*-shear50-integrator-verlet-[0-9a-f]{8}", verlet)
    discs = point_id(ConveyorParameters(rotation=False))
    assert re.fullmatch(r"conveyor-.*-along1-rotation0-[0-9a-f]{8}", discs)


@pytest.mark.parametrize("system", SYSTEMS)
def test_every_parameter_is_in_the_id_but_how_much_is_wanted(system):
    special = {"corrector_order": 4, "steps_per_cycle": 2020, "samples_per_cycle": 10}
    special |= {
        "start_from": "run.nc",
        "schedule": {"angle": [[0, 5], [1, 17]]},
        "cell_across": 5.0,
        "initial_state": "x (d), z (d)\n1, 3\n",
    }
    others = {"ghost_mass": {"damping_mass": "reduced"}, "trajectory_contacts": {"trajectory": 1}}
    if system != "belt":
        names = "attraction", "tangential_unloading", "engine", "youngs_modulus"
        special["youngs_modulus"] = 2e6
        others["poisson_ratio"] = {"law": "hertz", "youngs_modulus": 2e6}
        for name in ("normal_damping", "tangential_damping"):
            others[name] = {"law": "spring_dashpot"}
        others |= {"shear_damping": {"law": "drag"}} | {name: {"law": "hertz"} for name in names}
        dampings = "normal_damping", "tangential_damping"
        others |= {name: {"law": "spring_dashpot"} for name in dampings}
        others |= {"bump_arrangement": {"bumps": 1}, "ranks": {"law": "hertz", "engine": "lammps"}}
    default = SYSTEMS[system]()
    for name, row in field_info(default).items():
        if name == "system":
            continue
        match value := getattr(default, name):
            case bool():
                new = not value
            case int():
                new = value + 1
            case str():
                words = re.findall(r"\w+", row.allowed)
                new = next((word for word in words[::-1] if word != value), "")
            case _:
                new = 0.9 * value if value else 0.5
        new = special.get(name, new)
        rest = {"system": system} | others.get(name, {})
        point = parse_point(rest | {name: new}, "point.yaml")
        same = point_id(point) == point_id(parse_point(rest, "point.yaml"))
        assert same == (name in AMOUNTS), name


def test_a_parameter_added_later_is_in_the_name_where_it_is_used_alone():
    """Older points keep their ids, and so do new points with its default."""
    usual = BeltParameters()
    for name, value in (("slice_height", 0.5), ("corrections", 2), ("phase_0_profiles", True)):
        default = defaults_of_added("belt")[name]
        assert name not in canonical_values(usual) and name not in canonical_json(usual)
        assert complete_values(usual)[name] == default
        assert point_id(BeltParameters(**{name: default})) == point_id(usual)
        used = BeltParameters(**{name: value})
        assert canonical_values(used) == canonical_values(usual) | {name: value}
        assert parse_point(canonical_values(used), "point.yaml") == used
    assert "-corrections2-" in point_id(BeltParameters(corrections=2))
    added = defaults_of_added("chute")
    assert {"engine", "ranks", "start_from"} <= added.keys() and added["attraction"] == "kept"


@pytest.mark.parametrize(
    ("system", "values"),
    [
        ("chute", {"restitution": 1, "angle": 0, "friction": 0, "depth": 0.01}),
        ("chute", {"restitution": 0.001, "angle": 89.999}),
        ("belt", {"vibration_angle": 90, "obstacle": 16.999, "damping": 0, "shear_damping": 0}),
        ("belt", {"beads": 1}),
    ],
)
def test_boundaries_that_belong_to_the_range_are_accepted(system, values):
    point = parse_point({"system": system} | values, "point.yaml")
    assert all(getattr(point, name) == value for name, value in values.items())


@pytest.mark.parametrize("model", SYSTEMS.values())
def test_every_parameter_is_described_and_in_a_point_file(model):
    assert parse_yaml(as_yaml(model()), "point.yaml") == complete_values(model())
    rows = field_info(model)
    assert set(rows) == set(model.model_fields)
    assert next(iter(rows)) == "system"
    for row in rows.values():
        assert row.description and not row.description.endswith("."), row.name
        assert row.allowed, row.name
        number = isinstance(getattr(model(), row.name), float)
        assert bool(row.unit) or not number, row.name


TWO = "x (mm), z (mm), vx (m/s)\n1, 3, 0.1\n2.5, 3, -0.1\n"


def point(text=TWO, **values):
    return parse_point({"system": "chute", "cell": 4, "initial_state": text} | values, "p.yaml")


def test_the_content_is_part_of_the_id_and_the_path_is_not(tmp_path):
    for name in ("a.csv", "b.csv"):
        (tmp_path / name).write_text(TWO)
    (tmp_path / "c.csv").write_text(TWO.replace("0.1", "0.2"))
    first, second, third = (
        parse_point(
            {"system": "chute", "cell": 4, "initial_state": f"{name}.csv"}, tmp_path / "p.yaml"
        )
        for name in "abc"
    )
    assert first == second == point() and point_id(first) != point_id(third)
    assert "csv" not in point_id(first) and first.particles == 2 and first.depth == 2 / 16


def test_both_sides_of_a_cell_count():
    for sides in ({"cell": [4, 8]}, {"cell_across": 8}):
        assert (point(**sides).particles, point(**sides).depth) == (2, 2 / 32)


@pytest.mark.parametrize(
    "text",
    [
        "z (m), x (m), vx (cm/s)\n0.003, 0.001, 10\n0.003, 0.0025, -10\n",
        "x, z, vx, vz, wy\n0.001, 0.003, 0.1, 0, 0\n0.0025, 0.003, -0.1, 0, 0\n",
    ],
)
def test_order_units_and_columns_of_rest_make_no_other_point(text):
    assert point_id(point(text)) == point_id(point())


def test_a_point_as_yaml_holds_its_state_and_one_in_files_its_hash():
    given = point("x (d), z (d), mass\n1, 2, 1e-6\n3, 2, 2e-6\n")
    assert parse_point(parse_yaml(as_yaml(given), "p"), "p") == given
    values = canonical_values(given)
    assert parse_point(values, "p") == given and "\n" not in values["initial_state"]
