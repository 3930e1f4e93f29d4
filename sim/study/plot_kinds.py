"""Kinds of plot of a study's own points: those of Talus, and those that plug-ins declare."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from sim.base.additions import add, additions
from sim.base.declared import require_function, require_one_of

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

#: Those of Talus; docs/plots.md tells what they show.
KINDS = ("curves", "map", "profiles", "time_series", "distribution")

#: Kind of these additions.
PLOT = "plot"

#: Gives the picture from the data of a figure, `sim.figures.data.FigureData`.
Drawing = Callable[[Any], "Figure"]


@dataclass(frozen=True)
class OwnPlot:
    """A kind of plot of a plug-in: see `plot_kind`."""

    like: str
    draw: Drawing
    table: "Callable[[Any], pd.DataFrame] | None"
    notes: Callable[[Any], Sequence[str]] | None


def plot_kind(
    name: str,
    *,
    like: str,
    table: "Callable[[Any], pd.DataFrame] | None" = None,
    notes: Callable[[Any], Sequence[str]] | None = None,
) -> Callable[[Drawing], Drawing]:
    """Declare a kind of plot; the function below draws it.

    That gets the data of a figure: its ``spec``, a table ``rows`` of its points, and the
    ``results`` of the study; it returns a figure of matplotlib.

    Parameters
    ----------
    name : str
        The ``kind`` that study files give.
    like : str
        Kind of Talus whose keys it takes, with all that is checked of them.
    table, notes : callable, optional
        Give the data behind the picture, and sentences of the caption; those of ``like`` if
        omitted.
    """
    require_one_of(f"plot {name}: like", like, KINDS)
    for what, function in (("table", table), ("notes", notes)):
        if function is not None:
            require_function(f"plot {name}: {what}", function, takes=1)

    def declared(draw: Drawing) -> Drawing:
        require_function(f"plot {name}", draw, takes=1)
        add(PLOT, name, OwnPlot(like, draw, table, notes), KINDS)
        return draw

    return declared


def own_plots() -> dict[str, OwnPlot]:
    """Return the kinds that plug-ins have declared."""
    return {name: one.value for name, one in additions(PLOT).items()}


def like(kind: str) -> str:
    """Return the kind of Talus whose keys a kind takes."""
    own = own_plots()
    return own[kind].like if kind in own else kind


def code_of(kind: str) -> dict[str, str]:
    """Return what tells the code that draws a kind, for options of a figure: nothing of Talus'."""
    held = additions(PLOT)
    return {"plugin": held[kind].plugin.code} if kind in held else {}
