"""One replicate of a point, from its start to its record; a blow-up is retried once.

It starts as in the paper, or from the final state of another run.
"""

import logging
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, NamedTuple, Self

import numpy as np

from sim.base.additions import attribute_errors_to, plain_name
from sim.base.errors import InputError
from sim.engine.dynamics.cells import BlowUp
from sim.engine.observe.samples import Samples
from sim.engine.states import FlatState, States, flatten, refill, subtree, unpack
from sim.engine.stored_run import read_parameters
from sim.engine.systems import build
from sim.engine.systems.recorder import Record, Recorder
from sim.engine.systems.replica import Replica
from sim.parameters import RUN_FILE, Parameters, point_id, require_compatible_source
from sim.parameters.laws import FUNCTION_NAME, RNG

log = logging.getLogger("talus")

#: Divisor of the time step when a replicate that blew up is run again.
SUBSTEPS = 2

#: A function that puts the system of a replicate, given by its number, into its initial state.
Start = Callable[[Replica, int], None]


class Replicate:
    """Replicate number ``number`` of a point while it runs.

    After a blow-up it starts again from the same initial state with half the time step; samples are
    taken at the same times. A second blow-up is final. ``reported_samples`` counts the samples that
    have been reported as progress.
    """

    def __init__(self, parameters: Parameters, number: int, substeps: int = 1):
        self.parameters = parameters
        self.number = number
        self.failures: list[str] = []
        self.reported_samples = 0
        self._start_time, self._earlier_seconds = time.monotonic(), 0.0
        self._earlier_loop_time = 0.0
        self._sample_steps = parameters.sample_steps
        self._start(substeps)

    def _start(self, substeps: int) -> None:
        self.substeps = substeps
        self.system = build(self.parameters, self.number, substeps)
        self.recorder = Recorder(self.system)

    @property
    def seconds(self) -> float:
        """Wall time so far (s) in all processes that have worked on the replicate."""
        return self._earlier_seconds + time.monotonic() - self._start_time

    @property
    def loop_time(self) -> float:
        """Processor time (s) in the compiled loop over time steps so far, in all processes."""
        return self._earlier_loop_time + self.system.loop_time

    def state(self) -> FlatState:
        """Return all arrays and numbers that are needed to continue the replicate, by name."""
        header = {
            "substeps": self.substeps,
            "failures": list(self.failures),
            "shown": self.reported_samples,
            "seconds": self.seconds,
            "loop_time": self.loop_time,
        }
        if self.system.stage:
            header["stage"] = self.system.stage
        moving = {name: getattr(self.system, name) for name in self.system.state_names}
        return flatten({"told": header, "moving": moving}) | self.recorder.state()

    @classmethod
    def from_state(cls, parameters: Parameters, number: int, state: Mapping[str, Any]) -> Self:
        """Return a replicate in a stored state, to be run to the lengths of ``parameters``.

        Raises ``ValueError`` when the state does not belong to such a replicate.
        """
        replicate = cls(parameters, number, int(state["told.substeps"]))
        failures = [name for name in state if name.startswith("told.failures.")]
        replicate.failures = [state[name] for name in failures]
        replicate.reported_samples = int(state["told.shown"])
        replicate._earlier_seconds = float(state["told.seconds"])
        replicate._earlier_loop_time = float(state["told.loop_time"])
        system = replicate.system
        system.stage = str(state.get("told.stage", ""))
        moving = {name: getattr(system, name) for name in system.state_names}
        for name, value in refill(moving, subtree("moving", state)).items():
            setattr(system, name, value)
        replicate.recorder.restore(state)
        return replicate

    def run(
        self, report_steps: Callable[[int], None], states: States, start: Start | None = None
    ) -> Record:
        """Run to the end, or to the second blow-up.

        ``report_steps`` is called with each number of steps done, counted in time steps of the
        point; ``states`` receive this replicate whenever its state may be stored. Without ``start``
        the system starts as in the paper.
        """
        if not self.has_failed:
            failure = self._attempt(report_steps, states, start)
            if failure and self.substeps == 1:
                name = point_id(self.parameters)
                log.warning("%s: %s; again with half the time step", name, failure)
                self._earlier_loop_time = self.loop_time
                self._start(SUBSTEPS)
                failure = self._attempt(report_steps, states, start)
            if failure:
                states.keep(self)
        return self._finish_record()

    @property
    def has_failed(self) -> bool:
        """True where the replicate has blown up with half the time step, too."""
        return len(self.failures) > 1

    def _attempt(
        self, report_steps: Callable[[int], None], states: States, start: Start | None
    ) -> str:
        """Run to the end or to a blow-up; return the reason of the blow-up, else an empty text."""
        recorder, system = self.recorder, self.system
        system.pause = lambda: states.offer(self)
        try:
            if not recorder.snapshots:
                if start:
                    start(system, self.number)
                else:
                    system.settle()
                recorder.take_snapshot()
                states.offer(self)
            while not recorder.stop_reason:
                self._take(system.sample(*recorder.next_samples()), report_steps)
                states.offer(self)
            # A longer run continues from this state; the path that follows is not part of the run.
            states.keep(self)
            system.pause = states.check_signals
            recorder.path = system.trace()
        except BlowUp as error:
            if error.samples:
                self._take(error.samples, report_steps)
            self.failures.append(str(error))
            return str(error)
        return ""

    def _take(self, samples: Samples, report_steps: Callable[[int], None]) -> None:
        self.recorder.take(samples)
        if self.recorder.sample_count > self.reported_samples:
            report_steps((self.recorder.sample_count - self.reported_samples) * self._sample_steps)
            self.reported_samples = self.recorder.sample_count

    def _finish_record(self) -> Record:
        p, recorder = self.parameters, self.recorder
        if not recorder.snapshots:
            recorder.take_snapshot()
        recorder.take_snapshot()
        reason = "; with half the time step: ".join(self.failures) if self.has_failed else ""
        record = recorder.finish(reason)
        record.scalars |= {
            "steps": recorder.sample_count * p.sample_steps * self.substeps,
            "time_step_used": self.system.time_step,
            "wall_time": self.seconds,
            "loop_time": self.loop_time,
            "replicate_seed": self.number,
        }
        return record


class Evaluation:
    """Replicate number ``number`` of a point of a function, run and written as one of a flow."""

    def __init__(self, parameters: Parameters, number: int):
        self.parameters: Any = parameters
        self.number = number
        self.system = self
        self.series: dict[str, Any] = {}
        self.coordinates: dict[str, Any] = {}
        self.provenance: dict[str, str] = {}

    def run(self, report_steps: Callable[[int], None], *_: Any) -> Record:
        """Call the function; an error in it names the plug-in and its line there."""
        p, option = self.parameters, self.parameters.option(FUNCTION_NAME)
        arguments = {name: getattr(p, name) for name in option.parameters}
        if option.is_random:
            # Of its own for each point: noise that all points share would be no noise.
            code = int(point_id(p).rpartition("-")[2], 16)
            arguments[RNG] = np.random.default_rng((p.seed, self.number, code))
        wall, work = time.monotonic(), time.process_time()
        name = plain_name(p.function)
        with attribute_errors_to(FUNCTION_NAME, name):
            values = self._by_name(option.make(**arguments), option.returns)
        report_steps(1)
        outcome = {"status": "completed", "reason": "", "regime": "steady", "quality": "reliable"}
        costs = {
            "wall_time": time.monotonic() - wall,
            "loop_time": time.process_time() - work,
            "replicate_seed": self.number,
            "steps": 1,
        }
        return Record({}, scalars={**outcome, "stopped": "length", **costs, **values})

    @staticmethod
    def _by_name(returned: Any, names: tuple[str, ...]) -> dict[str, float]:
        """Return the numbers that a function returns by name; refuse anything else."""
        if not isinstance(returned, Mapping):
            if len(names) > 1:
                raise TypeError(f"it returns a mapping of {', '.join(names)} to numbers")
            returned = {names[0]: returned}
        if unknown := sorted(set(returned) - set(names)):
            raise TypeError(f"it returns {unknown[0]}, which it does not declare")
        return {name: float(returned.get(name, np.nan)) for name in names}


def stored_replicate(states: States, parameters: Parameters, number: int) -> Replicate | None:
    """Return a stored replicate, to be run to the lengths of ``parameters``.

    None where no state of it is stored, or where this program cannot use the state.
    """
    archive = states.archive(number)
    if archive is None:
        return None
    try:
        return Replicate.from_state(parameters, number, unpack(archive))
    except (ValueError, TypeError, LookupError) as error:
        log.warning("%s: replicate %d starts anew: %s", states.path, number, error)
        return None


def begin(parameters: Parameters, number: int) -> Replicate | Evaluation:
    """Return a replicate of a point before its start, or the call of a function."""
    make = Replicate if parameters.is_flow else Evaluation
    return make(parameters, number)


class Origin(NamedTuple):
    """The start of replicates: ``start`` puts the system of a replicate into its initial state.

    ``samples`` counts the samples of each replicate of the other run at that moment. A run that
    grows has another end; a run that started from the earlier end is not a continuation of it.
    """

    start: Start
    samples: tuple[int, ...]


def origin_of(parameters: Parameters, output: Path) -> Origin | None:
    """Return the origin of the replicates of a point, None where they start as in the paper.

    ``output`` is its run file; the run file of an origin named by its id is in the same folder.
    Raises `InputError` when there is no such run file, or its particles are not those of the point.
    The function ``start`` raises it when the final state of a replicate is missing, and ``BlowUp``
    when that replicate has failed, so that the new one fails, too.
    """
    source_name, name = parameters.start_from, point_id(parameters)
    if not source_name:
        return None
    is_file = source_name.endswith(RUN_FILE)
    path = Path(source_name) if is_file else output.with_name(f"{source_name}.nc")
    path = path.resolve()
    if path == output.resolve():
        allowed = "a run other than the output"
        raise InputError.of_value(name, "start_from", source_name, allowed)
    source = read_parameters(path)
    require_compatible_source(parameters, source, name)
    states = States(path, source, is_own=False)

    def start(system: Replica, number: int) -> None:
        replicate = stored_replicate(states, source, number)
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

    return Origin(start, tuple(states.samples(range(source.replicates))))
