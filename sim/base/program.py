"""Name of the program, for usage and messages, and its version."""

import sys
from pathlib import Path

__version__ = "0.1.0"


def program() -> str:
    """Return the command that started this process: ``talus`` or ``python -m sim``."""
    return "talus" if Path(sys.argv[0]).stem == "talus" else "python -m sim"
