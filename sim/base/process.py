"""Restoring the state of this process after foreign code has run."""

import os
import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


@contextmanager
def restore_process() -> Iterator[None]:
    """Restore after a block the state of this process that Talus relies on.

    That is the working directory, the umask, ``sys.path``, the recursion limit and the filters of
    warnings. Filters that ignore warnings are kept.
    """
    folder, mask = Path.cwd(), os.umask(0)
    os.umask(mask)
    path, depth = list(sys.path), sys.getrecursionlimit()
    ignored = []
    try:
        with warnings.catch_warnings():
            before = list(warnings.filters)
            try:
                yield
            finally:
                ignored = [
                    entry
                    for entry in warnings.filters
                    if entry[0] == "ignore" and entry not in before
                ]
    finally:
        # Libraries imported in the block ignore their own harmless warnings; that stays.
        warnings.filters = [*ignored, *warnings.filters]
        sys.setrecursionlimit(depth)
        sys.path[:] = path
        os.umask(mask)
        os.chdir(folder)
