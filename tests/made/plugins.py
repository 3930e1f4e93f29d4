"""Plug-ins in tests: their additions are removed after each test."""

from collections.abc import Collection, Iterator
from contextlib import contextmanager

from sim.base import additions, plugins


@contextmanager
def restore_plugins() -> Iterator[None]:
    """Remove, at the end of the block, the plug-ins that were loaded in it."""
    plugins_before = dict(plugins._plugins)
    additions_before = {kind: dict(entries) for kind, entries in additions._additions.items()}
    try:
        yield
    finally:
        plugins._plugins.clear()
        plugins._plugins.update(plugins_before)
        additions._additions.clear()
        additions._additions.update(additions_before)
        additions.notify_listeners()


def plugin_claims(systems: Collection[str]) -> list:
    """Return the claims of plug-ins on systems alone, in place of `sim.claims.claim.claims`."""
    claims = [addition.value for addition in additions.additions("judge").values()]
    return [claim for claim in claims if claim.system in systems]


@contextmanager
def without_plugins() -> Iterator[None]:
    """Run the block as in a process without plug-ins."""
    with restore_plugins():
        plugins._plugins.clear()
        additions._additions.clear()
        additions.notify_listeners()
        yield
