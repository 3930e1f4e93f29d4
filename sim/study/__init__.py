"""From a study file to its points, its boundaries and what its figures need.

Called, as `talus.study`, the package runs one: see `sim.report.results.study`.
"""

import sys
from pkgutil import resolve_name
from types import ModuleType
from typing import Any


class _Study(ModuleType):
    """A package with the name of a function that users call."""

    def __call__(self, *args: Any, **options: Any) -> Any:
        return resolve_name("sim.report.results:study")(*args, **options)


sys.modules[__name__].__class__ = _Study
