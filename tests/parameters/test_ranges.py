"""Defaults of the papers, ranges, and refusals that name file, key and range."""

import math

import pytest

from sim.base.errors import InputError
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


REFUSALS = [
    ("chute", "average", 0.2, "at least sample_interval = 0.25"),
    ("chute", "depth", 0, "> 0"),
    ("chute", "depth", -1, "> 0"),
    ("chute", "friction", -0.1, ">= 0"),
    ("chute", "friction_plane", -0.1, ">= 0"),
    ("chute", "restitution", 0, "[0.001, 1]"),
    ("chute", "restitution", 1.01, "[0.001, 1]"),
    ("chute", "stiffness", 0, "> 0"),
    ("chute", "stiffness", -100, "> 0"),
    ("chute", "angle", -1, "[0, 90)"),
    ("chute", "angle", 90, "[0, 90)"),
    ("chute", "angle", 90 - 1e-13, "[0, 90)"),
    ("chute", "cell", 2.9, ">= 3"),
    ("chute", "initial_packing", 0.36, "[0.001, 0.35]"),
    ("chute", "steps_per_collision", 9, "[10, 1000]"),
    ("chute", "overlap_memory", "for ever", "'separation', 'shrink' or 'reset'"),
    ("chute", "orientations", "yes", "true or false"),
    ("chute", "orientations", 1, "true or false"),
    ("chute", "depth", "five", "a number"),
    ("chute", "depth", "5", "a number"),
    ("chute", "depth", True, "a number"),
    ("chute", "depth", None, "a number"),
    ("chute", "depth", [5], "a number"),
    ("chute", "depth", math.nan, "finite"),
    ("chute", "depth", math.inf, "finite"),
    ("chute", "depth", 10**400, "a number"),
    ("chute", "depth", 1e9, "at most 1e+07 particles"),
    ("chute", "depth", 1e300, "[1e-15, 1e+15]"),
    ("chute", "replicates", 0, "[1, 1000]"),
    ("chute", "replicates", 2.5, "an integer"),
    ("chute", "replicates", True, "an integer"),
    ("chute", "seed", -1, "an integer in [0"),
    ("chute", "average", 0, "> 0"),
    ("chute", "average", 1e12, "at most 1e+12 time steps"),
    ("chute", "transient", 1e12, "at most 1e+12 time steps"),
    ("belt", "frequency", 0, "> 0"),
    ("belt", "vibration_angle", 0, "(0, 90]"),
    ("belt", "vibration_angle", 90.5, "(0, 90]"),
    ("belt", "damping", -1, ">= 0"),
    ("belt", "obstacle", 17, "[0, 17)"),
    ("belt", "beads", 0, "an integer"),
    ("belt", "samples_per_cycle", 30, "divisor of steps_per_cycle = 2000"),
    ("belt", "phase", 360, "[0, 360)"),
    ("belt", "integrator", "euler", "'gear' or 'verlet'"),
    ("belt", "ghost_mass", "mean", "'infinite' with damping_mass: own"),
    ("belt", "corrector_order", 6, "[3, 5]"),
    ("belt", "corrections", 3, "[1, 2]"),
    ("belt", "slice_height", 0.05, "[0.1, 10]"),
]


@pytest.mark.parametrize(("system", "paper_values"), [("chute", WALTON), ("belt", GALLAS)])
def test_omitted_parameters_have_the_papers_values(system, paper_values):
    values = complete_values(parse_point({"system": system}, "point.yaml"))
    assert {name: values[name] for name in paper_values} == pytest.approx(paper_values)


@pytest.mark.parametrize(("system", "key", "value", "allowed"), REFUSALS)
def test_refusals_name_file_key_and_range(system, key, value, allowed):
    with pytest.raises(InputError) as caught:
        parse_point({"system": system, key: value}, "point.yaml")
    message = str(caught.value)
    assert message.startswith(f"point.yaml: {key}: got ")
    assert allowed in message.partition("allowed: ")[2]
    assert "\n" not in message
    assert len(message) < 300


@pytest.mark.parametrize(("key", "value"), [("corrector_order", 4), ("corrections", 2)])
def test_verlet_has_no_corrector(key, value):
    with pytest.raises(InputError, match=rf"{key}: got {value}; .* with integrator: verlet"):
        parse_point({"system": "belt", "integrator": "verlet", key: value}, "point.yaml")


def test_a_run_too_long_for_its_samples_is_refused():
    with pytest.raises(InputError, match=r"sample_interval: got 0.25; .* at most 1e\+07 samples"):
        parse_point({"system": "chute", "average": 1e7}, "point.yaml")


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


def test_unknown_key_suggests_the_nearest():
    with pytest.raises(InputError, match=r"restituton: unknown key, got 0.8; did you mean resti"):
        parse_point({"system": "chute", "restituton": 0.8}, "point.yaml")


def test_a_parameter_of_the_other_system_is_unknown():
    with pytest.raises(InputError, match="frequency: unknown key"):
        parse_point({"system": "chute", "frequency": 20}, "point.yaml")


@pytest.mark.parametrize("mapping", [{}, {"system": "drum"}, {"system": ["chute"]}, {"system": 1}])
def test_system_is_required(mapping):
    with pytest.raises(InputError, match=r"system: got .*; allowed: one of chute, belt"):
        parse_point(mapping, "point.yaml")


@pytest.mark.parametrize("contents", [[1, 2], "chute", 5, None])
def test_a_point_is_a_mapping(contents):
    with pytest.raises(InputError, match=r"point.yaml: got .*; allowed: a mapping"):
        parse_point(contents, "point.yaml")
