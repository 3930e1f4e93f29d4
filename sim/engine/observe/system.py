"""The interface of a system to the recorder: samples, energy ledger and contacts."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple, Protocol

import numpy as np

from sim.engine.observe.regime import Scales
from sim.engine.observe.sums import Sums
from sim.parameters import Parameters
from sim.parameters.variables import Variable


class ContactList(NamedTuple):
    """The contacts of one moment; ``number`` (1,) is their number.

    Row by row ``pair`` (K, 2) holds the numbers of the two partners, and ``force`` (K, D) the force
    on the first of them (N). Unused rows are not-a-number. `sim.parameters.variables` defines the
    numbers of plane, belt and obstacle. Contacts beyond K are counted but not listed.
    """

    number: np.ndarray
    pair: np.ndarray
    force: np.ndarray


def no_contacts(most: int, axes: int = 3) -> ContactList:
    """Return an empty list with space for ``most`` contacts in ``axes`` directions."""
    arrays = (np.full((most, width), np.nan) for width in (2, axes))
    return ContactList(np.zeros(1, np.int64), *arrays)


class Ledger(NamedTuple):
    """The energy ledger of a system; its names are those of time series (J).

    ``terms`` name -> sign: the signed sum of these series is constant. ``turnover`` names sums
    since the start whose change measures the energy that has passed through. ``powers`` name of a
    sum since the start -> name of the scalar with its mean rate (W).
    """

    terms: dict[str, int]
    turnover: tuple[str, ...]
    powers: dict[str, str]


class Samples(NamedTuple):
    """K successive samples.

    ``values`` name -> (K,) of the time series; ``profiles`` sums of the profiles with a first axis
    over the samples, None where they were not requested. The profiles are valid until the next
    samples are taken.
    """

    values: Mapping[str, Sequence[float] | np.ndarray]
    profiles: Sums | None

    def first(self) -> dict[str, float]:
        """Return the values of the first sample."""
        return {name: float(values[0]) for name, values in self.values.items()}


def no_pause() -> None:
    """Do nothing at the pauses of a system."""


class System(Protocol):
    """One replicate in motion: the interface of a system to ``sim.engine.run``.

    Attributes
    ----------
    parameters : Parameters
        The point.
    time_step : float
        Time step (s), that of the point or a fraction of it.
    series : dict
        Time series by name.
    ledger : Ledger
        The time series whose sum is the energy.
    axes : tuple of str
        Names of the directions.
    mass : float
        Mass of all particles (kg).
    loop_time : float
        Processor time in the compiled loop over time steps (s).
    profile_height : (H,) array
        Centres of the slices of the profiles (m).
    scales, period : Scales, int
        Thresholds and period (samples) for the analysis of the velocity's trend.
    coordinates : dict
        Coordinates of tables and path: name -> (unit, long name, values).
    history_profiles : tuple of str
        Names of the profiles that are stored by block, as functions of time.
    state_names : tuple of str
        Names of the attributes that change during motion: arrays and numbers, or tuples, lists and
        dictionaries of them.
    stage : str
        Name of the phase before the first sample, empty once samples may be taken.
    pause : callable
        Called every few tenths of a second during long computations. A run that continues from a
        state stored in it gives the same bits.
    """

    parameters: Parameters
    time_step: float
    series: dict[str, Variable]
    ledger: Ledger
    axes: tuple[str, ...]
    mass: float
    loop_time: float
    profile_height: np.ndarray
    scales: Scales
    period: int
    coordinates: dict[str, tuple[str, str, np.ndarray]]
    history_profiles: tuple[str, ...]
    state_names: tuple[str, ...]
    stage: str
    pause: Callable[[], None]

    def settle(self) -> None:
        """Bring the initial state to rest where the paper does, continuing from ``stage``.

        Raises ``BlowUp`` when that fails.
        """

    def take_over(self, other: Any) -> None:
        """Start from the state of another such system with the same particles, without settling.

        Raises ``ValueError`` with the reason where this system cannot start from that state.
        """

    def sample(self, most: int = 1, profiles: bool = False) -> Samples:
        """Advance by at least one and at most ``most`` samples and return them.

        Raises ``BlowUp``, which holds the samples taken before the blow-up.
        """

    def advance(self) -> dict[str, float]:
        """Advance to the next sample and return a value per time series; may raise ``BlowUp``."""

    def no_profiles(self) -> Sums:
        """Return sums of profiles that are zero."""

    def profiles(self, sums: Sums) -> dict[str, np.ndarray]:
        """Return the profiles, named arrays (H,), from their sums."""

    def tables(self, sums: Sums) -> dict[str, np.ndarray]:
        """Return the tables, named arrays with other dimensions than height, from their sums."""

    def current_contacts(self, most: int) -> ContactList:
        """Return the contacts of the present state; those beyond ``most`` are only counted."""
        ...

    def trace(self) -> np.ndarray:
        """Advance for a short time and return the path of every particle (S, N, D) in m."""

    def snapshot(self) -> dict[str, np.ndarray]:
        """Return positions, velocities and other arrays of the particles, by name."""


class OnSlope(System, Protocol):
    """A system with a base shear force; ``weight`` of all particles along and normal to it (N)."""

    weight: tuple[float, float]
