"""Talus: granular flow on a chute, belt or vibrating plane, from a study file to a report.

In Python: `simulate` runs one point, `Flow` runs one step by step, `points` lists the points of a
study, `study` runs one, and `load` reads its results (docs/api.md). Plug-ins extend it by
`law`, `motion`, `flow_engine`, `function`, `observable`, `form`, `plot_kind`, `fit`, `judge` and
`paper` (docs/extending.md).
"""

# ruff: noqa: F401

import os
from importlib.util import find_spec
from pkgutil import resolve_name
from typing import TYPE_CHECKING, Any

from sim.base.errors import InputError
from sim.base.program import __version__

# Files are written under names of their own and renamed, so HDF5's locks guard nothing; on a file
# system without locks it could neither write nor read. HDF5 reads this when it is imported.
os.environ.setdefault("HDF5_USE_FILE_LOCKING", "FALSE")

# A notebook hands its backend to commands, whose environment may lack it: no import of matplotlib.
_backend = os.environ.get("MPLBACKEND", "").partition("module://")[2]
if _backend and find_spec(_backend.partition(".")[0]) is None:
    del os.environ["MPLBACKEND"]

if TYPE_CHECKING:
    from sim.base.plugins import load_plugins
    from sim.claims.claim import judge
    from sim.engine.dynamics.cells import BlowUp
    from sim.engine.flow import Flow, simulate
    from sim.engine.impact import impact
    from sim.parameters.choices import parameter
    from sim.parameters.laws import flow_engine, law, motion
    from sim.parameters.observables import form, function, observable
    from sim.report.results import load, study
    from sim.study.load import points
    from sim.study.papers import paper
    from sim.study.plot_file import fit
    from sim.study.plottable import plot_kind

#: Name -> module and object, imported on first use: the engine takes half a second.
_PLACES = {
    "BlowUp": "sim.engine.dynamics.cells:BlowUp",
    "Flow": "sim.engine.flow:Flow",
    "fit": "sim.study.plot_file:fit",
    "flow_engine": "sim.parameters.laws:flow_engine",
    "impact": "sim.engine.impact:impact",
    "judge": "sim.claims.claim:judge",
    "law": "sim.parameters.laws:law",
    "load": "sim.report.results:load",
    "load_plugins": "sim.base.plugins:load_plugins",
    "motion": "sim.parameters.laws:motion",
    "form": "sim.parameters.observables:form",
    "function": "sim.parameters.observables:function",
    "observable": "sim.parameters.observables:observable",
    "paper": "sim.study.papers:paper",
    "parameter": "sim.parameters.choices:parameter",
    "plot_kind": "sim.study.plottable:plot_kind",
    "points": "sim.study.load:points",
    "simulate": "sim.engine.flow:simulate",
    "study": "sim.study",
}

__all__ = ["InputError", "__version__", *_PLACES]


def __getattr__(name: str) -> Any:
    if name not in _PLACES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = globals()[name] = resolve_name(_PLACES[name])
    return value


def __dir__() -> list[str]:
    return __all__
