"""The folder of compiled code, which nobody but the user can write.

Its files are executed: anybody who could write there could run code as the user.
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
from sim.base.files import NotPrivateError, cache_folder, private_folder, user_temporary_folder
from sim.engine.identity import COMPILED_PARTS, source_hash

log = logging.getLogger("talus")

#: Kinds of additions by plug-ins that are compiled with the engine.
COMPILED_KINDS = ("law", "motion")

_VARIABLE = "TALUS_CACHE_DIR"


def _plugin_hash() -> str:
    """Return a hash of the plug-ins that compiled code may contain, empty without any."""
    text = codes(*COMPILED_KINDS)
    return hashlib.sha256(text.encode()).hexdigest()[:12] if text else ""


def cache_directory(with_plugins: bool = True) -> Path:
    """Return the folder of compiled code for the present sources and plug-ins.

    Without ``with_plugins`` the folder depends on the sources alone; it serves results that no
    plug-in changes.

    ``TALUS_CACHE_DIR`` overrides the default ``~/.cache/talus`` (``XDG_CACHE_HOME`` is honoured).
    If the default cannot be used, a folder of this user under the system's temporary folder
    replaces it. If that fails too, a folder is made that is removed when the process exits.

    Raises
    ------
    InputError
        When the folder in ``TALUS_CACHE_DIR`` belongs to another user, or others can write it.
    """
    name = "-".join(
        filter(None, (source_hash(COMPILED_PARTS), _plugin_hash() if with_plugins else ""))
    )
    if folder := os.environ.get(_VARIABLE):
        try:
            return private_folder(Path(folder) / name)
        except NotPrivateError as error:
            allowed = "a folder of your own that only you can write"
            raise InputError(f"environment: {_VARIABLE}: {error}; allowed: {allowed}") from None
        except OSError as error:
            return _temporary_folder(name, f"{folder}: {error.strerror or error}")
    try:
        return private_folder(cache_folder() / "talus" / name)
    except (OSError, RuntimeError, NotPrivateError) as error:
        return _temporary_folder(name, str(error))


@cache
def _temporary_folder(name: str, reason: str) -> Path:
    """Return a folder under the system's temporary one; log a warning with the reason once."""
    base = user_temporary_folder()
    try:
        private_folder(base)
        path = private_folder(base / name)
    except (OSError, NotPrivateError):
        path = Path(tempfile.mkdtemp(prefix="talus-"))
        atexit.register(shutil.rmtree, path, ignore_errors=True)
    log.warning("compiled code is kept in %s: %s", path, reason)
    return path
