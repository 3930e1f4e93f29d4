"""Contact laws: one file per law.

A law is a ``NamedTuple`` of its parameters and a body registered for the generic function of its
family. numba chooses the body by the tuple's type when a kernel is compiled, so particles, plane,
belt and obstacle share the law's code and no branch is left at run time.

The parameter ``law`` of the spheres names a module of this folder, whose ``from_parameters`` makes
the law of a point for one kind of partners, or a law of a plug-in (`sim.engine.contact.own`).
"""

from importlib import import_module
from typing import NamedTuple

from sim.parameters.laws import LAW
from sim.parameters.spheres import SphereParameters


class Partners(NamedTuple):
    """Properties of two partners that a law may use: ``friction`` μ, ``reduced_mass`` (kg), and
    the ``time_step`` (s) of the loop over steps."""

    friction: float
    reduced_mass: float
    time_step: float


def law_of(parameters: SphereParameters, partners: Partners) -> NamedTuple:
    """Return the law that a point names, for one kind of partners."""
    if LAW.is_own(parameters.law):
        from sim.engine.contact.own import add_law
        from sim.engine.plugin_types import make_numbers

        return make_numbers(LAW, parameters.law, add_law, parameters, partners)
    return import_module(f"{__name__}.{parameters.law}").from_parameters(parameters, partners)
