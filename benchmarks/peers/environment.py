"""The environment of the peer: LAMMPS of a fixed version, apart from the project's own."""

import logging
import subprocess
import sys
from pathlib import Path

log = logging.getLogger(__name__)

PACKAGES = ["lammps[mpi]==2025.7.22.4.0", "mpich==5.0.2", "numpy"]
FOLDER = Path(__file__).parent / ".env"
CACHE = Path(__file__).parent / ".cache"


def peer_python(folder: Path = FOLDER) -> Path:
    """Return the interpreter of the environment in this folder; create what is missing."""
    python = folder / "bin" / "python"
    done = folder / "installed.txt"
    if not done.exists() or done.read_text().split() != PACKAGES:
        log.info("setting up %s: %s", folder, ", ".join(PACKAGES))
        subprocess.run([sys.executable, "-m", "venv", str(folder)], check=True)
        subprocess.run([python, "-m", "pip", "install", "--quiet", *PACKAGES], check=True)
        done.write_text("\n".join(PACKAGES))
    return python
