"""Roles and words of parameters fit together, points keep their ids, messages stay short."""

import csv
import json
from pathlib import Path

import pytest

from sim.base.errors import InputError
from sim.base.messages import MOST_NAMES, names_meant, near
from sim.parameters import NUMERICAL, SYSTEMS, field_info, parse_point, point_id
from sim.parameters.laws import FunctionParameters
from sim.parameters.points import all_synonyms
from sim.parameters.roles import (
    TABLE,
    added_parameters,
    declarations,
    id_parts,
    numerical_parameters,
    reading_parameters,
    start_parameters,
)
from sim.study.plot_file import PlotFile
from sim.study.plottable import every_name, study_kinds

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
    names = {name for model in models for name in (*model.model_fields, *model.in_place)}
    with TABLE.open(encoding="utf-8") as file:
        assert {row["name"] for row in csv.DictReader(file)} == names
    *choices, ratio, exponent = reading_parameters(SYSTEMS["chute"])
    assert choices == ["law", "overlap_memory", "friction_cap", "sliding_direction"]
    assert (ratio, exponent) == ("tangential_ratio", "tangential_exponent")


PARAMETERS = {name for one in SYSTEMS.values() for name in (*one.model_fields, *one.in_place)}
NAMES = {*PARAMETERS, *every_name(), *study_kinds(), *PlotFile.model_fields}


def test_synonyms_and_symbols_stand_for_names():
    synonyms = all_synonyms()
    assert "friction" in synonyms and set(synonyms) <= NAMES
    assert not PARAMETERS & {word for words in synonyms.values() for word in words.split()}
    for model in SYSTEMS.values():
        for name, row in field_info(model).items():
            if row.symbol:
                assert name in names_meant(row.symbol, model.model_fields), row.symbol


@pytest.mark.parametrize(
    ("word", "name"),
    [
        *(("mu", "friction"), ("\N{MICRO SIGN}", "friction"), ("mu_p", "friction_plane")),
        *(("e", "restitution"), ("theta", "angle"), ("f", "frequency"), ("Speed", "velocity")),
        *(("heatmap", "map"), ("color", "colour"), ("repeats", "replicates")),
    ],
)
def test_words_are_found_however_they_are_spelled(word, name):
    assert name in names_meant(word, NAMES)


@pytest.mark.parametrize("system", SYSTEMS)
@pytest.mark.parametrize("key", ["mu", "restitutoin", "nothing_like_it", "s"])
def test_no_error_of_a_key_lists_more_than_twelve_names(system, key):
    with pytest.raises(InputError) as refused:
        parse_point({"system": system, key: 1}, "point")
    assert str(refused.value).count(", ") <= MOST_NAMES
    assert near(key, list(map(str, range(MOST_NAMES)))).count(", ") == MOST_NAMES - 1
