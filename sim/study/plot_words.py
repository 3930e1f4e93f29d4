"""Default titles and caption leads of plots, made from their observables and parameters."""

from sim.parameters import SYSTEMS, field_info
from sim.study.plot_file import PlotFile
from sim.study.plottable import Observable


def default_title(plot: PlotFile, observable: Observable | None, second: Observable | None) -> str:
    """Return the default title of a plot, such as ``Velocity against friction, by angle``."""
    vertical, horizontal = _y_then_x(plot, observable, second)
    what = plot.keys.what.format(name_in_words(vertical.name)) if vertical else "regimes"
    names = [horizontal.name] if horizontal else plot.axis_names
    over = _over_phrase(plot, list(map(name_in_words, names)), horizontal)
    groups = [*(plot.curves or []), *([plot.panels] if plot.panels else [])]
    title = f"{what} {over}" + (
        f", by {' and '.join(map(name_in_words, groups))}" if groups else ""
    )
    return title[0].upper() + title[1:]


def caption_lead(
    plot: PlotFile, observable: Observable | None, second: Observable | None, system: str
) -> str:
    """Return the first sentence of the caption of a plot."""
    vertical, horizontal = _y_then_x(plot, observable, second)
    what = (
        f"{name_in_words(vertical.name).capitalize()}: {vertical.meaning}"
        if vertical
        else "Regimes"
    )
    against = (
        [f"{name_in_words(horizontal.name)} ({horizontal.meaning})"]
        if horizontal
        else [parameter_phrase(system, name) for name in plot.axis_names]
    )
    parts = [f"{what}, {_over_phrase(plot, against, horizontal)}"]
    if plot.curves:
        parts.append("curves: " + ", ".join(parameter_phrase(system, name) for name in plot.curves))
    if plot.panels:
        parts.append(f"panels: {parameter_phrase(system, plot.panels)}")
    return "; ".join(parts) + "."


def _y_then_x(
    plot: PlotFile, observable: Observable | None, second: Observable | None
) -> tuple[Observable | None, Observable | None]:
    """Order two observables as (y, x)."""
    return (second, observable) if second and plot.keys.second == "y" else (observable, second)


def _over_phrase(plot: PlotFile, names: list[str], horizontal: Observable | None) -> str:
    """Return the part of a title that begins with "over" or "against"."""
    pattern = plot.keys.over if horizontal is None else "against {}"
    return pattern.format(" and ".join(names))


def parameter_phrase(system: str, name: str) -> str:
    """Return the name of a parameter in words, with its symbol."""
    row = field_info(SYSTEMS[system])[name]
    return f"{name_in_words(name)} {row.symbol}".strip()


def name_in_words(name: str) -> str:
    """Return a name from a study file in words."""
    return name.replace("_", " ")
