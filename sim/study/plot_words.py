"""Titles and captions of plots, made from what they show."""

from sim.parameters import SYSTEMS, field_info
from sim.study.plot_file import PlotFile
from sim.study.plottable import Observable

_OVER = {"profiles": "over the height", "time_series": "against time"}


def title_of(one: PlotFile, observable: Observable | None, second: Observable | None) -> str:
    """Return the title of a plot that gives none: ``Velocity against friction, by angle``."""
    shown, other = _in_order(one, observable, second)
    what = plain(shown.name) if shown else "regimes"
    over = _over(one, [plain(other.name)] if other else list(map(plain, one.on_axes)), other)
    by = [*(one.curves or []), *([one.panels] if one.panels else [])]
    replicates = " of each replicate" if one.like == "distribution" else ""
    title = f"{what}{replicates} {over}" + (f", by {' and '.join(map(plain, by))}" if by else "")
    return title[0].upper() + title[1:]


def lead_of(
    one: PlotFile, observable: Observable | None, second: Observable | None, system: str
) -> str:
    """Return the first sentence of the caption of a plot."""
    shown, other = _in_order(one, observable, second)
    what = f"{plain(shown.name).capitalize()}: {shown.meaning}" if shown else "Regimes"
    against = (
        [f"{plain(other.name)} ({other.meaning})"]
        if other
        else [described(system, name) for name in one.on_axes]
    )
    parts = [f"{what}, {_over(one, against, other)}"]
    if one.curves:
        parts.append("curves: " + ", ".join(described(system, name) for name in one.curves))
    if one.panels:
        parts.append(f"panels: {described(system, one.panels)}")
    return "; ".join(parts) + "."


def _in_order(
    one: PlotFile, observable: Observable | None, second: Observable | None
) -> tuple[Observable | None, Observable | None]:
    """Return what is on the vertical axis of two observables before what is on the horizontal."""
    return (second, observable) if second and one.second == "y" else (observable, second)


def _over(one: PlotFile, names: list[str], other: Observable | None) -> str:
    """Say what something is shown over, or against."""
    if other is None and one.like in _OVER:
        return _OVER[one.like]
    return ("over " if one.like == "map" else "against ") + " and ".join(names)


def described(system: str, name: str) -> str:
    """Return a parameter in words with its symbol."""
    row = field_info(SYSTEMS[system])[name]
    return f"{plain(name)} {row.symbol}".strip()


def plain(name: str) -> str:
    """Return a name of a study file in words."""
    return name.replace("_", " ")
