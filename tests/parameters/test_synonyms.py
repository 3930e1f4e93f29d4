"""Words for names: symbols, synonyms, and messages that stay short."""

import pytest

from sim.base.errors import InputError
from sim.base.messages import MOST_NAMES, names_meant, near
from sim.parameters import SYSTEMS, field_info, parse_point
from sim.parameters.points import all_synonyms
from sim.study.plot_file import PlotFile
from sim.study.plottable import every_name, study_kinds

PARAMETERS = {name for model in SYSTEMS.values() for name in model.model_fields}
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
