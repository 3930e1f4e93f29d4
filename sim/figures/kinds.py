"""Kinds of plot that ship: their keys, and what draws them, named as ``module`` or ``module:name``.

What draws has the functions ``draw``, ``table`` and ``notes`` of the data of a figure, and maybe
``select``. It is imported when one of them is first called: study files are checked without it.
"""

from typing import Any

from sim.base.additions import TALUS, add, attribute_additions_to
from sim.study.plottable import PLOT, REGIME, Keys, PlotKind, Shown, numbers, profiles, series

#: Keys of a kind that shows a number of each point along a parameter.
_ALONG: dict[str, Any] = {"axes": ("x",), "observable": "y", "shows": numbers}

#: Answers to questions, which take no keys, by the module that draws them.
_ANSWERS = {
    "surrogates": ("section", "surface", "agreement"),
    "sensitivity": ("indices", "interactions", "screening", "spread"),
    "calibration": ("posterior", "predictions", "experiment"),
}


def _declare(name: str, drawing: str = "", **keys: Any) -> None:
    """Declare a kind of plot that a module of `sim.figures`, or an object in one, draws."""
    add(PLOT, name, PlotKind(Keys(**keys), f"sim.figures.{drawing or name}"))


with attribute_additions_to(TALUS):
    _declare(
        "curves",
        **_ALONG,
        second="x",
        log=("x", "y"),
        others=("curves", "panels", "beside", "fit"),
        of_papers="units labels levels level quantities styles entry relative alike widest "
        "joins_open",
    )
    _declare(
        "map",
        axes=("x", "y"),
        observable="colour",
        usual=REGIME,
        shows=numbers,
        log=("x", "y", "colour"),
        others=("panels", "beside", "fit"),
        of_papers="curves labels theory creep point",
        over="over {}",
    )
    _declare(
        "profiles",
        observable="x",
        shows=profiles,
        second="y",
        log=("x",),
        others=("curves", "panels", "between", "beside"),
        of_papers="units vary labels quantities styles entry flat",
        over="over the height",
    )
    _declare(
        "time_series",
        "replicates:TIME_SERIES",
        observable="y",
        shows=series,
        log=("x", "y"),
        others=("curves", "panels"),
        over="against time",
        from_runs=True,
    )
    each = "{} of each replicate"
    _declare(
        "distribution",
        "replicates:DISTRIBUTION",
        **_ALONG,
        log=("y",),
        others=("curves", "panels"),
        what=each,
    )
    chance = "probability that a single run per point rises in {}"
    _declare(
        "likelihood", "replicates:LIKELIHOOD", **_ALONG, others=("curves", "panels"), what=chance
    )
    _declare(
        "scatter",
        **_ALONG,
        second="x",
        log=("x", "y", "colour"),
        others=("colour", "panels", "beside"),
    )
    _declare(
        "main_effects",
        "scatter:MAIN_EFFECTS",
        several="parameters",
        observable="y",
        shows=numbers,
        log=("y",),
    )

    # Of papers alone.
    _declare("row", "spheres", systems=("chute",), particles=Shown.STATE)
    _declare("paths", "beads:PATHS", systems=("belt",), particles=Shown.PATH)
    _declare("snapshots", "beads:SNAPSHOTS", systems=("belt",), particles=Shown.STATE)
    moves: dict[str, Any] = {"particles": Shown.PATH, "animated": True, "of_papers": "point"}
    _declare("animation", systems=("chute", "belt"), **moves)

    for module, names in _ANSWERS.items():
        for name in names:
            _declare(name, f"{module}:{name.upper()}")
