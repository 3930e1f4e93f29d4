"""What a figure is and needs, as the registry, study files and the reference know it."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any


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

    def shows(self, parameters: Any) -> bool:
        """Return whether a point with these parameters is among those drawn."""
        return all(
            getattr(parameters, name) in (value if isinstance(value, tuple) else (value,))
            for name, value in self.where.items()
        )

    @property
    def suffixes(self) -> tuple[str, str, str, str]:
        """Of its files: picture, picture that scales or moves, data behind it, caption."""
        return ".png", ".gif" if self.animated else ".svg", ".csv", ".caption.txt"
