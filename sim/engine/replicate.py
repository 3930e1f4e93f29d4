"""One replicate of a point, from its initial state to its record; a blow-up is retried once."""

import logging
import time
from collections.abc import Callable

from sim.engine.dynamics.status import BlowUp
from sim.engine.observe.recorder import Record, Recorder
from sim.engine.systems import build
from sim.parameters import Parameters, point_id

log = logging.getLogger("talus")

#: By how much the time step is divided when a replicate that blew up is run again.
SUBSTEPS = 2


class Stopwatch:
    """Wall time; one that is unpickled goes on from where it was pickled."""

    def __init__(self, seconds: float = 0.0):
        self._began = time.monotonic() - seconds

    def __reduce__(self) -> tuple[type["Stopwatch"], tuple[float]]:
        return Stopwatch, (self.seconds(),)

    def seconds(self) -> float:
        """Return the wall time so far, s."""
        return time.monotonic() - self._began


class Replicate:
    """Replicate number ``number`` of a point under way; a pickle of it can be run on.

    After a blow-up it starts again from the same initial state with half the time step; samples are
    taken at the same times. A second blow-up is final.
    """

    def __init__(self, parameters: Parameters, number: int):
        self.parameters = parameters
        self.number = number
        self.stopwatch = Stopwatch()
        self.failures: list[str] = []
        self.shown = 0
        self._start(1)

    def _start(self, substeps: int) -> None:
        p = self.parameters
        self.substeps = substeps
        self.system = build(p, self.number, substeps)
        self.recorder = Recorder(self.system)

    def run(self, advanced: Callable[[int], None], pause: Callable[[], None]) -> Record:
        """Run to the end, or to the second blow-up.

        Parameters
        ----------
        advanced : callable
            Is told of every number of steps, as the point counts them, that is done.
        pause : callable
            Called whenever this replicate may be pickled.
        """
        failure = self._attempt(advanced, pause)
        if failure and self.substeps == 1:
            name = point_id(self.parameters)
            log.warning("%s: %s; again with half the time step", name, failure)
            self._start(SUBSTEPS)
            failure = self._attempt(advanced, pause)
        return self._record(failure)

    def _attempt(self, advanced: Callable[[int], None], pause: Callable[[], None]) -> str:
        """Run to the end or to a blow-up; return its reason."""
        recorder = self.recorder
        try:
            if not recorder.snapshots:
                self.system.settle()
                recorder.take_snapshot()
                pause()
            while not recorder.stopped:
                recorder.take(self.system.advance())
                if recorder.taken > self.shown:
                    self.shown = recorder.taken
                    advanced(self.parameters.sample_steps)
                pause()
            recorder.path = self.system.trace()
        except BlowUp as error:
            self.failures.append(str(error))
            return str(error)
        return ""

    def _record(self, failure: str) -> Record:
        p, recorder = self.parameters, self.recorder
        if not recorder.snapshots:
            recorder.take_snapshot()
        recorder.take_snapshot()
        reason = f"{self.failures[0]}; with half the time step: {failure}" if failure else ""
        record = recorder.finish(reason)
        record.scalars |= {
            "steps": recorder.taken * p.sample_steps * self.substeps,
            "time_step_used": self.system.time_step,
            "wall_time": self.stopwatch.seconds(),
            "replicate_seed": self.number,
        }
        return record
