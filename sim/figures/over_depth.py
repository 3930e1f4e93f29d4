"""What figures over the depth of chute flows share: parameters, a logarithmic axis, labels."""

from collections.abc import Iterable, Mapping

from matplotlib.axes import Axes
from matplotlib.ticker import FixedLocator, NullFormatter

from sim.wording import setting

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


#: Depths of the paper's figures, named on the axis wherever they are.
_OF_PAPER = (0.5, 1.24, 2.5, 5, 10, 20, 40)

#: Factor between two depths that both have room for a number.
_ROOM = 1.35


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
