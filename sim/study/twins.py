"""The points of a study by another engine, which a second opinion is asked for."""

from sim.parameters import Parameters
from sim.study.model import Study

#: The engine of this program, and the one that is asked about its runs.
OWN, OTHER = "talus", "lammps"


def twin_of(parameters: Parameters) -> Parameters | None:
    """Return the same point by the other engine, None where that does not know it."""
    engine = getattr(parameters, "engine", "")
    if not engine:
        return None
    values = {"engine": OWN if engine != OWN else OTHER, "ranks": 1, "threads": 1}
    twin = parameters.model_copy(update=values)
    return None if any(True for _ in twin.option("engine").refuses(twin)) else twin


def twins(study: Study) -> dict[str, Parameters]:
    """Return the points by the other engine, by the ids of those of a study."""
    every = {key: twin_of(point.parameters) for key, point in study.points.items()}
    return {key: twin for key, twin in every.items() if twin is not None}
