"""What a figure is and needs, as the registry, study files and the reference know it."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from sim.parameters import NUMERICAL, Parameters


@dataclass(frozen=True)
class FigureSpec:
    """What a study must supply for one figure.

    Attributes
    ----------
    name : str
        Name in study files, targets and file names; also the module that draws it.
    paper : str
        Figure of the paper it reproduces, or what it is about in it.
    system : str
        System of all the points that feed it.
    axes : tuple of str
        Parameters that must take at least two values among those points.
    curves : tuple of str
        Parameters that tell the paper's curves apart; a study may vary them or not.
    title : str
        One line for tables and the report.
    where : mapping
        Values that parameters of a point must have to be drawn, or tuples of values of which each
        must have one; others of a series that feeds the figure are left out.
    regimes : bool
        Whether it shows regimes and the boundaries found between them, rather than velocities.
    particles : bool
        Whether it shows particles, whose states the dataset then keeps.
    animated : bool
        Whether it moves: a GIF with a poster instead of a picture.
    """

    name: str
    paper: str
    system: str
    axes: tuple[str, ...]
    curves: tuple[str, ...]
    title: str
    where: Mapping[str, Any] = field(default_factory=dict)
    regimes: bool = False
    particles: bool = False
    animated: bool = False

    @property
    def draws_curves(self) -> bool:
        """Whether points are joined to curves, on which each has a place of its own."""
        return bool(self.axes) and not self.regimes

    @property
    def taken(self) -> dict[str, str]:
        """Values in ``where`` in words, by parameter."""
        return {name: ", ".join(map(written, _tuple(value))) for name, value in self.where.items()}

    def shows(self, parameters: Parameters) -> bool:
        """Return whether a point with these parameters is among those drawn."""
        return all(self.takes(name, parameters) for name in self.where)

    def takes(self, name: str, parameters: Parameters) -> bool:
        """Return whether a point is not left out for the parameter ``name`` of ``where``."""
        return getattr(parameters, name) in _tuple(self.where[name])

    def place(self, parameters: Parameters) -> tuple[Any, ...]:
        """Return what tells a point from others on the curves: equal ones lie on each other.

        Parameters that set how a point is computed do so only where the figure is about them.
        """
        own = {*self.axes, *self.curves}
        names = type(parameters).model_fields
        return tuple(
            getattr(parameters, name) for name in names if name in own or name not in NUMERICAL
        )

    @property
    def suffixes(self) -> tuple[str, str, str, str]:
        """Of its files: picture, picture that scales or moves, data behind it, caption."""
        return ".png", ".gif" if self.animated else ".svg", ".csv", ".caption.txt"


def _tuple(value: Any) -> tuple[Any, ...]:
    return value if isinstance(value, tuple) else (value,)


def written(value: Any) -> str:
    """Write a value of a parameter for people."""
    return value if isinstance(value, str) else f"{value:g}"
