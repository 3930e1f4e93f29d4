"""The kinds of plot: their interface, and their modules."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from importlib import import_module
from typing import Any

import pandas as pd
from matplotlib.figure import Figure

from sim.base.additions import plugin_error
from sim.base.words import printable
from sim.figures.animation import Animation
from sim.figures.caption import point_notes
from sim.figures.data import FigureData
from sim.figures.quantity import point_table
from sim.study.catalogue import KEYS
from sim.study.plot_kinds import KINDS as PLOT_KINDS
from sim.study.plot_kinds import PLOT, own_plots

#: Prefix of the names of kinds whose plots study files define.
PLOT_PREFIX = "plot_"

#: The kinds: those of papers, and those of plots of a study. A module of this folder with the name
#: of the kind has the constant ``KIND``; it is imported when a figure of the kind is drawn.
KINDS = (*KEYS, *(PLOT_PREFIX + kind for kind in PLOT_KINDS))


def keep_all_points(data: FigureData) -> FigureData:
    """Return the data unchanged."""
    return data


@dataclass(frozen=True)
class Kind:
    """A kind of plot: functions of the data of a figure, which include its entry of the catalogue.

    Attributes
    ----------
    draw : callable
        Returns the picture or the animation.
    table : callable
        Returns the data behind the picture, units in the headings.
    notes : callable
        Returns the sentences of the caption on error bars, markers and the like.
    select : callable
        Returns the data with the points to draw only; gets at least one point.
    """

    draw: Callable[[FigureData], Figure | Animation]
    table: Callable[[FigureData], pd.DataFrame] = point_table
    notes: Callable[[FigureData], list[str]] = point_notes
    select: Callable[[FigureData], FigureData] = keep_all_points


def load_kind(name: str) -> Kind:
    """Return the kind of plot with a name, from Talus or from a plug-in."""
    if name in KINDS:
        return import_module(f"sim.figures.{name}").KIND
    kind = name.removeprefix(PLOT_PREFIX)
    plot_kind = own_plots()[kind]
    base = load_kind(PLOT_PREFIX + plot_kind.like)
    return Kind(
        partial(_call_plugin, kind, plot_kind.draw),
        table=partial(_call_plugin, kind, plot_kind.table) if plot_kind.table else base.table,
        notes=partial(_call_plugin, kind, _printable_notes(plot_kind.notes))
        if plot_kind.notes
        else base.notes,
        select=base.select,
    )


def _printable_notes(
    notes: Callable[[FigureData], Sequence[str]],
) -> Callable[[FigureData], list[str]]:
    """Return a function like ``notes`` whose sentences have no control characters."""
    return lambda data: [printable(note) for note in notes(data)]


def _call_plugin(kind: str, function: Callable[[FigureData], Any], data: FigureData) -> Any:
    """Call a function of a plug-in; report its errors with their position in the plug-in."""
    try:
        return function(data)
    except Exception as error:
        raise plugin_error(PLOT, kind, error, f" {data.spec.name}") from None
