"""Titles and captions of plots, made from what they show."""

from sim.parameters import SYSTEMS, field_info
from sim.study.plot_file import PlotFile
from sim.study.plottable import Observable

_OVER = {"profiles": "over the height", "time_series": "against time"}


def title_of(one: PlotFile, observable: Observable | None, second: Observable | None) -> str:
    """Return the title of a plot that gives none: ``Velocity against friction, by angle``."""
    what = plain(observable.name) if observable else "regimes"
    over = _over(one, [plain(second.name)] if second else list(map(plain, one.on_axes)))
    by = [*(one.curves or []), *([one.panels] if one.panels else [])]
    replicates = " of each replicate" if one.like == "distribution" else ""
    title = f"{what}{replicates} {over}" + (f", by {' and '.join(map(plain, by))}" if by else "")
    return title[0].upper() + title[1:]


def lead_of(
    one: PlotFile, observable: Observable | None, second: Observable | None, system: str
) -> str:
    """Return the first sentence of the caption of a plot."""
    name = plain(observable.name).capitalize() if observable else ""
    what = f"{name}: {observable.meaning}" if observable else "Regimes"
    against = (
        [f"{plain(second.name)} ({second.meaning})"]
        if second
        else [described(system, name) for name in one.on_axes]
    )
    parts = [f"{what}, {_over(one, against)}"]
    if one.curves:
        parts.append("curves: " + ", ".join(described(system, name) for name in one.curves))
    if one.panels:
        parts.append(f"panels: {described(system, one.panels)}")
    return "; ".join(parts) + "."


def _over(one: PlotFile, names: list[str]) -> str:
    """Say what something is shown against, or over."""
    named = ("over " if one.like == "map" else "against ") + " and ".join(names)
    return _OVER.get(one.like, named)


def described(system: str, name: str) -> str:
    """Return a parameter in words with its symbol."""
    row = field_info(SYSTEMS[system])[name]
    return f"{plain(name)} {row.symbol}".strip()


def plain(name: str) -> str:
    """Return a name of a study file in words."""
    return name.replace("_", " ")
