"""Given states: one point for one content."""

import pytest

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
