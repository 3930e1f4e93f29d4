"""The law that a point names is that of the file of its name, for whichever partners."""

from typing import get_args

import pytest

from sim.base.additions import shipped
from sim.engine.contact import Partners, law_of
from sim.engine.systems import build
from sim.parameters import ChuteParameters

NAMES = get_args(ChuteParameters.model_fields["law"].annotation)
PARTNERS = Partners(friction=0.3, reduced_mass=1e-6, time_step=1e-6)


@pytest.mark.parametrize("name", NAMES)
def test_every_law_that_a_point_may_name_has_a_file_that_makes_it(name):
    law = law_of(ChuteParameters(law=name, stiffness=250.0), PARTNERS)
    assert type(law).__module__.rpartition(".")[2] == name
    # Hertz's law has a modulus in place of a stiffness, and drags have no friction.
    assert (250.0 in law) == (name != "hertz")
    assert ("friction=0.3" in repr(law)) == (name != "drag")


def test_the_laws_that_ship_are_those_of_the_files():
    assert set(shipped("law")) == set(NAMES)


@pytest.mark.parametrize(
    ("name", "numbers"), [("walton_braun", 7), ("spring_dashpot", 4), ("hertz", 4), ("drag", 5)]
)
def test_contacts_keep_as_many_numbers_as_their_law_says(name, numbers):
    system = build(ChuteParameters(law=name, depth=1, cell=4), 0)
    assert system.memory.shape[:2] == system.plane.memory.shape[:2] == (2, numbers)
