"""Parameters in words: each says which one it is."""

import pytest

from sim.parameters import SYSTEMS
from sim.parameters.words import setting


@pytest.mark.parametrize(
    ("system", "name", "words"),
    [
        ("belt", "corrections", "corrections = 2"),
        ("belt", "corrector_order", "corrector_order = 2"),
        ("belt", "prior_cycles", "t_0 = 2 cycles"),
        ("chute", "restitution", "e = 2"),
    ],
)
def test_a_parameter_without_a_symbol_goes_by_its_name(system, name, words):
    assert setting(system, name, 2) == words


def test_no_two_parameters_of_a_system_are_written_alike():
    for system, model in SYSTEMS.items():
        texts = {setting(system, name, 2) for name in model.model_fields}
        assert len(texts) == len(model.model_fields)
