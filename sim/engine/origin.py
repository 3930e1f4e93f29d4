"""Runs that start from the final states of another: changes of angle or frequency on the way."""

from pathlib import Path

from sim.base.errors import InputError
from sim.engine.held import read_parameters
from sim.engine.observe.system import System
from sim.engine.replicate import Origin
from sim.engine.states import States
from sim.parameters import RUN_FILE, Parameters, point_id, require_alike


def origin_of(parameters: Parameters, output: Path) -> Origin | None:
    """Return where the replicates of a point start, nothing where they do as in the paper.

    Parameters
    ----------
    parameters : Parameters
        The point.
    output : Path
        Its run file; the one of a point that is named by its id lies beside it.

    Raises
    ------
    InputError
        When there is no such run file, or its particles are not those of the point; by the origin
        itself, when the final state of a replicate is not known.
    """
    start, name = parameters.start_from, point_id(parameters)
    if not start:
        return None
    path = Path(start) if start.endswith(RUN_FILE) else output.with_name(f"{start}.nc")
    source = read_parameters(path)
    require_alike(parameters, source, name)
    states = States(path, source)

    def origin(system: System, number: int) -> None:
        found = states.replicate(source, number)
        if found is None or found.has_failed:
            allowed = f"a run whose replicate {number} has ended well, with its states beside it"
            raise InputError.of_value(name, "start_from", start, allowed)
        try:
            system.take_over(found.system)
        except ValueError as error:
            raise InputError(f"{name}: start_from: {start}: {error}") from None

    return origin
