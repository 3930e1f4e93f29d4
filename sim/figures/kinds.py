"""Kinds of plot that ship: their keys, and what draws them, named as ``module`` or ``module:name``.

What draws has the functions ``draw``, ``table`` and ``notes`` of the data of a figure, and maybe
``select``. It is imported when one of them is first called: study files are checked without it.
"""

from typing import Any

from sim.base.additions import TALUS, add, attribute_additions_to
from sim.study.plot_kinds import PLOT, REGIME, Keys, PlotKind, Shown
from sim.study.plottable import numbers, profiles, series


def _declare(name: str, drawing: str, **keys: Any) -> None:
    """Declare a kind of plot that a module of `sim.figures`, or an object in one, draws."""
    add(PLOT, name, PlotKind(Keys(**keys), f"sim.figures.{drawing}"))


with attribute_additions_to(TALUS):
    _declare(
        "curves",
        "curves",
        axes=("x",),
        observable="y",
        shows=numbers,
        second="x",
        log=("x", "y"),
        others=("curves", "panels", "beside", "fit"),
        of_papers="x y curves panels log units fit labels levels level quantities styles entry "
        "relative alike widest",
        systems=("chute", "belt"),
    )
    _declare(
        "map",
        "map",
        axes=("x", "y"),
        observable="colour",
        usual=REGIME,
        shows=numbers,
        log=("x", "y", "colour"),
        others=("panels", "beside"),
        of_papers="x y curves log labels theory creep point",
        systems=("chute", "belt"),
        over="over {}",
    )
    _declare(
        "profiles",
        "profiles",
        observable="x",
        shows=profiles,
        second="y",
        log=("x",),
        others=("curves", "panels", "between", "beside"),
        of_papers="x y curves panels between log units vary labels quantities styles entry flat",
        over="over the height",
    )
    _declare(
        "time_series",
        "time_series",
        observable="y",
        shows=series,
        log=("x", "y"),
        others=("curves", "panels"),
        over="against time",
        from_runs=True,
    )
    _declare(
        "distribution",
        "distribution",
        axes=("x",),
        observable="y",
        shows=numbers,
        log=("y",),
        others=("curves", "panels"),
        what="{} of each replicate",
    )
    _declare(
        "likelihood",
        "likelihood",
        axes=("x",),
        observable="y",
        shows=numbers,
        others=("curves", "panels"),
        what="probability that a single run per point rises in {}",
    )
    _declare(
        "scatter",
        "scatter",
        axes=("x",),
        observable="y",
        shows=numbers,
        second="x",
        log=("x", "y", "colour"),
        others=("colour", "panels", "beside"),
    )
    _declare(
        "main_effects",
        "main_effects",
        several="parameters",
        observable="y",
        shows=numbers,
        log=("y",),
    )

    # Of papers alone.
    _declare("row", "row", systems=("chute",), particles=Shown.STATE)
    _declare("paths", "beads:PATHS", systems=("belt",), particles=Shown.PATH)
    _declare("snapshots", "beads:SNAPSHOTS", systems=("belt",), particles=Shown.STATE)
    _declare(
        "animation",
        "animation",
        of_papers="point",
        systems=("chute", "belt"),
        particles=Shown.PATH,
        animated=True,
    )

    # Of answers to questions, which take no keys.
    _declare("section", "surrogates:SECTION")
    _declare("surface", "surrogates:SURFACE")
    _declare("agreement", "surrogates:AGREEMENT")
    _declare("indices", "sensitivity:INDICES")
    _declare("interactions", "sensitivity:INTERACTIONS")
    _declare("screening", "sensitivity:SCREENING")
    _declare("posterior", "calibration:POSTERIOR")
    _declare("predictions", "calibration:PREDICTIONS")
    _declare("experiment", "calibration:EXPERIMENT")
