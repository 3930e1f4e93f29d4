"""A flow in one's hands: run for a while, looked at, run on."""

from numbers import Integral, Real
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from sim.base.errors import InputError
from sim.engine.origin import origin_of
from sim.engine.progress import bar
from sim.engine.systems import build
from sim.parameters import point_id, point_in_python
from sim.parameters.common import MAX_SAMPLES
from sim.parameters.variables import variables

if TYPE_CHECKING:
    import xarray as xr


def _is(kind: type, value: Any) -> bool:
    """Return whether a value is a number of a kind; ``True`` and ``False`` are none."""
    return isinstance(value, kind) and not isinstance(value, bool)


class Flow:
    """One replicate of a point in motion, from its initial state on; a bed has settled before.

    It moves as the same replicate of a run does, to the bit, for as long as it is asked to:
    ``transient``, ``average`` and ``limit`` mean nothing to it.

    Parameters
    ----------
    system : str
        ``"chute"`` or ``"belt"``.
    replicate : int
        Number of the replicate, from 0: each has another initial state.
    **parameters
        Parameters of the system by name, in the units of a study file; those left out have the
        value of the paper.

    Raises
    ------
    InputError
        When a parameter is unknown or outside its range.
    BlowUp
        When a bed does while it settles.

    Examples
    --------
    >>> flow = Flow("belt", beads=10, width=5)
    >>> flow.positions.shape
    (10, 2)
    >>> flow.run(3, progress=False).time
    0.15
    >>> flow.series.mean_velocity.sizes["time"] == 3 * flow.parameters.samples_per_cycle
    True
    """

    def __init__(self, system: str = "chute", *, replicate: int = 0, **parameters: Any):
        self.parameters = point_in_python("Flow", system, parameters)
        if not (_is(Integral, replicate) and replicate >= 0):
            raise InputError.of_value("Flow", "replicate", replicate, "an integer >= 0")
        replicate = int(replicate)
        self._system = build(self.parameters, replicate)
        self._taken: list[dict[str, np.ndarray]] = []
        self._samples, self._owed = 0, 0.0
        if origin := origin_of(self.parameters, Path("flow.nc")):
            origin.start(self._system, replicate)
        else:
            self._system.settle()

    def run(self, duration: float, *, progress: bool = True) -> Self:
        """Go on for a while, in whole sample intervals, and return the flow.

        What a call goes on for too long or too short, half an interval at most, the next makes up
        for: after many short ones the flow has gone on for their sum to within half an interval.

        Parameters
        ----------
        duration : float
            How long, in units of √(σ/g) for a chute and of cycles for a belt, as ``transient`` is.
        progress : bool
            Show a bar, on terminals and in notebooks.

        Raises
        ------
        InputError
            When the duration is no positive number, or one of more than ten million samples.
        BlowUp
            When an overlap exceeds ``overlap_limit`` or a position is no number. A run would start
            again with half the time step.
        """
        longest = MAX_SAMPLES * self._interval / self.parameters.time_unit
        if not (_is(Real, duration) and 0 < duration <= longest):
            allowed = f"a number > 0 and <= {longest:.6g}"
            raise InputError.of_value("run", "duration", duration, allowed)
        wanted = duration * self.parameters.time_unit / self._interval + self._owed
        left = round(wanted)
        # Where it ends before, by a signal or a blow-up, nothing is owed.
        owed, self._owed = wanted - left, 0.0
        with bar(left, point_id(self.parameters), "sample", quiet=not progress) as shown:
            while left:
                values = self._system.sample(left).values
                taken = {name: np.array(several, float) for name, several in values.items()}
                number = len(taken["mean_velocity"])
                self._taken.append({name: taken[name] for name in self._system.series})
                self._samples += number
                left -= number
                shown.update(number)
        self._owed = owed
        return self

    @property
    def _interval(self) -> float:
        """Time between two samples, s."""
        return self.parameters.sample_steps * self.parameters.time_step

    @property
    def time(self) -> float:
        """Time since the start, s."""
        return round(self._samples * self._interval, 12)

    @property
    def positions(self) -> np.ndarray:
        """Centres of the particles, (N, D) in m, within the periodic cell.

        ``x`` points down the slope, ``z`` away from it; chutes have ``y`` between them.
        """
        return self._snapshot("position")

    @property
    def velocities(self) -> np.ndarray:
        """Velocities of the particles, (N, D) in m/s."""
        return self._snapshot("particle_velocity")

    @property
    def spins(self) -> np.ndarray:
        """Angular velocities of the spheres, (N, 3) in 1/s; beads of the belt have none, (N, 0)."""
        return self._snapshot("particle_spin")

    @property
    def radii(self) -> np.ndarray:
        """Radii of the particles, (N,) in m."""
        return self._snapshot("radius")

    @property
    def series(self) -> "xr.Dataset":
        """Time series over ``time`` (s) since the start, with units and long names, as in a run."""
        import xarray as xr

        time = np.arange(1, self._samples + 1) * self._interval
        meant = {"units": "s", "long_name": "end of the sample interval, since the start"}
        return xr.Dataset(
            {
                name: (
                    "time",
                    np.concatenate([np.empty(0), *(taken[name] for taken in self._taken)]),
                    variable.attributes,
                )
                for name, variable in self._system.series.items()
            },
            coords={"time": ("time", time, meant)},
        )

    @property
    def particles(self) -> "xr.Dataset":
        """State of the particles over ``particle``, with units and long names, as in a run."""
        import xarray as xr

        found = {}
        for name, values in self._system.snapshot().items():
            if values.size:
                row = variables("particle")[name]
                dims = [one for one in row.dims if one not in ("replicate", "frame")]
                found[name] = dims, values, row.attributes
        time = (), self.time, {"units": "s", "long_name": "time since the start"}
        return xr.Dataset(found, {"axis": list(self._system.axes), "time": time})

    def _snapshot(self, name: str) -> np.ndarray:
        held = self._system.snapshot()
        return np.array(held[name]) if name in held else np.empty((self.parameters.particles, 0))

    def __repr__(self) -> str:
        return f"<Flow {point_id(self.parameters)} at {self.time:.6g} s>"
