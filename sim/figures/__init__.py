"""The figures Talus can draw. Only this registry is imported before a figure is asked for."""

from pathlib import Path

from sim.base.errors import InputError
from sim.figures.spec import FigureSpec
from sim.figures.specs_animated import ANIMATED
from sim.figures.specs_belt import BELT
from sim.figures.specs_chute import CHUTE

__all__ = ["FIGURES", "FigureSpec", "draw"]

FIGURES: dict[str, FigureSpec] = {spec.name: spec for spec in (*CHUTE, *BELT, *ANIMATED)}


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
        ``<name>.png``, ``.svg``, ``.csv`` (the data behind the picture) and ``.caption.txt``; of an
        animation ``.gif`` instead of ``.svg``.

    Raises
    ------
    InputError
        For an unknown figure, a missing dataset, or one without points for the figure.
    """
    if name not in FIGURES:
        raise InputError.of_value("figure", "name", name, "one of " + ", ".join(FIGURES))
    from sim.figures.render import render

    return render(FIGURES[name], Path(dataset_path), Path(out_folder))
