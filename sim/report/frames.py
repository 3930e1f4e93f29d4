"""The frames of one replicate of a run, in three dimensions."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import netCDF4
import numpy as np

from sim.base.errors import InputError
from sim.parameters import Parameters
from sim.parameters.spheres import SphereParameters

#: Variables of the frames of a trajectory, and of the first and last state of any run.
_TRAJECTORY_VARIABLES = ("trajectory_position", "trajectory_velocity", "trajectory_spin")
_END_VARIABLES = ("position", "particle_velocity", "particle_spin")


class Frame(NamedTuple):
    """A state of the particles: ``time`` (s), ``position`` (m), ``velocity`` (m/s) and ``spin``
    (1/s), each (N, 3); beads of the belt have no spin."""

    time: float
    position: np.ndarray
    velocity: np.ndarray
    spin: np.ndarray | None


@dataclass(frozen=True)
class Frames:
    """The frames of a replicate, read one by one.

    ``radius`` (N,) are the radii of the particles (m); ``kind`` (N,) is 1 for moving particles and
    2 for those glued to the plane. ``low`` and ``high`` (3,) are corners of the cell (m), and
    ``periodic`` (3,) is true along its periodic directions. ``times`` (F,) are those of the frames
    (s), and ``steps`` (F,) the numbers of time steps until then.
    """

    radius: np.ndarray
    kind: np.ndarray
    low: np.ndarray
    high: np.ndarray
    periodic: tuple[bool, bool, bool]
    times: np.ndarray
    steps: np.ndarray
    _variables: tuple[netCDF4.Variable | None, ...]
    _places: tuple[tuple[int, int], ...]
    _columns: list[int]

    @property
    def has_spin(self) -> bool:
        """Whether the particles rotate."""
        return self._variables[-1] is not None

    def __iter__(self) -> Iterator[Frame]:
        for time, place in zip(self.times, self._places, strict=True):
            position, velocity, spin = (
                None if variable is None else self._to_space(variable[place])
                for variable in self._variables
            )
            assert position is not None and velocity is not None, "every run file has both"
            yield Frame(float(time), self._wrap(position), velocity, spin)

    def _wrap(self, position: np.ndarray) -> np.ndarray:
        """Return positions wrapped into the cell; a run wraps its own only now and then."""
        length = np.where(self.periodic, self.high - self.low, np.inf)
        return position - np.where(self.periodic, length, 0.0) * np.floor(position / length)

    def _to_space(self, vectors: np.ndarray) -> np.ndarray:
        """Return vectors (N, D) as (N, 3), with zeros along missing axes."""
        padded = np.zeros((len(vectors), 3), vectors.dtype)
        padded[:, self._columns] = vectors
        return padded


def frames_of(file: netCDF4.Dataset, parameters: Parameters, replicate: int) -> Frames:
    """Return the frames of a replicate: its trajectory, or without one its first and last state.

    States with positions that are not finite, after a blow-up, are left out.

    Parameters
    ----------
    file : netCDF4.Dataset
        An open run file, without masks.
    parameters : Parameters
        Its point.
    replicate : int
        Number of the replicate, from 0.

    Raises
    ------
    InputError
        When the run has no such replicate, or the replicate blew up before its first frame.
    """
    count = file.dimensions["replicate"].size
    if not 0 <= replicate < count:
        allowed = f"a replicate of the run, 0 to {count - 1}"
        raise InputError.of_value("--replicate", "", replicate, allowed)
    has_trajectory = "trajectory_position" in file.variables
    names = _TRAJECTORY_VARIABLES if has_trajectory else _END_VARIABLES
    variables = tuple(file.variables.get(name) for name in names)
    times = file["trajectory_time"][:] if has_trajectory else _times_of_ends(file, replicate)
    radius, height = file["radius"][replicate], file[names[0]][replicate, :, :, -1]
    finite_frames = np.flatnonzero(np.isfinite(height).all(axis=1))
    if not finite_frames.size:
        allowed = "a replicate that did not blow up before the first frame of its trajectory"
        raise InputError.of_value("--replicate", "", replicate, allowed)
    low, high, periodic = _cell(parameters, radius, height[finite_frames])
    glued = file["fixed"][replicate] if "fixed" in file.variables else np.zeros(len(radius))
    return Frames(
        radius=radius,
        kind=np.where(glued, 2, 1),
        low=low,
        high=high,
        periodic=periodic,
        times=times[finite_frames],
        steps=np.round(times[finite_frames] / parameters.time_step).astype(int),
        _variables=variables,
        _places=tuple((replicate, int(place)) for place in finite_frames),
        _columns=["xyz".index(axis) for axis in file["axis"][:]],
    )


def _times_of_ends(file: netCDF4.Dataset, replicate: int) -> np.ndarray:
    """Return the times of the first and the last state of a replicate."""
    samples = np.isfinite(file["mean_velocity"][replicate]).sum()
    return np.array([0.0, file["time"][samples - 1] if samples else 0.0])


def _cell(
    parameters: Parameters, radius: np.ndarray, height: np.ndarray
) -> tuple[np.ndarray, np.ndarray, tuple[bool, bool, bool]]:
    """Return the low and high corner of a cell with all particles, and its periodic directions."""
    bottom = min(0.0, float((height - radius).min(initial=0.0)))
    top = float((height + radius).max(initial=parameters.diameter))
    side = parameters.period
    if isinstance(parameters, SphereParameters) and not parameters.is_flat:
        return np.array([0.0, 0.0, bottom]), np.array([side, side, top]), (True, True, False)
    thick = float(radius.max())
    high = np.array([side, thick, top])
    return np.array([0.0, -thick, bottom]), high, (True, False, False)
