"""The figures Talus can draw. Only this registry is imported before a figure is asked for."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from sim.errors import InputError


@dataclass(frozen=True)
class FigureSpec:
    """What a study must supply for one figure.

    Attributes
    ----------
    name : str
        Name in study files, targets and file names; also the module that draws it.
    paper : str
        Figure of the paper it reproduces, or what it is about in it.
    system : str
        System of all the points that feed it.
    axes : tuple of str
        Parameters that must take at least two values among those points.
    curves : tuple of str
        Parameters that tell the paper's curves apart; a study may vary them or not.
    title : str
        One line for tables and the report.
    where : mapping
        Values that parameters of a point must have to be drawn; others of a series that feeds the
        figure are left out.
    regimes : bool
        Whether it shows regimes and the boundaries found between them, rather than velocities.
    particles : bool
        Whether it shows particles, whose states the dataset then keeps.
    """

    name: str
    paper: str
    system: str
    axes: tuple[str, ...]
    curves: tuple[str, ...]
    title: str
    where: Mapping[str, Any] = field(default_factory=dict)
    regimes: bool = False
    particles: bool = False

    def shows(self, parameters: Any) -> bool:
        """Return whether a point with these parameters is among those drawn."""
        return all(getattr(parameters, name) == value for name, value in self.where.items())


_SPECS = (
    FigureSpec(
        name="walton_2",
        paper="Walton (1993), Fig. 2",
        system="chute",
        axes=("depth",),
        curves=("restitution", "friction"),
        title="Mean velocity against depth of the flow",
    ),
    FigureSpec(
        name="gallas_1a",
        paper="Gallas et al. (1992), Fig. 1a",
        system="belt",
        axes=("frequency",),
        curves=("vibration_angle",),
        title="Transport velocity against frequency for three angles of vibration",
    ),
    FigureSpec(
        name="gallas_1b",
        paper="Gallas et al. (1992), Fig. 1b",
        system="belt",
        axes=("frequency",),
        curves=("amplitude", "damping", "shear_damping"),
        title="Transport velocity against frequency for amplitudes and damping coefficients",
    ),
    FigureSpec(
        name="gallas_1c",
        paper="Gallas et al. (1992), Fig. 1c",
        system="belt",
        axes=("shear_damping",),
        curves=("frequency",),
        title="Transport velocity against the shear friction coefficient",
    ),
    FigureSpec(
        name="regimes_friction",
        paper="Walton (1993), flow regimes",
        system="chute",
        axes=("depth", "friction"),
        curves=(),
        title="Regimes over depth and friction",
        regimes=True,
    ),
    FigureSpec(
        name="regimes_angle",
        paper="Walton (1993), range of angles of steady flow",
        system="chute",
        axes=("depth", "angle"),
        curves=(),
        title="Regimes over depth and inclination",
        regimes=True,
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

FIGURES: dict[str, FigureSpec] = {spec.name: spec for spec in _SPECS}


def draw(name: str, dataset_path: str | Path, out_folder: str | Path) -> list[Path]:
    """Draw one figure of a study.

    Parameters
    ----------
    name : str
        One of `FIGURES`.
    dataset_path : str or Path
        The study's ``dataset.nc``.
    out_folder : str or Path
        Folder for the files; made if absent.

    Returns
    -------
    list of Path
        ``<name>.png``, ``.svg``, ``.csv`` (the data behind the picture) and ``.caption.txt``.

    Raises
    ------
    InputError
        For an unknown figure, a missing dataset, or one without points for the figure.
    """
    if name not in FIGURES:
        raise InputError.of_value("figure", "name", name, "one of " + ", ".join(FIGURES))
    from sim.figures.render import render

    return render(FIGURES[name], Path(dataset_path), Path(out_folder))
