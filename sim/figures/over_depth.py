"""What figures over the depth of chute flows share: parameters, a logarithmic axis, labels."""

from collections.abc import Iterable, Mapping

from matplotlib.axes import Axes
from matplotlib.ticker import FixedLocator, NullLocator

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


def set_depth_axis(axes: Axes, depths: Iterable[float]) -> None:
    """Make the horizontal axis one of depth, with a tick at each one that was run."""
    axes.set_xscale("log")
    axes.margins(x=0.09)
    axes.xaxis.set_major_locator(FixedLocator(sorted(set(depths))))
    axes.xaxis.set_minor_locator(NullLocator())
    axes.xaxis.set_major_formatter("{x:g}")
    axes.set_xlabel("depth n (particles per σ²)")


def label(names: Mapping[str, object]) -> str:
    """Write the parameters that name a curve for its entry in the legend."""
    return ", ".join(setting("chute", name, value) for name, value in names.items())
