"""One replicate of a point in motion: what all systems share, and what a run asks of them."""

from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import Any, ClassVar, Self

import numpy as np

from sim.engine.compile import working_time
from sim.engine.dynamics.cells import LIST_FULL, BlowUp, Box, failure_reason
from sim.engine.dynamics.neighbors import PairList, double_room
from sim.engine.observe.regime import Scales
from sim.engine.observe.samples import ContactList, Ledger, Samples, no_contacts
from sim.parameters import Parameters
from sim.parameters.variables import recorded_by

#: Most particle-steps between two pauses: some tenths of a second.
MOST_WORK = 2_000_000

#: Intervals of the path that ends a run: the paper on the belt plots every 50th of 2000 steps.
PATH_INTERVALS = 40

#: Column of the number of steps in ``sums`` of every loop.
STEPS = 0


class Replica(ABC):
    """One replicate in motion; a system adds its particles, kernels, state, series and profiles.

    Each class sets the attributes below that have no value, and defines the abstract methods.
    """

    #: The time series whose sum is the energy, and the names of the directions.
    ledger: Ledger
    axes: ClassVar[tuple[str, ...]]

    #: Attributes with particles and contacts, and all that change during motion: arrays and
    #: numbers, or tuples, lists and dictionaries of them.
    particle_names: ClassVar[tuple[str, ...]]
    state_names: tuple[str, ...]

    #: The periodic cell, the neighbor list, the state of the loop over steps: the number of the
    #: last ``step`` (1,) and ``sums`` over steps; types that determine those of all kernels.
    box: Box
    pairs: PairList
    loop: Any
    kind: Any

    #: Mass of all particles (kg); on a slope, their weight along and normal to it (N).
    mass: float
    weight: tuple[float, float]

    #: How profiles cut the flow: it gives ``empty`` sums, and of sums ``profiles`` (H,) and
    #: ``tables``. Names of those profiles that are stored by block, as functions of time.
    slices: Any
    history_profiles: tuple[str, ...] = ()

    #: Thresholds and period (samples) for the analysis of the velocity's trend.
    scales: Scales
    period: int = 1

    #: Coordinates of tables and path: name -> (unit, long name, values); time steps of the path.
    coordinates: dict[str, tuple[str, str, np.ndarray]]
    path_steps: int

    def __init__(self, parameters: Parameters, substeps: int):
        p = parameters
        self.parameters: Any = p
        #: Called every few tenths of a second during long computations. A run that continues from a
        #: state stored in it gives the same bits.
        self.pause: Callable[[], None] = lambda: None
        #: Name of the phase before the first sample, empty once samples may be taken.
        self.stage = ""
        #: Processor time in the compiled loop over time steps, s.
        self.loop_time = 0.0
        self.series = recorded_by(p, "series")
        self.time_step = p.time_step / substeps
        self.sample_steps = p.sample_steps * substeps
        work = max(p.particles + p.glued_particles, p.effective_particles)
        self._stretch = max(1, int(MOST_WORK // work))

    @property
    def provenance(self) -> dict[str, str]:
        """Further attributes of the run file, where another program moves the flow."""
        return {}

    @property
    def profile_height(self) -> np.ndarray:
        """Centres (H,) of the slices of the profiles, m."""
        return (np.arange(self.slices.slices) + 0.5) * self.slices.slice_height

    @property
    def cycle_steps(self) -> int:
        """Time steps in a period."""
        return self.sample_steps * self.period

    def settle(self) -> None:
        """Bring the initial state to rest where the paper does, continuing from ``stage``.

        Raises ``BlowUp`` when that fails.
        """
        self.stage = ""

    def take_over(self, other: Self) -> None:
        """Start from the particles of another such system, without settling.

        Raises ``ValueError`` with the reason where this system cannot start from that state.
        """
        for name in self.particle_names:
            setattr(self, name, getattr(other, name))
        self.stage = ""

    def require_whole_cycles(self) -> None:
        """Raise ``ValueError`` unless the system is at the beginning of a cycle."""
        if self.loop.step[0] % self.cycle_steps:
            raise ValueError("that flow has been shaken for no whole number of cycles")

    def sample(self, most: int = 1, profiles: bool = False) -> Samples:
        """Advance by at least one and at most ``most`` samples and return them.

        Raises ``BlowUp``, which holds the samples taken before the blow-up.
        """
        samples, failure = self._take(most, profiles)
        if failure or samples is None:
            raise BlowUp(failure, samples)
        return samples

    def advance(self) -> dict[str, float]:
        """Advance to the next sample and return a value per time series; may raise ``BlowUp``."""
        return self.sample().first()

    def current_contacts(self, most: int) -> ContactList:
        """Return the contacts of the present state; those beyond ``most`` are only counted."""
        contacts = no_contacts(most, len(self.axes))
        self._list_contacts(contacts)
        return contacts

    def snapshot(self) -> dict[str, np.ndarray]:
        """Return positions, velocities and other arrays (N, ...), in the initial order."""
        arrays = self._arrays()
        order = np.argsort(arrays.pop("label"))
        return {name: values.T[order[: values.shape[-1]]] for name, values in arrays.items()}

    def trace(self) -> np.ndarray:
        """Advance for a while and return the path of every particle (S, N, D) in m, unwrapped."""
        states, steps = [self.snapshot()["position"]], self.path_steps
        for k in range(PATH_INTERVALS):
            self._run((k + 1) * steps // PATH_INTERVALS - k * steps // PATH_INTERVALS)
            states.append(self.snapshot()["position"])
            stray = states[-1] - states[-2] - self._mean_displacement()
            for d, length in enumerate(self.box.length[:-1]):
                states[-1][:, d] -= length * np.round(stray[:, d] / length)
        return np.array(states)

    def _missing_steps(self) -> int:
        """Return the steps to the end of the sample under way, or else of the next, now begun."""
        sums = self.loop.sums
        if sums[STEPS] >= self.sample_steps:
            sums[:] = 0.0
        return self.sample_steps - int(sums[STEPS])

    def _run(self, steps: int) -> None:
        """Advance by a number of steps, with the sums of these steps alone."""
        self.loop.sums[:] = 0.0
        self._continue(steps)

    def _continue(self, steps: int) -> None:
        """Advance by a number of steps, with pauses on the way."""
        step = self.loop.step
        last = step[0] + steps
        while step[0] < last:
            target, start = min(last, step[0] + self._stretch), working_time()
            while (status := self._advance(target - step[0])) == LIST_FULL:
                self.make_room()
            failure = self._failure(status)
            self.loop_time += working_time() - start
            if failure:
                raise BlowUp(failure)
            if target < last:
                self.pause()

    def make_room(self) -> None:
        """Double the room of the list."""
        self.pairs = double_room(self.pairs)

    def _failure(self, status: int) -> str:
        """Return the reason for a failure after steps with this status, or an empty text."""
        if reason := failure_reason(status, self._coordinates()):
            return f"{reason} at step {self.loop.step[0]} {self._moment()}"
        return ""

    def _total(self, name: str, gains: np.ndarray) -> np.ndarray:
        """Return totals (K,) since the start from gains (K,), and store the last as ``name``."""
        total = np.cumsum([getattr(self, name), *gains])
        setattr(self, name, float(total[-1]))
        return total[1:]

    def _mean_displacement(self) -> np.ndarray:
        """Return the mean displacement (D,) in the last steps, m, where it may be large."""
        return np.zeros(len(self.axes))

    @abstractmethod
    def _advance(self, steps: int) -> int:
        """Advance by a number of steps in compiled code; return the status."""

    @abstractmethod
    def _take(self, most: int, profiles: bool) -> tuple[Samples | None, str]:
        """Advance by one to ``most`` samples, or to a blow-up; return them, and its reason."""

    @abstractmethod
    def _coordinates(self) -> np.ndarray:
        """Return the array that is finite unless the system has blown up."""

    @abstractmethod
    def _moment(self) -> str:
        """Return the words for the present moment that follow the step in messages."""

    @abstractmethod
    def _arrays(self) -> dict[str, np.ndarray]:
        """Return ``label`` (N,) of the particles and the arrays of a snapshot, (D, N) or (N,)."""

    @abstractmethod
    def _list_contacts(self, contacts: ContactList) -> None:
        """Fill a list of contacts."""
