"""What the code of others may have changed of this process, put back."""

import os
import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


@contextmanager
def process_kept() -> Iterator[None]:
    """Put back after a block what Talus relies on in this process.

    That is the working directory, the mask of new files' permissions, where modules are found, how
    deep calls may be nested, and which warnings are errors.
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
                    one for one in warnings.filters if one[0] == "ignore" and one not in before
                ]
    finally:
        # Libraries that the block has imported know which warnings of theirs mean nothing.
        warnings.filters = [*ignored, *warnings.filters]
        sys.setrecursionlimit(depth)
        sys.path[:] = path
        os.umask(mask)
        os.chdir(folder)
