"""What the recorder needs of a system."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple, Protocol

import numpy as np

from sim.engine.observe.ledger import Ledger
from sim.engine.observe.listed import Listed
from sim.engine.observe.regime import Scales
from sim.engine.observe.sums import Sums
from sim.parameters import Parameters
from sim.parameters.variables import Variable


class Samples(NamedTuple):
    """K successive samples: ``values`` name -> (K,) of the time series, and the sums that their
    ``profiles`` add, along a first axis, or nothing where they were not wanted.

    The profiles are good until the next samples are taken.
    """

    values: Mapping[str, Sequence[float] | np.ndarray]
    profiles: Sums | None

    def first(self) -> dict[str, float]:
        """Return the values of the first sample."""
        return {name: float(values[0]) for name, values in self.values.items()}


def no_pause() -> None:
    """Do nothing: nobody wants to know of the pauses of a system."""


class System(Protocol):
    """One replicate in motion: what ``sim.engine.run`` needs of a system.

    ``parameters`` are those of the point, ``time_step`` (s) is theirs or a fraction of it;
    ``series`` maps the names of the time series to what they are, and ``ledger`` tells which of
    them add up to the energy; ``axes`` names the directions; ``profile_height`` (H,) are the
    centres of the profiles' slices (m); ``loop_time`` (s) processor time in the compiled loop over
    time steps; ``scales`` and ``period`` (samples) serve the analysis of
    the velocity's trend; ``mass`` is that of all particles (kg); ``coordinates`` of tables and
    path: name -> (unit, long name, values); ``followed`` names the profiles whose course in time is
    kept; ``moving`` names the attributes that motion changes,
    which are arrays and numbers, or tuples, lists and dictionaries of them; ``stage`` names what
    comes before the first sample, empty once that may be taken. ``pause`` is called in all that
    takes long, some tenths of a second apart: a state taken then goes on to the same bits.
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
    followed: tuple[str, ...]
    moving: tuple[str, ...]
    stage: str
    pause: Callable[[], None]

    def settle(self) -> None:
        """Bring the initial state to rest where the paper does; raise ``BlowUp`` when it fails.

        It goes on from its ``stage``.
        """

    def take_over(self, other: Any) -> None:
        """Start from the state of another such system with the same particles, instead.

        Raises ``ValueError``, which says why, where that state is none to start from.
        """

    def sample(self, most: int = 1, profiles: bool = False) -> Samples:
        """Advance by at least one and at most so many samples and return what they say.

        Raises ``BlowUp``, which holds the samples taken before that.
        """

    def advance(self) -> dict[str, float]:
        """Advance to the next sample and return a value per time series; may raise ``BlowUp``."""

    def no_profiles(self) -> Sums:
        """Return sums of profiles of zero."""

    def profiles(self, sums: Sums) -> dict[str, np.ndarray]:
        """Turn sums of profiles into named arrays (H,)."""

    def tables(self, sums: Sums) -> dict[str, np.ndarray]:
        """Turn sums of profiles into what has other dimensions than height."""

    def contacts_now(self, most: int) -> Listed:
        """Return the contacts of the present state, listed where there are no more than so many."""
        ...

    def trace(self) -> np.ndarray:
        """Go on for a little and return the path of every particle (S, N, D) in m."""

    def snapshot(self) -> dict[str, np.ndarray]:
        """Return positions, velocities and what else a picture needs."""


class OnSlope(System, Protocol):
    """A system with a base shear force; ``weight`` of all particles along and normal to it (N)."""

    weight: tuple[float, float]
