"""One place for numba's options and for where compiled code is kept.

numba decides from a function's own file whether its cached machine code is still good, so an edit
of an imported contact law would replay old code. Here the cache folder carries the hash of all
engine sources instead: any edit starts a new folder.
"""

import os
import tempfile
from functools import partial
from pathlib import Path

from sim.provenance import source_hash


def cache_directory() -> Path:
    """Return the folder of compiled code for the present sources.

    ``TALUS_CACHE_DIR`` overrides the default ``~/.cache/talus`` (``XDG_CACHE_HOME`` is honoured);
    where neither can be written, the system's temporary folder serves.
    """
    base = os.environ.get("TALUS_CACHE_DIR")
    if not base:
        base = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "talus"
    path = Path(base) / source_hash()
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError:
        path = Path(tempfile.gettempdir()) / f"talus-{os.getuid()}" / path.name
        path.mkdir(parents=True, exist_ok=True)
    return path


os.environ["NUMBA_CACHE_DIR"] = str(cache_directory())

import numba  # noqa: E402  (the cache folder must be named before numba is imported)
from numba.extending import overload  # noqa: E402

#: Reordering of sums and fused multiply-add are allowed; ``nnan`` and ``ninf`` are left out because
#: the blow-up checks need honest comparisons with not-a-number.
FASTMATH = {"nsz", "arcp", "contract", "afn", "reassoc"}

#: Kernels that Python calls, or that are too large to be copied into their callers.
kernel = numba.njit(cache=True, fastmath=FASTMATH, error_model="numpy", nogil=True)

#: Pieces of kernels, always copied into the caller so that its loop can be vectorised.
inlined = numba.njit(cache=True, fastmath=FASTMATH, error_model="numpy", forceinline=True)

#: ``@implements(generic)`` gives ``generic`` a body that numba picks by the types of the arguments.
implements = partial(
    overload, jit_options={"fastmath": FASTMATH, "error_model": "numpy", "forceinline": True}
)
