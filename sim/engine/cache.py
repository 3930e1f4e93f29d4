"""Where compiled code is kept: a folder of its own that nobody else can write.

What lies there is run, so whoever could put a file into it would have code of his run.
"""

import atexit
import hashlib
import logging
import os
import shutil
import tempfile
from functools import cache
from pathlib import Path

from sim.base.additions import codes
from sim.base.errors import InputError
from sim.base.private import Unfit, caches, own_temporary, private_folder
from sim.engine.identity import COMPILED, source_hash

log = logging.getLogger("talus")

#: What plug-ins add that is compiled with the engine.
CODED_KINDS = ("law", "motion")

_NAME = "TALUS_CACHE_DIR"


def _plugged() -> str:
    """Return what tells the plug-ins that compiled code may hold, empty without any."""
    text = codes(*CODED_KINDS)
    return hashlib.sha256(text.encode()).hexdigest()[:12] if text else ""


def cache_directory(plugged: bool = True) -> Path:
    """Return the folder of compiled code for the present sources and plug-ins.

    Where ``plugged`` is false, that for the sources alone, for what no plug-in changes.

    ``TALUS_CACHE_DIR`` overrides the default ``~/.cache/talus`` (``XDG_CACHE_HOME`` is honoured);
    where the default cannot serve, a folder of this user under the system's temporary one does, and
    where that cannot either, one that is removed in the end.

    Raises
    ------
    InputError
        When the folder that is named is of somebody else, or others can write it.
    """
    name = "-".join(filter(None, (source_hash(COMPILED), _plugged() if plugged else "")))
    if named := os.environ.get(_NAME):
        try:
            return private_folder(Path(named) / name)
        except Unfit as error:
            allowed = "a folder of your own that only you can write"
            raise InputError(f"environment: {_NAME}: {error}; allowed: {allowed}") from None
        except OSError as error:
            return _temporary(name, f"{named}: {error.strerror or error}")
    try:
        return private_folder(caches() / "talus" / name)
    except (OSError, RuntimeError, Unfit) as error:
        return _temporary(name, str(error))


@cache
def _temporary(name: str, why: str) -> Path:
    """Return a folder under the system's temporary one, and warn once of what that means."""
    base = own_temporary()
    try:
        private_folder(base)
        path = private_folder(base / name)
    except (OSError, Unfit):
        path = Path(tempfile.mkdtemp(prefix="talus-"))
        atexit.register(shutil.rmtree, path, ignore_errors=True)
    log.warning("compiled code is kept in %s: %s", path, why)
    return path
