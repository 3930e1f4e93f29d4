"""One replicate of a point, from its initial state to its record; a blow-up is retried once."""

import logging
import time
from collections.abc import Callable, Mapping
from typing import Any, Protocol, Self

from sim.engine.dynamics.status import BlowUp
from sim.engine.flatten import FlatState, flatten, refill, subtree
from sim.engine.observe.recorder import Record, Recorder
from sim.engine.observe.system import Samples
from sim.engine.systems import build
from sim.engine.systems.replica import Replica
from sim.parameters import Parameters, point_id

log = logging.getLogger("talus")

#: Divisor of the time step when a replicate that blew up is run again.
SUBSTEPS = 2


#: A function that puts the system of a replicate, given by its number, into its initial state.
Start = Callable[[Replica, int], None]


class Keeper(Protocol):
    """Stores the state of a running replicate."""

    def offer(self, replicate: "Replicate") -> None:
        """Store the state of a replicate if it is time.

        Called at least every few tenths of a second of the replicate's running time.
        """

    def check_signals(self) -> None:
        """End the process if a signal has requested it; the replicate is not stored again."""

    def keep(self, replicate: "Replicate") -> None:
        """Store a replicate that has reached its full length, or failed for good."""


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
        self, report_steps: Callable[[int], None], keeper: Keeper, start: Start | None = None
    ) -> Record:
        """Run to the end, or to the second blow-up.

        Parameters
        ----------
        report_steps : callable
            Called with each number of steps done, counted in time steps of the point.
        keeper : Keeper
            Receives this replicate whenever its state may be stored.
        start : callable, optional
            Puts the system into its initial state; without it the system starts as in the paper.
        """
        if not self.has_failed:
            failure = self._attempt(report_steps, keeper, start)
            if failure and self.substeps == 1:
                name = point_id(self.parameters)
                log.warning("%s: %s; again with half the time step", name, failure)
                self._earlier_loop_time = self.loop_time
                self._start(SUBSTEPS)
                failure = self._attempt(report_steps, keeper, start)
            if failure:
                keeper.keep(self)
        return self._finish_record()

    @property
    def has_failed(self) -> bool:
        """True where the replicate has blown up with half the time step, too."""
        return len(self.failures) > 1

    def _attempt(
        self, report_steps: Callable[[int], None], keeper: Keeper, start: Start | None
    ) -> str:
        """Run to the end or to a blow-up; return the reason of the blow-up, else an empty text."""
        recorder, system = self.recorder, self.system
        system.pause = lambda: keeper.offer(self)
        try:
            if not recorder.snapshots:
                if start:
                    start(system, self.number)
                else:
                    system.settle()
                recorder.take_snapshot()
                keeper.offer(self)
            while not recorder.stop_reason:
                self._take(system.sample(*recorder.next_samples()), report_steps)
                keeper.offer(self)
            # A longer run continues from this state; the path that follows is not part of the run.
            keeper.keep(self)
            system.pause = keeper.check_signals
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
