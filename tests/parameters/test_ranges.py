"""Defaults of the papers, ranges, and refusals that name file, key and range."""

import pytest

from sim.parameters import complete_values, parse_point

WALTON = {
    "depth": 5,
    "friction": 0.4,
    "friction_plane": 0.4,
    "restitution": 0.85,
    "stiffness": 100,
    "tangential_ratio": 0.8,
    "angle": 17,
    "cell": 10,
    "diameter": 1e-3,
    "mass": 1.492e-6,
    "gravity": 9.8,
    "steps_per_collision": 40,
    "overlap_memory": "separation",
    "friction_cap": "before",
    "sliding_direction": "printed",
}


GALLAS = {
    "frequency": 20,
    "amplitude": 1,
    "vibration_angle": 45,
    "damping": 50,
    "shear_damping": 50,
    "stiffness": 1000,
    "beads": 200,
    "width": 20,
    "obstacle": 0,
    "diameter": 1e-3,
    "diameter_spread": 0.5,
    "gravity": 10,
    "steps_per_cycle": 2000,
    "transient": 45,
    "average": 45,
    "settle_velocity_squared": 1e-8,
    "damping_mass": "own",
    "belt_ghost": "below",
    "attraction": "kept",
    "integrator": "gear",
    "corrector_order": 5,
    "corrections": 1,
    "ghost_mass": "infinite",
    "stiffness_keeps": "damping",
}


@pytest.mark.parametrize(("system", "paper_values"), [("chute", WALTON), ("belt", GALLAS)])
def test_omitted_parameters_have_the_papers_values(system, paper_values):
    values = complete_values(parse_point({"system": system}, "point.yaml"))
    assert {name: values[name] for name in paper_values} == pytest.approx(paper_values)


@pytest.mark.parametrize(
    ("values", "boundary"),
    [
        ({"system": "chute"}, {"restitution": 1}),
        ({"system": "chute"}, {"restitution": 0.001}),
        ({"system": "chute"}, {"angle": 0}),
        ({"system": "chute"}, {"angle": 89.999}),
        ({"system": "chute"}, {"friction": 0}),
        ({"system": "chute"}, {"depth": 0.01}),
        ({"system": "belt"}, {"vibration_angle": 90}),
        ({"system": "belt"}, {"obstacle": 16.999}),
        ({"system": "belt"}, {"damping": 0, "shear_damping": 0}),
        ({"system": "belt"}, {"beads": 1}),
    ],
)
def test_boundaries_that_belong_to_the_range_are_accepted(values, boundary):
    parameters = parse_point(values | boundary, "point.yaml")
    assert all(getattr(parameters, name) == value for name, value in boundary.items())
