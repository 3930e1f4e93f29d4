"""The figures Talus can draw. Only this registry is imported before a figure is asked for."""

from pathlib import Path

from sim.errors import InputError
from sim.figures.spec import FigureSpec
from sim.figures.specs_belt import BELT

__all__ = ["FIGURES", "FigureSpec", "draw"]

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
)

FIGURES: dict[str, FigureSpec] = {spec.name: spec for spec in (*_SPECS, *BELT)}


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
