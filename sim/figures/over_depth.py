"""What figures over the depth of chute flows share: parameters, curves, a logarithmic axis."""

from collections.abc import Iterable, Mapping, Sequence

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.ticker import FixedLocator, NullFormatter

from sim.figures.family import draw_family
from sim.figures.style import CurveStyle, Unjoined, cycled
from sim.parameters import ChuteParameters
from sim.parameters.wording import setting

#: Parameters that their captions give.
NAMED = (
    "angle",
    "restitution",
    "friction",
    "stiffness",
    "tangential_ratio",
    "tangential_exponent",
    "cell",
    "initial_velocity",
    "transient",
    "average",
)


#: Largest half width of an interval, relative to the mean, of flows that a line joins.
_UNKNOWN = 0.5

#: What captions say of lines and of error bars.
JOINED = (
    "Lines join flows that do not accelerate and whose replicates agree on the mean within "
    f"{100 * _UNKNOWN:g} %. Error bars that end in a caret go on beyond the axes."
)
APART = "Curves are drawn a little aside of each other, about the depth that the axis names."

#: Points of print between two curves.
_PITCH = 2.4

#: Depths of the paper's figures, named on the axis wherever they are.
_OF_PAPER = (0.5, 1.24, 2.5, 5, 10, 20, 40)

#: Factor between two depths that both have room for a number.
_ROOM = 1.35


def unjoined(rows: pd.DataFrame) -> pd.Series:
    """Return which flows no line joins: those that accelerate, and means of different flows."""
    unknown = rows["half_width"] > _UNKNOWN * rows["velocity"].abs()
    return (rows["regime"] == "accelerating") | unknown


def draw_curves(
    axes: Axes, rows: pd.DataFrame, keys: Sequence[str], unjoined: Unjoined = unjoined
) -> None:
    """Draw a curve over the depth for each set of the parameters ``keys``, see `draw_family`."""
    names = tuple(ChuteParameters.model_fields)
    draw_family(axes, rows, "depth", keys, names, _look, unjoined, _PITCH)


def _look(names: dict[str, object], index: int) -> tuple[CurveStyle, str]:
    return cycled(index), label(names)


def set_depth_axis(axes: Axes, depths: Iterable[float]) -> None:
    """Make the horizontal axis one of depth, with a tick at each one that was run.

    Those that are too close to one of the paper's, or to each other, have no number.
    """
    axes.set_xscale("log")
    axes.margins(x=0.09)
    every = sorted(set(depths))
    named = [depth for depth in every if depth in _OF_PAPER]
    for depth in every:
        if all(max(depth / other, other / depth) > _ROOM for other in named):
            named.append(depth)
    axes.xaxis.set_major_locator(FixedLocator(sorted(named)))
    axes.xaxis.set_minor_locator(FixedLocator(sorted(set(every) - set(named))))
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.xaxis.set_major_formatter("{x:g}")
    axes.set_xlabel("depth n (particles per σ²)")


def label(names: Mapping[str, object]) -> str:
    """Write the parameters that name a curve for its entry in the legend."""
    return ", ".join(setting("chute", name, value) for name, value in names.items())
