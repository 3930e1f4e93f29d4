"""The figures of the vibrating belt, with the parameters that the captions of the paper give."""

from typing import Any

from sim.study.catalogue.spec import FigureSpec

_DAMPED = {"damping": 50, "shear_damping": 50}
_AT_45 = {"amplitude": 1, "vibration_angle": 45}
_FROM_REST = {"initial_velocity": 0, "prior_frequency": 0}
_USUAL = {**_AT_45, **_FROM_REST, **_DAMPED, "obstacle": 0}


def _figure(panel: str, title: str, axes: str = "", curves: str = "", **rest: Any) -> FigureSpec:
    return FigureSpec(
        name=f"gallas_{panel}",
        paper=f"Gallas et al. (1992), Fig. {panel}",
        system="belt",
        axes=tuple(axes.split()),
        curves=tuple(curves.split()),
        title=title,
        **rest,
    )


def _flux(panel: str, title: str, axes: str, curves: str, **where: Any) -> FigureSpec:
    return _figure(panel, f"Transport velocity against {title}", axes, curves, where=where)


def _profiles(panel: str, what: str) -> tuple[FigureSpec, ...]:
    """Return the first two panels of Fig. 2 or 3."""
    several = f"{what} above the belt for several"
    return (
        _figure(
            f"{panel}a",
            f"{several} frequencies",
            "frequency",
            where=_USUAL | {"frequency": (10, 20, 60, 80)},
        ),
        _figure(
            f"{panel}b",
            f"{several} angles of vibration",
            "vibration_angle",
            where=_USUAL | {"frequency": 60, "vibration_angle": (30, 45, 60, 90)},
        ),
    )


def _damped_profiles(panel: str, what: str, curves: str, **start: float) -> FigureSpec:
    """Return the third panel of Fig. 2 or 3."""
    return _figure(
        panel,
        f"{what} above the belt for several damping coefficients",
        "shear_damping",
        curves,
        where={**_AT_45, **start, "prior_frequency": 0, "obstacle": 0, "frequency": 80},
    )


def _paths(panel: str, title: str, **where: Any) -> FigureSpec:
    return _particles(panel, f"Paths of the beads over one cycle {title}", **where)


def _snapshot(panel: str, title: str, **where: Any) -> FigureSpec:
    return _particles(panel, f"Beads at the beginning of a cycle {title}", **where)


def _particles(panel: str, title: str, **where: Any) -> FigureSpec:
    return _figure(panel, title, where=_USUAL | where, particles=True)


def _found(
    name: str, place: str, title: str, axes: str, curves: str = "", **where: Any
) -> FigureSpec:
    """Return a figure that the paper describes but does not show."""
    keys = {*axes.split(), *curves.split()}
    return FigureSpec(
        name=name,
        paper=f"Gallas et al. (1992), {place}",
        system="belt",
        axes=tuple(axes.split()),
        curves=tuple(curves.split()),
        title=title,
        where={key: value for key, value in _USUAL.items() if key not in keys} | where,
    )


BELT = (
    _flux("1a", "frequency for three angles of vibration", "frequency", "vibration_angle"),
    _flux(
        "1b",
        "frequency for amplitudes and damping coefficients",
        "frequency",
        "amplitude damping shear_damping",
        **_FROM_REST,
    ),
    _flux("1c", "the shear friction coefficient", "shear_damping", "frequency"),
    *_profiles("2", "Number density"),
    _damped_profiles("2c", "Number density", "damping", initial_velocity=0),
    *_profiles("3", "Horizontal velocity"),
    _damped_profiles("3c", "Horizontal velocity", "damping initial_velocity"),
    _paths("4a", "at 10 Hz", frequency=10),
    _paths("4b", "at 10 Hz with little shear friction", frequency=10, shear_damping=1),
    _paths("4c", "at 20 Hz", frequency=20),
    _paths("4d", "at 80 Hz", frequency=80),
    _paths("4e", "at 80 Hz without shear friction", frequency=80, shear_damping=0),
    _snapshot("5a", "at 10 Hz", frequency=10, vibration_angle=60),
    _snapshot(
        "5b",
        "at 40 Hz with little friction",
        frequency=40,
        vibration_angle=30,
        damping=10,
        shear_damping=10,
    ),
    _snapshot("5c", "at 100 Hz", frequency=100),
    _snapshot("5d", "at 100 Hz with little damping", frequency=100, damping=1),
    _flux(
        "6",
        "the diameter of an obstacle",
        "obstacle",
        "frequency",
        frequency=(20, 80),
        **_AT_45,
        **_FROM_REST,
        **_DAMPED,
    ),
    _paths("7a", "at 80 Hz around an obstacle", frequency=80, obstacle=1.5),
    _snapshot("7b", "at 80 Hz around an obstacle", frequency=80, obstacle=1.5),
    _paths("7c", "at 20 Hz around an obstacle", frequency=20, obstacle=1.5),
    FigureSpec(
        name="protocols_1c",
        paper="Gallas et al. (1992), Fig. 1c, under both protocols",
        system="belt",
        axes=("shear_damping", "protocol"),
        curves=("frequency",),
        title="Transport velocity against the shear friction coefficient under both protocols",
    ),
    _found(
        "onset_acceleration",
        "onset of the flow",
        "Onset of transport against the acceleration of the belt",
        "frequency",
        "amplitude vibration_angle",
    ),
    _found(
        "belt_void",
        "void at the belt",
        "Share of the beads within the belt's reach against frequency",
        "frequency",
        "amplitude",
    ),
    _found(
        "belt_stiffness",
        "stiffness of the beads",
        "Transport velocity against the stiffness of the beads",
        "stiffness",
        "frequency",
        frequency=(20, 50, 80),
    ),
    _found(
        "density_waves",
        "density waves",
        "Density waves right after the start and later against frequency",
        "frequency",
    ),
    FigureSpec(
        name="belt_onset",
        paper="Gallas et al. (1992), onset of the flow",
        system="belt",
        axes=("amplitude", "frequency"),
        curves=("vibration_angle",),
        title="Onset of transport against amplitude",
        regimes=True,
    ),
)
