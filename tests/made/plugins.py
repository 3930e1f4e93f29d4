"""Plug-ins in tests: what one adds is gone behind it."""

from collections.abc import Iterator
from contextlib import contextmanager

from sim.base import additions, plugins


@contextmanager
def forgotten() -> Iterator[None]:
    """Forget, in the end, the plug-ins that were loaded in the block."""
    loaded = dict(plugins._plugins)
    added = {kind: dict(held) for kind, held in additions._additions.items()}
    try:
        yield
    finally:
        plugins._plugins.clear()
        plugins._plugins.update(loaded)
        additions._additions.clear()
        additions._additions.update(added)
        additions.changed()


@contextmanager
def alone() -> Iterator[None]:
    """Be, in the block, like a process that has loaded no plug-in."""
    with forgotten():
        plugins._plugins.clear()
        additions._additions.clear()
        additions.changed()
        yield
