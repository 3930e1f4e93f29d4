"""Contact laws as compiled code.

A law is a ``NamedTuple`` of its parameters and a body registered for the generic function of its
family. numba chooses the body by the tuple's type when a kernel is compiled, so particles, plane,
belt and obstacle share the law's code and no branch is left at run time.

The parameter ``law`` of the spheres names a law, of `sim.laws` or of a plug-in. Its ``make`` gives
the tuple. Its functions become bodies in `sim.engine.contact.functions`; the files beside that one
hold bodies that are compiled by hand.
"""

from typing import Any, NamedTuple

from sim.engine.compile import make_numbers
from sim.engine.contact.functions import add_law
from sim.parameters.laws import LAW
from sim.parameters.spheres import SphereParameters


class Partners(NamedTuple):
    """Properties of two partners that a law may use: ``friction`` μ, ``reduced_mass`` (kg), and
    the ``time_step`` (s) of the loop over steps."""

    friction: float
    reduced_mass: float
    time_step: float


def law_of(parameters: SphereParameters, partners: Partners) -> Any:
    """Return the law that a point names, for one kind of partners."""
    return make_numbers(LAW, parameters, add_law, parameters, partners)
