"""What the program is called, for usage and messages, and its version."""

import sys
from pathlib import Path

__version__ = "0.1.0"


def program() -> str:
    """Return how this process was called: by the installed command or as a module."""
    return "talus" if Path(sys.argv[0]).stem == "talus" else "python -m sim"
