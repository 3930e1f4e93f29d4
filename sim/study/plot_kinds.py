"""Kinds of plot of a study's own points: the kinds of Talus, and those that plug-ins declare."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from sim.base.additions import add, additions
from sim.base.require import require_function, require_one_of

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

#: Kinds of Talus; docs/plots.md describes them.
KINDS = ("curves", "map", "profiles", "time_series", "distribution")

#: Kind of the plug-in additions that are kinds of plot.
PLOT = "plot"

#: Function: data of a figure (`sim.figures.data.FigureData`) → picture.
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
    """Declare a kind of plot; the decorated function draws it.

    The function gets the data of a figure: its ``spec``, a table ``rows`` of its points, and the
    ``results`` of the study. It returns a matplotlib figure.

    Parameters
    ----------
    name : str
        The ``kind`` that study files give.
    like : str
        Kind of Talus whose keys it takes; the same checks apply.
    table, notes : callable, optional
        Functions that return the data behind the picture, and the sentences of the caption. By
        default, those of ``like``.
    """
    require_one_of(f"plot {name}: like", like, KINDS)
    for role, function in (("table", table), ("notes", notes)):
        if function is not None:
            require_function(f"plot {name}: {role}", function, takes=1)

    def register(draw: Drawing) -> Drawing:
        require_function(f"plot {name}", draw, takes=1)
        add(PLOT, name, OwnPlot(like, draw, table, notes), KINDS)
        return draw

    return register


def own_plots() -> dict[str, OwnPlot]:
    """Return the kinds that plug-ins have declared."""
    return {name: addition.value for name, addition in additions(PLOT).items()}


def base_kind(kind: str) -> str:
    """Return the kind of Talus whose keys a kind takes; a kind of Talus is its own base."""
    plots = own_plots()
    return plots[kind].like if kind in plots else kind


def plugin_code(kind: str) -> dict[str, str]:
    """Return the code hash of a kind's plug-in as an option of a figure; empty for Talus' kinds."""
    plots = additions(PLOT)
    return {"plugin": plots[kind].plugin.code} if kind in plots else {}
