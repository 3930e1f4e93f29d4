"""Parameters: defaults of the papers, ranges, canonical values, ids, SI properties."""

import json
import math
import re
import subprocess
import sys
from pathlib import Path

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from pydantic import ValidationError

from sim.errors import InputError
from sim.parameters import (
    SYSTEMS,
    BeltParameters,
    ChuteParameters,
    canonical,
    canonical_number,
    field_info,
    load_point,
    parse_point,
    point_id,
)

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
}

REFUSED = [
    ("chute", "depth", 0, "> 0"),
    ("chute", "depth", -1, "> 0"),
    ("chute", "friction", -0.1, ">= 0"),
    ("chute", "friction_plane", -0.1, ">= 0"),
    ("chute", "restitution", 0, "(0, 1]"),
    ("chute", "restitution", 1.01, "(0, 1]"),
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
    ("belt", "frequency", 0, "> 0"),
    ("belt", "vibration_angle", 0, "(0, 90]"),
    ("belt", "vibration_angle", 90.5, "(0, 90]"),
    ("belt", "damping", -1, ">= 0"),
    ("belt", "obstacle", 17, "[0, 17)"),
    ("belt", "beads", 0, "an integer"),
    ("belt", "samples_per_cycle", 30, "divisor of steps_per_cycle = 2000"),
    ("belt", "phase", 360, "[0, 360)"),
    ("belt", "integrator", "euler", "'gear' or 'verlet'"),
]


@pytest.mark.parametrize(("system", "published"), [("chute", WALTON), ("belt", GALLAS)])
def test_omitted_parameters_have_the_papers_values(system, published):
    values = canonical(parse_point({"system": system}, "point.yaml"))
    assert {name: values[name] for name in published} == pytest.approx(published)


@pytest.mark.parametrize(("system", "key", "value", "allowed"), REFUSED)
def test_refusals_name_file_key_and_range(system, key, value, allowed):
    with pytest.raises(InputError) as caught:
        parse_point({"system": system, key: value}, "point.yaml")
    message = str(caught.value)
    assert message.startswith(f"point.yaml: {key}: got ")
    assert allowed in message.partition("allowed: ")[2]
    assert "\n" not in message
    assert len(message) < 300


def test_a_run_too_long_for_its_samples_is_refused():
    with pytest.raises(InputError, match=r"sample_interval: got 0.25; .* at most 1e\+07 samples"):
        parse_point({"system": "chute", "average": 1e7}, "point.yaml")


@pytest.mark.parametrize(
    ("given_values", "boundary"),
    [
        ({"system": "chute"}, {"restitution": 1}),
        ({"system": "chute"}, {"restitution": 1e-9}),
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
def test_boundaries_that_belong_to_the_range_are_accepted(given_values, boundary):
    parameters = parse_point(given_values | boundary, "point.yaml")
    assert all(getattr(parameters, name) == value for name, value in boundary.items())


def test_unknown_key_suggests_the_nearest():
    with pytest.raises(InputError, match=r"restituton: unknown key, got 0.8; did you mean 'resti"):
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


def test_defaults_that_follow_other_parameters():
    assert ChuteParameters(friction=0.2).friction_plane == 0.2
    assert ChuteParameters(friction=0.2, friction_plane=0.6).friction_plane == 0.6
    assert [ChuteParameters(depth=depth).cell for depth in (1, 10, 10.5, 40)] == [10, 10, 5, 5]
    assert ChuteParameters(depth=40).initial_velocity == 30
    assert ChuteParameters(depth=2.5).initial_velocity == 7


def test_a_follower_given_explicitly_is_the_same_point():
    assert point_id(ChuteParameters(friction_plane=0.4)) == point_id(ChuteParameters())


def test_natural_units_of_the_chute():
    chute = ChuteParameters()
    assert chute.time_unit == pytest.approx(10.10e-3, rel=1e-3)
    assert chute.velocity_unit == pytest.approx(0.0990, rel=1e-3)
    assert chute.particles == 500
    assert chute.steps_per_collision * chute.time_step == pytest.approx(
        math.pi / 2 * math.sqrt(1.492e-6 / 2 / 100) * 1.85
    )


def test_lengths_of_a_chute_run():
    chute = ChuteParameters(transient=10, average=5)
    interval = chute.sample_steps * chute.time_step
    assert interval == pytest.approx(0.25 * chute.time_unit, rel=0.01)
    assert chute.transient_samples * interval == pytest.approx(10 * chute.time_unit, rel=0.02)
    assert chute.average_samples * interval == pytest.approx(5 * chute.time_unit, rel=0.02)
    assert chute.steps == (chute.transient_samples + chute.average_samples) * chute.sample_steps


def test_lengths_of_a_belt_run_are_the_papers():
    belt = BeltParameters()
    assert belt.time_step == pytest.approx(1 / (2000 * 20))
    assert belt.transient_samples * belt.sample_steps == 90_000
    assert belt.average_samples * belt.sample_steps == 90_000
    assert belt.steps == 180_000


def test_the_shortest_run_has_a_sample_and_the_smallest_cell_a_particle():
    chute = ChuteParameters(depth=1e-6, transient=0, average=1e-6)
    assert (chute.particles, chute.transient_samples, chute.average_samples) == (1, 0, 1)


def test_parameters_are_immutable():
    with pytest.raises(ValidationError, match="frozen"):
        ChuteParameters().depth = 10


def test_equal_numbers_are_one_point():
    pairs = [(0.1 + 0.2, 0.3), (0.7 * 0.5, 0.35), (1, 1.0), (4e-1, 0.4)]
    for one, other in pairs:
        assert point_id(ChuteParameters(friction=one)) == point_id(ChuteParameters(friction=other))


def test_minus_zero_is_zero():
    assert math.copysign(1, ChuteParameters(friction=-0.0).friction) == 1


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_canonical_numbers_are_fixed_points(value):
    rounded = canonical_number(value)
    assert canonical_number(rounded) == rounded
    assert rounded == pytest.approx(value, rel=1e-11)


CHUTES = st.builds(
    ChuteParameters,
    depth=st.floats(0.01, 100),
    friction=st.floats(0, 10),
    restitution=st.floats(1e-3, 1),
    stiffness=st.floats(1, 1e6),
    angle=st.floats(0, 89),
    seed=st.integers(0, 1000),
    orientations=st.booleans(),
    overlap_memory=st.sampled_from(["separation", "shrink", "reset"]),
)
BELTS = st.builds(
    BeltParameters,
    frequency=st.floats(1, 1000),
    amplitude=st.floats(0, 10),
    vibration_angle=st.floats(0.1, 90),
    damping=st.floats(0, 1000),
    shear_damping=st.floats(0, 1000),
    integrator=st.sampled_from(["gear", "verlet"]),
)
POINTS = st.one_of(CHUTES, BELTS)


@settings(deadline=None)
@given(POINTS)
def test_the_canonical_form_makes_the_same_point(point):
    assert parse_point(canonical(point), "point.yaml") == point


@settings(deadline=None, max_examples=50)
@given(point=POINTS)
def test_json_is_a_point_file(tmp_path_factory, point):
    path = tmp_path_factory.mktemp("points") / "point.json"
    path.write_text(json.dumps(canonical(point)))
    assert point_id(load_point(path)) == point_id(point)


@settings(deadline=None)
@given(POINTS)
def test_ids_are_fit_for_file_names(point):
    name = point_id(point)
    assert re.fullmatch(rf"{point.system}(-[a-z]+[0-9.e-]+){{4,5}}[-a-z_0-9.]*-[0-9a-f]{{8}}", name)
    assert len(name) < 180


def test_ids_show_what_differs_from_the_paper_and_hide_what_is_numerical():
    steep = point_id(ChuteParameters(angle=18, transient=10, friction_plane=0.3))
    assert re.fullmatch(r"chute-.*-stiffness100-friction_plane0.3-angle18-[0-9a-f]{8}", steep)
    verlet = point_id(BeltParameters(integrator="verlet", steps_per_cycle=4000))
    assert re.fullmatch(r"belt-.*-shear50-integrator-verlet-[0-9a-f]{8}", verlet)


@settings(deadline=None)
@given(POINTS, POINTS)
def test_different_points_have_different_ids(one, other):
    assume(one != other)
    assert point_id(one) != point_id(other)


@pytest.mark.parametrize("system", SYSTEMS)
def test_every_parameter_is_in_the_id(system):
    changed = {
        "seed": 2,
        "replicates": 2,
        "orientations": False,
        "beads": 201,
        "threads": 2,
        "steps_per_collision": 41,
        "steps_per_cycle": 2020,
        "samples_per_cycle": 10,
    }
    default = SYSTEMS[system]()
    for name, row in field_info(default).items():
        if name == "system":
            continue
        value = getattr(default, name)
        if isinstance(value, str):
            new = re.findall(r"\w+", row.allowed)[-1]
        else:
            new = changed.get(name, 0.9 * value if value else 0.5)
        point = parse_point({"system": system, name: new}, "point.yaml")
        assert point_id(point) != point_id(default), name


def test_ids_read_well():
    chute = point_id(ChuteParameters(depth=1.24, restitution=0.7))
    assert chute.startswith("chute-depth1.24-friction0.4-restitution0.7-stiffness100-")
    belt = point_id(BeltParameters(frequency=15.5, shear_damping=100))
    assert belt.startswith("belt-frequency15.5-amplitude1-angle45-damping50-shear100-")


@pytest.mark.parametrize("model", SYSTEMS.values())
def test_every_parameter_is_described(model):
    rows = field_info(model)
    assert set(rows) == set(model.model_fields)
    assert next(iter(rows)) == "system"
    for row in rows.values():
        assert row.description and not row.description.endswith("."), row.name
        assert row.allowed, row.name
        number = isinstance(getattr(model(), row.name), float)
        assert bool(row.unit) or not number, row.name


@pytest.mark.parametrize(
    ("text", "depth"),
    [
        ("system: chute\ndepth: 1e1\n", 10),
        ("system: chute\ndepth: 2.5E+1\n", 25),
        ("system: chute\ndepth: .5\n", 0.5),
        ("{'system': 'chute', 'depth': 1_0}", None),
        ("system: chute\ndepth: 010\n", 10),
        ("system: chute\ndepth: 1:30\n", None),
        ("system: chute\ndepth: yes\n", None),
    ],
)
def test_numbers_are_read_by_yaml_1_2(tmp_path, text, depth):
    path = tmp_path / "point.yaml"
    path.write_text(text)
    if depth is None:
        with pytest.raises(InputError, match=r"depth: got '.*'; allowed: a number > 0"):
            load_point(path)
    else:
        assert load_point(path).depth == depth


def test_anchors_and_merge_keys_are_no_duplicates(tmp_path):
    path = tmp_path / "point.yaml"
    path.write_text("<<: &base {system: chute, depth: 2}\ndepth: 3\n")
    assert load_point(path).depth == 3


def test_parameters_and_command_line_import_nothing_heavy():
    code = (
        "import sys, sim.cli, sim.parameters, sim.study, sim.tables\n"
        "heavy = {'numba', 'xarray', 'pandas', 'matplotlib', 'scipy', 'dask', 'snakemake'}\n"
        "sys.exit(' '.join(heavy & set(sys.modules)) or 0)"
    )
    root = Path(__file__).parents[1]
    done = subprocess.run([sys.executable, "-c", code], cwd=root, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
