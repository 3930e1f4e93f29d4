"""Roles of parameters fit together, and points keep their ids."""

import csv
import json
from pathlib import Path

import pytest

from sim.parameters import NUMERICAL, SYSTEMS, parse_point, point_id
from sim.parameters.laws import FunctionParameters
from sim.parameters.roles import (
    TABLE,
    added_parameters,
    declarations,
    id_parts,
    numerical_parameters,
    reading_parameters,
    start_parameters,
)

STORED_IDS = json.loads(Path(__file__).with_name("ids.json").read_text(encoding="utf-8"))


@pytest.mark.parametrize(("values", "name"), STORED_IDS, ids=[name for _, name in STORED_IDS])
def test_points_keep_their_ids(values, name):
    assert point_id(parse_point(values, "point")) == name


@pytest.mark.parametrize("model", SYSTEMS.values())
def test_roles_fit_together(model):
    numerical = numerical_parameters(model)
    # A name has one role in all systems.
    assert set(model.model_fields) & NUMERICAL == numerical >= set(start_parameters(model))
    assert not {*id_parts(model), *reading_parameters(model)} & numerical
    assert len(set(id_parts(model).values())) == len(id_parts(model))
    assert not set(added_parameters(model)) & {*id_parts(model), "system"}
    assert not any(model.model_fields[name].default_factory for name in added_parameters(model))
    assert set(model.smallest_values) <= set(declarations(model))
    assert model(**model.smallest_values).particles <= 5


def test_every_row_of_the_table_is_a_parameter_and_readings_are_told_choices_first():
    models = (*SYSTEMS.values(), FunctionParameters)
    names = {name for model in models for name in model.model_fields}
    with TABLE.open(encoding="utf-8") as file:
        assert {row["name"] for row in csv.DictReader(file)} == names
    *choices, ratio, exponent = reading_parameters(SYSTEMS["chute"])
    assert choices == ["law", "overlap_memory", "friction_cap", "sliding_direction"]
    assert (ratio, exponent) == ("tangential_ratio", "tangential_exponent")
