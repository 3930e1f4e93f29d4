"""Any mapping is a point or an error of one line; a point keeps its values and its name."""

import math
import re

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from sim.base.errors import InputError
from sim.base.yaml import parse_yaml
from sim.parameters import (
    SYSTEMS,
    Parameters,
    canonical_json,
    canonical_number,
    canonical_values,
    parse_point,
    point_id,
)
from sim.study.model import estimate
from tests.properties.values import ANYTHING, GIVEN, SCALARS, allowed

NAMES = sorted({"system"}.union(*(model.model_fields for model in SYSTEMS.values())))
KEYS = st.one_of(st.sampled_from(NAMES), SCALARS)
AMOUNTS = {"replicates", "average", "limit", "target"}
JOINT_RULE = re.compile(
    r"allowed: (a run of at most|a value that gives|a divisor of"
    r"|at least (transient|sample_interval|3 bumps|bumps|twice the largest)|.*width - 3"
    r"|.* with (damping_mass|engine|integrator|law|shape): |a value that lets|0 or at "
    r"|false without a trajectory|\S+,? unless (law|engine|there|youngs_modulus|bump_arr)"
    r"|\S+,? which else stands|.*(with which its|when the) schedule ends|0, or a number >= 3"
    r"|below .* never leaves it|.*more steps_per_collision allow more|.*initial_state|.*overlaps)"
    # A given state makes the depth: that of its particles in the cell.
    r"|depth: got \S+; allowed: a number in"
)


def read(values: dict) -> Parameters:
    """The point of values each in its own range, unless a rule that joins several refuses it."""
    try:
        return parse_point(values, "point.yaml")
    except InputError as error:
        assert JOINT_RULE.search(str(error)), error
        assume(False)


POINTS = GIVEN.map(read)


def refusal(values) -> str:
    """The message with which ``values`` are refused as a point, or an empty text."""
    try:
        parse_point(values, "point.yaml")
    except InputError as error:
        return str(error)
    return ""


@given(ANYTHING)
def test_anything_but_a_point_is_refused_in_one_line(value):
    message = refusal(value)
    assert message.startswith("point.yaml: ") and message.isprintable()
    assert len(message) < 1000


@given(GIVEN, st.dictionaries(KEYS, ANYTHING, max_size=3))
def test_a_point_with_anything_in_it_is_read_or_refused_in_one_line(values, changes):
    message = refusal(values | changes)
    assert not message or (message.startswith("point.yaml: ") and message.isprintable())
    assert len(message) < 1000


@pytest.mark.parametrize("key", ["seed", "depth", "system", "orientations"])
def test_integers_too_long_to_be_written_are_refused_in_one_line(key):
    message = refusal({"system": "chute", key: 10**5000})
    assert message.startswith(f"point.yaml: {key}: got an integer of 16610 bits; allowed: ")


@pytest.mark.parametrize("bumps", [1e-3, 1e-160, 1e-310])
def test_bumps_too_small_to_be_counted_are_refused(bumps):
    assert f"point.yaml: bumps: got {bumps}; allowed" in refusal(
        {"system": "chute", "bumps": bumps, "cell": 100}
    )


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_canonical_numbers_are_fixed_points(value):
    rounded = canonical_number(value)
    assert canonical_number(rounded) == rounded
    assert rounded == pytest.approx(value, rel=1e-11)


@given(POINTS)
def test_the_canonical_form_is_a_fixed_point(point):
    values = canonical_values(point)
    again = parse_point(values, "point.yaml")
    assert again == point and canonical_values(again) == values
    assert canonical_json(again) == canonical_json(point)
    assert parse_point(parse_yaml(canonical_json(point), "point.yaml"), "point.yaml") == point


@given(POINTS)
def test_the_defaults_that_a_point_takes_are_its_own_if_given(point):
    rest = canonical_values(point)
    model = type(point)
    omitted = {"system": rest["system"]} | {
        name: value for name, value in rest.items() if name in point.model_fields_set
    }
    assert parse_point(omitted, "p") == parse_point(rest, "p") == model(**rest)


@given(POINTS)
def test_ids_are_safe_names_of_files(point):
    name = point_id(point)
    assert re.fullmatch(rf"{point.system}-[a-z0-9._-]+-[0-9a-f]{{8}}", name)
    assert len(name) < 180
    assert point_id(parse_point(canonical_values(point), "p")) == name


def without_amounts(point: Parameters) -> Parameters:
    """Return a point with all amounts at their defaults."""
    fields = type(point).model_fields
    return point.model_copy(update={name: fields[name].default for name in AMOUNTS & fields.keys()})


@given(POINTS, POINTS)
def test_points_have_one_id_if_they_are_equal_but_for_amounts(one, other):
    equal = without_amounts(one) == without_amounts(other)
    assert (point_id(one) == point_id(other)) == equal


@given(POINTS, st.data())
def test_a_change_of_any_parameter_but_an_amount_changes_the_id(point, data):
    name = data.draw(st.sampled_from(sorted(type(point).model_fields)).filter("system".__ne__))
    value = data.draw(allowed(type(point).model_fields[name]))
    changed = read(canonical_values(point) | {name: value})
    assert (point_id(changed) == point_id(point)) == (name in AMOUNTS or changed == point)


@given(POINTS)
def test_all_that_follows_from_a_point_is_finite(point):
    for name in ("time_unit", "time_step", "velocity_unit"):
        assert 0 < getattr(point, name) < math.inf
    assert 1 <= point.sample_steps <= point.steps <= 1.1e12
    assert 1 <= point.average_samples <= point.shortest_samples <= point.longest_samples
    assert point.longest_samples * point.sample_steps == point.steps
    cost = estimate(point)
    assert cost.steps >= point.steps and 0 < cost.core_seconds < math.inf and cost.memory > 0
    assert isinstance(point.caveat, str)


@pytest.mark.parametrize("system", SYSTEMS)
@given(data=st.data())
def test_the_ends_of_a_range_divide_the_read_from_the_refused(system, data):
    fields = SYSTEMS[system].model_fields
    name = data.draw(st.sampled_from([n for n in sorted(fields) if fields[n].annotation is float]))
    value = data.draw(st.floats())
    message = refusal({"system": system, name: value})
    lowest = min(getattr(bound, "gt", getattr(bound, "ge", 0)) for bound in fields[name].metadata)
    if not lowest <= value <= 1e15:
        assert message.startswith(f"point.yaml: {name}: got ")
