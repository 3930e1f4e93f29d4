"""Talus under its own name: ``import talus`` gives the package ``sim`` beside this file.

Its modules have that name, too: ``talus.claims.checks`` is ``sim.claims.checks``. ``python -m
talus`` is the command ``talus``.
"""

import sys
from collections.abc import Sequence
from importlib import import_module
from importlib.machinery import ModuleSpec
from importlib.util import find_spec, spec_from_loader
from pathlib import Path
from types import ModuleType

place = find_spec("sim")
if place is None or Path(place.origin or "").parent != Path(__file__).with_name("sim"):
    name = place and (place.origin or list(place.submodule_search_locations or ()))
    raise ImportError(
        f"{name}: another package is called sim and hides that of Talus; rename it, or start "
        "Python in another folder"
    )

import sim  # noqa: E402

if __name__ == "__main__":
    from sim.__main__ import main

    sys.exit(main())


class SameModules:
    """Finder and loader of ``talus.X``, which is the module ``sim.X`` and not a second copy."""

    def find_spec(
        self, name: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        return spec_from_loader(name, self) if name.startswith("talus.") else None

    def create_module(self, spec: ModuleSpec) -> ModuleType:
        module = import_module(f"sim{spec.name.removeprefix('talus')}")
        spec.loader_state = module.__spec__
        return module

    def exec_module(self, module: ModuleType) -> None:
        # The import system has replaced it by the one of the other name.
        if module.__spec__ is not None:
            module.__spec__ = module.__spec__.loader_state


sys.meta_path.insert(0, SameModules())
sys.modules[__name__] = sim
