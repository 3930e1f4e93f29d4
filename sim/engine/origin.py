"""Runs that start from the final states of another run, such as changes of angle or frequency."""

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from sim.base.errors import InputError
from sim.engine.dynamics.status import BlowUp
from sim.engine.replicate import Start
from sim.engine.states import States
from sim.engine.stored_run import read_parameters
from sim.engine.systems.replica import Replica
from sim.parameters import RUN_FILE, Parameters, point_id, require_compatible_source


class Origin(NamedTuple):
    """The start of replicates: ``start`` puts the system of a replicate into its initial state.

    ``samples`` counts the samples of each replicate of the other run at that moment. A run that
    grows has another end; a run that started from the earlier end is not a continuation of it.
    """

    start: Start
    samples: tuple[int, ...]


def is_alike(first: Sequence[int], second: Sequence[int]) -> bool:
    """True where the replicates that two sequences have in common started at the same sample."""
    return all(a == b for a, b in zip(first, second, strict=False))


def origin_of(parameters: Parameters, output: Path) -> Origin | None:
    """Return the origin of the replicates of a point, None where they start as in the paper.

    Parameters
    ----------
    parameters : Parameters
        The point.
    output : Path
        Its run file; the run file of an origin named by its id is in the same folder.

    Raises
    ------
    InputError
        When there is no such run file, or its particles are not those of the point. The function
        ``start`` raises it when the final state of a replicate is missing, and ``BlowUp`` when that
        replicate has failed, so that the new one fails, too.
    """
    source_name, name = parameters.start_from, point_id(parameters)
    if not source_name:
        return None
    is_file = source_name.endswith(RUN_FILE)
    path = Path(source_name) if is_file else output.with_name(f"{source_name}.nc")
    path = path.resolve()
    if path == output.resolve():
        allowed = "another run than that to be made"
        raise InputError.of_value(name, "start_from", source_name, allowed)
    source = read_parameters(path)
    require_compatible_source(parameters, source, name)
    states = States(path, source, is_own=False)

    def start(system: Replica, number: int) -> None:
        replicate = states.replicate(source, number)
        if replicate is None:
            allowed = (
                f"a run with the state of its replicate {number} in {states.path.name} beside it; "
                f"remove {path.name} to have it run again"
            )
            raise InputError.of_value(name, "start_from", source_name, allowed)
        if replicate.has_failed:
            raise BlowUp(f"replicate {number} of {source_name}, from which it starts, has failed")
        try:
            system.take_over(replicate.system)
        except ValueError as error:
            raise InputError(f"{name}: start_from: {source_name}: {error}") from None

    return Origin(start, tuple(states.samples(n) for n in range(source.replicates) if n in states))
