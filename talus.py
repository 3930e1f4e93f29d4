"""Talus under its own name: ``import talus`` gives the package ``sim`` beside this file.

``python -m talus`` is the command ``talus``.
"""

import sys
from pathlib import Path

import sim

if Path(sim.__file__ or "").parent != Path(__file__).with_name("sim"):
    raise ImportError(
        f"{sim.__file__ or list(sim.__path__)}: another package is called sim and hides that of "
        "Talus; rename it, or start Python in another folder"
    )

if __name__ == "__main__":
    from sim.__main__ import main

    sys.exit(main())

sys.modules[__name__] = sim
