"""One replicate of a point, from its initial state to its record; a blow-up is retried once."""

import logging
import time
from collections.abc import Callable, Mapping
from typing import Any, Protocol, Self

from sim.engine.dynamics.status import BlowUp
from sim.engine.flatten import FlatState, flattened, part_at, refilled
from sim.engine.observe.recorder import Record, Recorder
from sim.engine.observe.system import Samples, System
from sim.engine.systems import build
from sim.parameters import Parameters, point_id

log = logging.getLogger("talus")

#: By how much the time step is divided when a replicate that blew up is run again.
SUBSTEPS = 2


#: Puts the system of a replicate, by its number, into the state that it starts from.
Start = Callable[[System, int], None]


class Keeper(Protocol):
    """What is shown a replicate under way, to keep its state."""

    def offer(self, replicate: "Replicate") -> None:
        """Look at a replicate that may be kept now; called at least every few tenths of a second
        of its time."""

    def heed(self) -> None:
        """End the process if that has been asked for, without a further look at the replicate."""

    def keep(self, replicate: "Replicate") -> None:
        """Keep a replicate that has run to the end of its lengths, or blown up for good."""


class Replicate:
    """Replicate number ``number`` of a point under way.

    After a blow-up it starts again from the same initial state with half the time step; samples are
    taken at the same times. A second blow-up is final. ``shown`` is how many samples have been
    counted as advance, ``seconds`` the wall time of the processes before this one.
    """

    def __init__(self, parameters: Parameters, number: int, substeps: int = 1):
        self.parameters = parameters
        self.number = number
        self.failures: list[str] = []
        self.shown = 0
        self._began, self._before = time.monotonic(), 0.0
        self._looped = 0.0
        self._sample_steps = parameters.sample_steps
        self._start(substeps)

    def _start(self, substeps: int) -> None:
        self.substeps = substeps
        self.system = build(self.parameters, self.number, substeps)
        self.recorder = Recorder(self.system)

    @property
    def seconds(self) -> float:
        """Wall time so far, s, in all processes that have worked on it."""
        return self._before + time.monotonic() - self._began

    @property
    def loop_time(self) -> float:
        """Processor time (s) in the compiled loop over time steps so far, in all processes."""
        return self._looped + self.system.loop_time

    def state(self) -> FlatState:
        """Return all that a replicate to be run on has to know, arrays and numbers by name."""
        told = {
            "substeps": self.substeps,
            "failures": list(self.failures),
            "shown": self.shown,
            "seconds": self.seconds,
            "loop_time": self.loop_time,
        }
        if self.system.stage:
            told["stage"] = self.system.stage
        moving = {name: getattr(self.system, name) for name in self.system.moving}
        return flattened({"told": told, "moving": moving}) | self.recorder.state()

    @classmethod
    def restored(cls, parameters: Parameters, number: int, state: Mapping[str, Any]) -> Self:
        """Return the replicate that had a state, to be run to the lengths of ``parameters``.

        Raises ``ValueError`` when the state is none of such a replicate.
        """
        made = cls(parameters, number, int(state["told.substeps"]))
        failures = [name for name in state if name.startswith("told.failures.")]
        made.failures = [state[name] for name in failures]
        made.shown = int(state["told.shown"])
        made._before = float(state["told.seconds"])
        made._looped = float(state["told.loop_time"])
        made.system.stage = str(state.get("told.stage", ""))
        moving = {name: getattr(made.system, name) for name in made.system.moving}
        held = part_at("moving", state)
        for name, value in refilled(moving, held).items():
            setattr(made.system, name, value)
        made.recorder.restore(state)
        return made

    def run(
        self, advanced: Callable[[int], None], keeper: Keeper, start: Start | None = None
    ) -> Record:
        """Run to the end, or to the second blow-up.

        Parameters
        ----------
        advanced : callable
            Is told of every number of steps, as the point counts them, that is done.
        keeper : Keeper
            Is shown this replicate whenever its state may be kept.
        start : callable, optional
            Puts the system into the state that it starts from; else it starts as in the paper.
        """
        if not self.has_failed:
            failure = self._attempt(advanced, keeper, start)
            if failure and self.substeps == 1:
                name = point_id(self.parameters)
                log.warning("%s: %s; again with half the time step", name, failure)
                self._looped = self.loop_time
                self._start(SUBSTEPS)
                failure = self._attempt(advanced, keeper, start)
            if failure:
                keeper.keep(self)
        return self._record()

    @property
    def has_failed(self) -> bool:
        """Whether it has blown up with half the time step, too."""
        return len(self.failures) > 1

    def _attempt(self, advanced: Callable[[int], None], keeper: Keeper, start: Start | None) -> str:
        """Run to the end or to a blow-up; return its reason."""
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
            while not recorder.stopped:
                self._take(system.sample(*recorder.due()), advanced)
                keeper.offer(self)
            # What goes on later goes on from here: the path is no part of the run.
            keeper.keep(self)
            system.pause = keeper.heed
            recorder.path = system.trace()
        except BlowUp as error:
            if error.samples:
                self._take(error.samples, advanced)
            self.failures.append(str(error))
            return str(error)
        return ""

    def _take(self, samples: Samples, advanced: Callable[[int], None]) -> None:
        self.recorder.take(samples)
        if self.recorder.taken > self.shown:
            advanced((self.recorder.taken - self.shown) * self._sample_steps)
            self.shown = self.recorder.taken

    def _record(self) -> Record:
        p, recorder = self.parameters, self.recorder
        if not recorder.snapshots:
            recorder.take_snapshot()
        recorder.take_snapshot()
        reason = "; with half the time step: ".join(self.failures) if self.has_failed else ""
        record = recorder.finish(reason)
        record.scalars |= {
            "steps": recorder.taken * p.sample_steps * self.substeps,
            "time_step_used": self.system.time_step,
            "wall_time": self.seconds,
            "loop_time": self.loop_time,
            "replicate_seed": self.number,
        }
        return record
