"""What a kind of plot is, and which there are."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from importlib import import_module
from typing import Any

import pandas as pd
from matplotlib.figure import Figure

from sim.base.additions import fault
from sim.base.words import printable
from sim.figures.animation import Animation
from sim.figures.caption import velocity_notes
from sim.figures.data import FigureData, velocity_table
from sim.study.plot_kinds import PLOT, own_plots

#: Module of each kind, which has it as ``KIND``; imported when a figure of the kind is drawn.
KINDS = {
    "belt_acceleration": "sim.figures.belt_acceleration",
    "belt_animation": "sim.figures.belt_animation",
    "belt_curves": "sim.figures.belt_curves",
    "belt_measures": "sim.figures.belt_measures",
    "belt_onset": "sim.figures.belt_onset",
    "belt_paths": "sim.figures.belt_paths",
    "belt_profiles": "sim.figures.belt_profiles",
    "belt_snapshots": "sim.figures.belt_snapshots",
    "chute_animation": "sim.figures.chute_animation",
    "chute_curves": "sim.figures.chute_curves",
    "chute_measures": "sim.figures.chute_measures",
    "chute_row": "sim.figures.chute_row",
    "plot_curves": "sim.figures.plot_curves",
    "plot_distribution": "sim.figures.plot_distribution",
    "plot_map": "sim.figures.plot_map",
    "plot_profiles": "sim.figures.plot_profiles",
    "plot_time_series": "sim.figures.plot_time_series",
    "regimes": "sim.figures.regimes",
}

#: Before the name of a kind of plots of a study's own.
OWN = "plot_"


def every_point(data: FigureData) -> FigureData:
    """Return the data as they are."""
    return data


@dataclass(frozen=True)
class Kind:
    """A kind of plot: functions of the data of a figure, whose entry of the catalogue is in them.

    Attributes
    ----------
    draw : callable
        Returns the picture, or an animation of a kind that moves.
    table : callable
        Returns the data behind the picture, units in the headings.
    notes : callable
        Returns the sentences of the caption on error bars, markers and the like.
    select : callable
        Narrows the points, of which there is at least one, to those drawn.
    """

    draw: Callable[[FigureData], Figure | Animation]
    table: Callable[[FigureData], pd.DataFrame] = velocity_table
    notes: Callable[[FigureData], list[str]] = velocity_notes
    select: Callable[[FigureData], FigureData] = every_point


def load_kind(name: str) -> Kind:
    """Return the kind of plot of a name, of Talus or of a plug-in."""
    if name in KINDS:
        return import_module(KINDS[name]).KIND
    kind = name.removeprefix(OWN)
    one = own_plots()[kind]
    base = load_kind(OWN + one.like)
    return Kind(
        partial(_called, kind, one.draw),
        table=partial(_called, kind, one.table) if one.table else base.table,
        notes=partial(_called, kind, _shown(one.notes)) if one.notes else base.notes,
        select=base.select,
    )


def _shown(notes: Callable[[FigureData], Sequence[str]]) -> Callable[[FigureData], list[str]]:
    """Return a function for notes in which nothing moves a cursor or turns the letters."""
    return lambda data: [printable(note) for note in notes(data)]


def _called(kind: str, function: Callable[[FigureData], Any], data: FigureData) -> Any:
    """Call a function of a plug-in, whose mistakes are told with their place in it."""
    try:
        return function(data)
    except Exception as error:
        raise fault(PLOT, kind, error, f" {data.spec.name}") from None
