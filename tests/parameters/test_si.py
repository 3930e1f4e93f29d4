"""Parameters in SI."""

import pytest

from sim.parameters import in_si, parse_point


def test_values_in_si_are_multiples_of_what_the_parameter_says():
    point = parse_point({"system": "belt", "damping": 50, "frequency": 20}, "point")
    quantities = in_si(point)
    assert quantities["damping"] == (500, "s-1") and quantities["stiffness"] == (
        pytest.approx(10),
        "N m-1",
    )
    assert quantities["average"] == (45 / 20, "s") and quantities["frequency"] == (20, "Hz")
    assert not {"prior_cycles", "overlap_limit", "beads", "seed"} & set(quantities)
    chute = in_si(parse_point({"system": "chute", "cell": 5}, "point"))
    assert chute["cell"] == (pytest.approx(5e-3), "m") and chute["angle"].unit == "degree"
    assert chute["stiffness"] == (100, "N m-1")
