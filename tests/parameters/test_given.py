"""Given states: one point for one content, and errors that name file, line and column."""

import pytest

from sim.base.errors import InputError
from sim.base.yaml import parse_yaml
from sim.parameters import as_yaml, canonical_values, parse_point, point_id

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


@pytest.mark.parametrize(
    ("text", "values", "message"),
    [
        ("x, q\n1, 2\n", {}, "heading: got 'q'; allowed: one of x, y, z"),
        ("x, vz\n1, 2\n", {}, "column z: got nothing"),
        ("x, z, mass, density\n0, 1, 1, 1\n", {}, "heading: got 'density'; allowed: mass or"),
        ("x (d), z (d)\n1, 2\n1, a\n", {}, "line 3, column z: got 'a'; allowed: a number"),
        ("x (d), z (d)\n1, 2\n4, 2\n", {}, r"line 3, column x: got '4'; allowed: .* \[0, 0.004\)"),
        ("x (d), y, z (d)\n1, -1, 2\n", {}, "line 2, column y: got '-1'"),
        ("x (d), z (d)\n1, 0.2\n", {}, "line 2, column z: got '0.2'; allowed: above 0.00025 m"),
        ("x (d), z (d)\n1, 2\n1.7, 2\n", {}, "line 3, column x: got '1.7'; .* of line 2 by less"),
        ("x (d), z (d)\n0.1, 2\n3.8, 2\n", {}, "line 3, column x: got '3.8'"),
        ("x (d), z (d), mass\n1, 2, 0\n", {}, "line 2, column mass: got '0'"),
        ("x (d), z (d), radius (d)\n1, 3, 1.5\n", {}, "column radius: got '1.5'; allowed: smaller"),
        ("x (m/s), z\n1, 2\n", {}, "unit of column x: got 'm/s'; allowed: a unit such as m"),
        (TWO, {"depth": 3}, r"depth: got 3; allowed: 0.125, or nothing: .* has 2 particles"),
        (TWO, {"start_from": "a.nc"}, "start_from: got 'a.nc'; allowed: nothing beside"),
        (TWO, {"replicates": 3}, "replicates: got 3; allowed: 1 with this initial_state"),
        (TWO, {"initial_height": 1}, "initial_height: got 1; allowed: 0 unless there is no"),
        (TWO, {"system": "conveyor", "shape": "disc", "initial_state": TWO.replace("vx", "vy")},
         "line 2, column vy: got '0.1'; allowed: 0, or no column"),
        (TWO, {"initial_state": "two.csv"}, "two.csv: no such file"),
        (TWO, {"initial_state": "../two.csv"}, "got '../two.csv'; allowed: the name of"),
    ],
)  # fmt: skip
def test_a_state_that_cannot_be_is_refused_in_one_line(text, values, message):
    with pytest.raises(InputError, match=message):
        point(text, **values)
