"""Runs that start from the final states of another: changes of angle or frequency on the way."""

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from sim.base.errors import InputError
from sim.engine.dynamics.status import BlowUp
from sim.engine.observe.system import System
from sim.engine.replicate import Start
from sim.engine.states import States
from sim.engine.stored_run import read_parameters
from sim.parameters import RUN_FILE, Parameters, point_id, require_alike


class Origin(NamedTuple):
    """Where replicates start: ``start`` puts the system of one, by its number, into its state.

    ``samples`` are how many each replicate of the other run had taken by then. A run that grows has
    another end, and what has started from the one before is none of its continuations.
    """

    start: Start
    samples: tuple[int, ...]


def is_alike(one: Sequence[int], other: Sequence[int]) -> bool:
    """Return whether those replicates have started alike that both know of."""
    return all(first == second for first, second in zip(one, other, strict=False))


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
        itself, when the final state of a replicate is not known. It raises ``BlowUp`` where that
        replicate has failed, so that this one has, too.
    """
    other, name = parameters.start_from, point_id(parameters)
    if not other:
        return None
    path = Path(other) if other.endswith(RUN_FILE) else output.with_name(f"{other}.nc")
    path = path.resolve()
    if path == output.resolve():
        raise InputError.of_value(name, "start_from", other, "another run than that to be made")
    source = read_parameters(path)
    require_alike(parameters, source, name)
    states = States(path, source, own=False)

    def start(system: System, number: int) -> None:
        found = states.replicate(source, number)
        if found is None:
            allowed = (
                f"a run with the state of its replicate {number} in {states.path.name} beside it; "
                f"remove {path.name} to have it run again"
            )
            raise InputError.of_value(name, "start_from", other, allowed)
        if found.has_failed:
            raise BlowUp(f"replicate {number} of {other}, from which it starts, has failed")
        try:
            system.take_over(found.system)
        except ValueError as error:
            raise InputError(f"{name}: start_from: {other}: {error}") from None

    return Origin(start, tuple(states.samples(n) for n in range(source.replicates) if n in states))
