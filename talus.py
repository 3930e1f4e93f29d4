"""Talus under its own name: ``import talus`` gives the package ``sim`` beside this file.

``python -m talus`` is the command ``talus``.
"""

import sys
from importlib.util import find_spec
from pathlib import Path

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

sys.modules[__name__] = sim
