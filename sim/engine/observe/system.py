"""What the recorder needs of a system."""

from typing import Protocol

import numpy as np

from sim.engine.observe.ledger import Ledger
from sim.engine.observe.regime import Scales
from sim.engine.observe.sums import Sums
from sim.parameters import Parameters


class System(Protocol):
    """One replicate in motion: what ``sim.engine.run`` needs of a system.

    ``parameters`` are those of the point, ``time_step`` (s) is theirs or a fraction of it;
    ``series`` maps the names of the time series to (unit, long name), and ``ledger`` tells which of
    them add up to the energy; ``axes`` names the directions; ``profile_height`` (H,) are the
    centres of the profiles' slices (m); ``scales`` and ``period`` (samples) serve the analysis of
    the velocity's trend; ``mass`` is that of all particles (kg); ``coordinates`` of tables and
    path: name -> (unit, long name, values); ``moving`` names the attributes that motion changes,
    which are arrays and numbers, or tuples, lists and dictionaries of them.
    """

    parameters: Parameters
    time_step: float
    series: dict[str, tuple[str, str]]
    ledger: Ledger
    axes: tuple[str, ...]
    mass: float
    profile_height: np.ndarray
    scales: Scales
    period: int
    coordinates: dict[str, tuple[str, str, np.ndarray]]
    moving: tuple[str, ...]

    def settle(self) -> None:
        """Bring the initial state to rest where the paper does; raise ``BlowUp`` when it fails."""

    def advance(self) -> dict[str, float]:
        """Advance to the next sample and return a value per time series; may raise ``BlowUp``."""

    def sample_profiles(self) -> Sums:
        """Return the profiles of the present state as sums that can be added up."""

    def profiles(self, sums: Sums) -> dict[str, np.ndarray]:
        """Turn sums of profiles into named arrays (H,)."""

    def tables(self, sums: Sums) -> dict[str, np.ndarray]:
        """Turn sums of profiles into what has other dimensions than height."""

    def trace(self) -> np.ndarray:
        """Go on for a little and return the path of every particle (S, N, D) in m."""

    def snapshot(self) -> dict[str, np.ndarray]:
        """Return positions, velocities and what else a picture needs."""


class OnSlope(System, Protocol):
    """A system with a base shear force; ``weight`` of all particles along and normal to it (N)."""

    weight: tuple[float, float]
