"""Single impacts from Python: how one looks at a contact law before a study."""

from typing import TYPE_CHECKING, Any

import numpy as np

from sim.base.errors import InputError
from sim.engine.contact import Partners, law_of
from sim.engine.systems.impacts import Impacts
from sim.parameters import parse_python_point

if TYPE_CHECKING:
    import xarray as xr

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
