"""The engine of this program: `sim.engine`."""

from typing import Any

from sim.parameters.laws import flow_engine


def make(p: Any, replicate: int, substeps: int) -> Any:
    """Return a replicate of a point in its initial state."""
    from sim.engine.systems import build_own

    return build_own(p, replicate, substeps)


flow_engine("talus", description="this one", make=make)
