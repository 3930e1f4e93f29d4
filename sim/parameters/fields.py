"""Parameters of several systems: one declaration each, to which a system adds what is its own.

``own`` are options of `sim.parameters.roles.declare`: source, meaning, range.
"""

from typing import Any

from sim.parameters.roles import amount, declare, numerics

#: Scale of times of shaken systems.
CYCLES = "cycles"


def frequency(equation: str) -> Any:
    """Declare the frequency of a vibration."""
    return declare(
        20,
        symbol="f",
        unit="Hz",
        description="frequency of the vibration",
        equation=equation,
        id_part="frequency",
        gt=0,
    )


def angle(default: float, **own: Any) -> Any:
    """Declare the inclination of a plane."""
    description = "inclination of the plane"
    return declare(default, symbol="θ", unit="degree", description=description, ge=0, lt=90, **own)


def gravity(default: float, equation: str) -> Any:
    """Declare the gravitational acceleration."""
    description = "gravitational acceleration"
    return declare(
        default, symbol="g", unit="m s-2", description=description, equation=equation, gt=0
    )


def shear_damping(description: str, **own: Any) -> Any:
    """Declare the coefficient of the drag along surfaces."""
    equation = "Gallas, Eq. 4"
    return declare(
        50, symbol="γ_s", scale="g", description=description, equation=equation, ge=0, **own
    )


def initial_velocity(default: Any = ..., *, scale: str, **own: Any) -> Any:
    """Declare the velocity of all particles at the start."""
    return numerics(default, symbol="V0", scale=scale, changes_start=True, ge=0, **own)


def samples_per_cycle(description: str, **own: Any) -> Any:
    """Declare how often a shaken system is sampled."""
    return numerics(20, description=description, ge=1, **own)


def transient(default: float, scale: str, **own: Any) -> Any:
    """Declare the length of a run before averaging."""
    return numerics(default, symbol="t_tr", scale=scale, ge=0, **own)


def average(default: float, scale: str, **own: Any) -> Any:
    """Declare the length of the window of averages."""
    return amount(default, symbol="t_av", scale=scale, gt=0, **own)


def limit(default: float, scale: str) -> Any:
    """Declare the length at which the converged protocol ends."""
    return amount(
        default,
        symbol="t_max",
        scale=scale,
        description="longest run of the converged protocol, whose cost `points` tells",
        gt=0,
    )


def trajectory(scale: str) -> Any:
    """Declare the interval of the frames of a trajectory."""
    return numerics(
        0,
        symbol="Δt_f",
        scale=scale,
        description="time from one frame of the trajectory, which has the state of every particle, "
        "to the next (0: none); in whole samples",
        added=True,
        ge=0,
    )


def extra(description: str, **own: Any) -> Any:
    """Declare a switch by which a run records more; it changes no flow."""
    return numerics(False, description=description, added=True, **own)
