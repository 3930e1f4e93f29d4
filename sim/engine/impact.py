"""Single impacts from Python: how one looks at a contact law before a study."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from sim.base.errors import InputError
from sim.engine.contact import Partners, law_of
from sim.engine.systems.moving import Motion
from sim.parameters import parse_python_point

if TYPE_CHECKING:
    import xarray as xr

#: Distance of impacts from each other, in largest radii, besides what they move meanwhile.
APART = 12

#: From the first sphere of a pair to the second one, and the way along which that slides.
NORMAL, TANGENT = np.array([0.6, 0.0, 0.8]), np.array([-0.64, 0.6, 0.48])


class Impacts:
    """Impacts side by side, each of a sphere with the plane or with another sphere.

    ``radii`` (m) and ``mass`` (kg) are those of both spheres, or of the one that meets the plane.
    ``speeds`` (n,) are those along the normal (m/s) of n impacts, ``slides`` those along which the
    second surface slides, ``spins`` (n, p, 3) those of all spheres (1/s) along normal, tangent and
    the direction across both. The momenta of a pair cancel. Impacts begin after ``phases`` of a
    time step (s); without them they differ. Laws act up to ``reach`` (m) beyond contact.
    """

    motion_type: ClassVar[type[Motion]] = Motion

    def __init__(
        self,
        law: Any,
        radii: Sequence[float],
        mass: Any,
        time_step: float,
        speeds: Any,
        slides: Any = 0.0,
        spins: Any = 0.0,
        phases: Any = None,
        longest: int = 2000,
        reach: float = 0.0,
    ):
        self.radii, self.mass = np.array(radii, float), np.array(mass, float)
        self.is_pair = len(radii) == 2
        self.frame = np.array([NORMAL, TANGENT] if self.is_pair else [[0, 0, -1.0], [0, 1.0, 0]])
        self.axes = np.vstack([self.frame, np.cross(*self.frame)])
        normal, tangent = self.frame
        speeds = np.atleast_1d(np.array(speeds, float))
        slides = np.broadcast_to(slides, speeds.shape)
        self.start = slides[:, None] * tangent - speeds[:, None] * normal
        self.number = len(speeds)
        phases = np.linspace(0.1, 0.9, self.number) if phases is None else phases
        self.delays = np.broadcast_to(time_step * np.array(phases), speeds.shape) + reach / speeds
        way = longest * time_step * np.linalg.norm(self.start, axis=1).max()
        size, place = self.radii.max(), np.arange(self.number)
        spacing, columns = APART * size + 2 * way, int(np.ceil(self.number**0.5))
        height = 5 * APART * size + way if self.is_pair else size
        corner = spacing * (np.stack([place % columns, place // columns, place], axis=1) + 0.5)
        corner[:, 2] = height
        delays = self.delays[:, None]
        if self.is_pair:
            shares = self.mass[::-1] / sum(self.mass)
            second = corner + sum(self.radii) * normal - delays * self.start
            position = np.stack([corner, second], axis=1).reshape(-1, 3)
            velocity = np.stack([-shares[0] * self.start, shares[1] * self.start], axis=1)
        else:
            position, velocity = corner + delays * self.start, -self.start
        spins = np.broadcast_to(spins, (self.number, len(radii), 3)) @ self.axes
        self.motion = self.motion_type(
            position,
            velocity.reshape(-1, 3),
            spins.reshape(-1, 3),
            laws=(law, law),
            time_step=time_step,
            radius=np.tile(self.radii, self.number),
            mass=np.tile(self.mass, self.number),
            box=(spacing * columns,) * 2,
            skin=0.6 * size,
            reach=reach,
        )

    def _relative(self, rows: np.ndarray) -> np.ndarray:
        """Return rows (n, 3) of the second partners, 0 of the plane, less those of the first."""
        rows = rows.reshape(self.number, -1, 3)
        return rows[:, 1] - rows[:, 0] if self.is_pair else -rows[:, 0]

    def velocities(self) -> np.ndarray:
        """Return velocities of the second along normal and tangent, and all rims', m/s (n, 2 + p).

        Rims move along the tangent where they touch.
        """
        spin = self.motion.spin.reshape(self.number, -1, 3)
        relative = self._relative(self.motion.velocity)
        return np.hstack([relative @ self.frame.T, self.radii * (spin @ self.axes[2])])

    def contacts(self) -> tuple[np.ndarray, np.ndarray]:
        """Return overlaps (n,) in m and normals (n, 3), from the first partner to the second."""
        apart = self._relative(self.motion.position)
        if not self.is_pair:
            apart = apart * [0.0, 0.0, 1.0]
        distance = np.linalg.norm(apart, axis=1)
        return self.radii.sum() - distance, apart / distance[:, None]

    def record(self, longest: int) -> dict[str, np.ndarray]:
        """Follow the impacts until all have parted, for so many steps at most.

        Returns overlap (m), normal and tangential force on the first partner (N), and the time
        since it touched (s), each (n, S) over its time steps, not-a-number after its last force;
        the ``duration`` (n,) in s, not-a-number where partners still touch.
        """
        records, met = [], np.zeros(self.number, bool)
        for _ in range(longest):
            overlap, normal = self.contacts()
            force = self.motion.run(1).force.reshape(self.number, -1, 3)[:, 0]
            across = self.frame[1] - (normal @ self.frame[1])[:, None] * normal
            records.append([overlap, -(force * normal).sum(1), -(force * across).sum(1)])
            acts = force.any(axis=1)
            met |= acts
            if met.all() and not acts.any() and (self._parting() > 0).all():
                break
        return self._aligned(np.array(records).transpose(1, 2, 0))

    def _parting(self) -> np.ndarray:
        """Return the velocities along the normals at which partners part, m/s."""
        _, normal = self.contacts()
        return (self._relative(self.motion.velocity) * normal).sum(1)

    def _aligned(self, records: np.ndarray) -> dict[str, np.ndarray]:
        """Return the records (3, n, S) of all impacts from the first step of each with a force."""
        acts, steps, step = (records[1:] != 0).any(0), records.shape[2], self.motion.time_step
        first, last = acts.argmax(axis=1), steps - 1 - acts[:, ::-1].argmax(axis=1)
        column = first[:, None] + np.arange((last - first).max() + 1)
        past, column = column > last[:, None], np.minimum(column, steps - 1)
        time = column * step - self.delays[:, None]
        rows = [*np.take_along_axis(records, column[None], 2), time]
        names = ("overlap", "normal_force", "tangential_force", "time")
        found = dict(zip(names, np.where(past, np.nan, rows), strict=True))
        # In the step after the last force they move freely: back to where they have parted.
        after = np.minimum(last + 1, steps - 1)
        gap = np.maximum(0.0, -records[0, np.arange(self.number), after])
        parting = self._parting()
        end = after * step - self.delays - gap / np.where(parting > 0, parting, np.inf)
        return found | {"duration": np.where(last < steps - 1, end, np.nan)}


#: Longest impact that is followed, in collision times of the point.
LONGEST = 60

#: Results: unit and long name.
RESULTS = {
    "normal_velocity": ("m s-1", "velocity along the normal after the impact"),
    "tangential_velocity": ("m s-1", "velocity along the tangent after the impact"),
    "surface_velocity": ("m s-1", "velocity along the tangent of the surfaces after the impact"),
    "rebound_spin": ("s-1", "spin of the sphere after the impact"),
    "partner_spin": ("s-1", "spin of the partner after the impact"),
    "normal_restitution": ("1", "velocity along the normal after the impact over that before it"),
    "tangential_restitution": (
        "1",
        "velocity along the tangent after the impact over that before it",
    ),
    "rebound_angle": ("degree", "angle of the velocity to the normal after the impact"),
    "duration": ("s", "duration of the impact"),
    "largest_overlap": ("m", "largest overlap"),
    "largest_force": ("N", "largest normal force"),
    "time": ("s", "time since the surfaces touched"),
    "overlap": ("m", "overlap"),
    "normal_force": ("N", "normal force on the sphere"),
    "tangential_force": ("N", "tangential force on the sphere, along its way"),
}

#: What an impact is given: unit, long name.
GIVEN = {
    "speed": ("m s-1", "velocity of approach"),
    "angle": ("degree", "angle of the velocity to the normal before the impact"),
    "spin": ("s-1", "spin of the sphere before the impact, positive as if it rolled"),
}

#: Parameters of a chute on which nothing flows.
LEVEL = {"angle": 0.0, "initial_velocity": 0.0}


def impact(
    law: str,
    *,
    speed: Any,
    angle: Any = 0.0,
    spin: Any = 0.0,
    partner: str = "plane",
    **parameters: Any,
) -> "xr.Dataset":
    """Let a sphere meet a plane or a sphere at rest, without gravity; return all that it tells.

    It takes the time steps of a flow with these parameters. Velocities are those of the sphere
    relative to its partner.

    Parameters
    ----------
    law : str
        Name of a contact law, of Talus or of a plug-in that is loaded.
    speed : float or array
        Velocity of approach, m/s.
    angle : float or array
        Its angle to the normal, degrees: 0 is head-on.
    spin : float or array
        Angular velocity of the sphere before the impact, 1/s, about the axis across normal and
        tangent; positive as of a sphere that rolls along its way.
    partner : str
        ``"plane"``, or ``"sphere"``: an equal one, free to move, that does not spin.
    **parameters
        Parameters of a chute by name, such as ``restitution``, ``stiffness``, ``friction`` (with a
        plane ``friction_plane``), ``diameter``, ``mass`` and ``steps_per_collision``.

    Returns
    -------
    xarray.Dataset
        Velocities, spins, restitutions, ``duration``, ``largest_overlap`` and ``largest_force``
        over the dimensions of ``speed``, ``angle`` and ``spin``: those of a ``DataArray``, one of
        the same name of another array, none of a number. ``overlap``, forces and ``time`` also have
        ``step``. ``duration`` is not-a-number where both still touch after 60 collision times.

    Raises
    ------
    InputError
        When a value cannot be used; before anything is computed.
    BlowUp
        When an overlap exceeds ``overlap_limit``.

    Examples
    --------
    >>> met = impact("spring_dashpot", speed=0.1, angle=[0, 30], restitution=0.8, friction=0.3)
    >>> met.normal_restitution.dims, met.normal_restitution.round(2).values.tolist()
    (('angle',), [0.8, 0.8])
    >>> met.overlap.dims, met.largest_force.units
    (('angle', 'step'), 'N')
    """
    import xarray as xr

    point = parse_python_point("impact", "chute", {"law": law, **LEVEL, **parameters})
    if partner not in ("plane", "sphere"):
        raise InputError.of_value("impact", "partner", partner, "plane or sphere")
    asked = {
        name: _given(name, value) for name, value in zip(GIVEN, (speed, angle, spin), strict=True)
    }
    shape, *_ = given = xr.broadcast(*asked.values())
    found = _followed(point, partner, *(one.values.ravel() for one in given))
    return xr.Dataset(
        {name: _variable(name, found[name], shape) for name in RESULTS if name in found},
        coords=asked,
        attrs={"law": law, "partner": partner},
    )


def _variable(name: str, values: np.ndarray, shape: "xr.DataArray") -> tuple[Any, ...]:
    """Return a result (n,) or (n, S) as a variable over the dimensions of what was asked."""
    dims = (*shape.dims, "step")[: values.ndim + shape.ndim - 1]
    return dims, values.reshape((*shape.shape, *values.shape[1:])), _attributes(RESULTS[name])


def _followed(
    point: Any, partner: str, speeds: np.ndarray, angles: np.ndarray, spins: np.ndarray
) -> dict[str, np.ndarray]:
    """Return the results of impacts (n,) by name, each (n,) or (n, S) over its steps."""
    radius, steps = 0.5 * point.diameter, LONGEST * point.steps_per_collision
    spheres, friction = (1, point.friction_plane) if partner == "plane" else (2, point.friction)
    kind = Partners(friction, point.mass / spheres, point.time_step)
    normal, along = speeds * np.cos(np.radians(angles)), speeds * np.sin(np.radians(angles))
    turning = np.zeros((speeds.size, spheres, 3))
    turning[:, 0, 2] = spins
    radii, masses = [radius] * spheres, [point.mass] * spheres
    kinds = law_of(point, kind), radii, masses, point.time_step
    made = Impacts(*kinds, normal, along, turning, 0.5, steps, point.law_reach)
    made.motion.overlap_limit = point.overlap_limit
    found = made.record(steps)
    parting, across, *rims = made.velocities().T
    return found | {
        "normal_velocity": parting,
        "tangential_velocity": across,
        "surface_velocity": across - sum(rims),
        **dict(zip(("rebound_spin", "partner_spin"), np.array(rims) / radius, strict=False)),
        "normal_restitution": parting / normal,
        "tangential_restitution": across / np.where(along != 0, along, np.nan),
        "rebound_angle": np.degrees(np.arctan2(across, parting)),
        "largest_overlap": np.nanmax(found["overlap"], axis=1),
        "largest_force": np.nanmax(found["normal_force"], axis=1),
    }


def _attributes(row: tuple[str, str]) -> dict[str, str]:
    return dict(zip(("units", "long_name"), row, strict=True))


def _given(name: str, value: Any) -> "xr.DataArray":
    """Return what is given of the impacts as an array with its own dimension, or those it has."""
    import xarray as xr

    try:
        values = np.asarray(value, float)
    except (TypeError, ValueError):
        values = np.array(np.nan)
    inside = {"speed": values > 0, "angle": (values >= 0) & (values < 90)}.get(name, True)
    dims = value.dims if isinstance(value, xr.DataArray) else (name,) * values.ndim
    if not (
        np.isfinite(values).all() and np.all(inside) and values.size and len(dims) == len(set(dims))
    ):
        allowed = {"speed": "> 0", "angle": ">= 0 and < 90"}.get(name, "finite")
        raise InputError.of_value("impact", name, value, f"a number or an array of them, {allowed}")
    attributes = _attributes(GIVEN[name])
    return xr.DataArray(values, {name: (dims, values, attributes)}, dims, attrs=attributes)
