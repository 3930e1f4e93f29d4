"""Title and first sentence of the caption of a plot of a study's own."""

from sim.study.plot_contents import PlotContents, in_words, name_in_words, parameter_phrase
from sim.study.plot_file import PlotFile
from sim.study.plottable import Observable

#: Most parameters that a title names.
_MOST_NAMED = 3


def default_title(contents: PlotContents) -> str:
    """Return the default title of a plot, such as ``Velocity against friction, by angle``."""
    plot = contents.plot
    vertical, horizontal = _y_then_x(contents)
    what = plot.keys.what.format(name_in_words(vertical.name)) if vertical else "regimes"
    names = [horizontal.name] if horizontal else contents.axes
    if len(names) > _MOST_NAMED:
        over = plot.keys.over.format(f"{len(names)} parameters")
    else:
        over = _over_phrase(plot, list(map(name_in_words, names)), horizontal)
    colour = [] if plot.keys.observable == "colour" else [plot.colour]
    groups = [name for name in (*(plot.curves or []), *colour, plot.panels) if name]
    title = f"{what} {over}" + (f", by {in_words(map(name_in_words, groups))}" if groups else "")
    return title[0].upper() + title[1:]


def caption_lead(contents: PlotContents) -> str:
    """Return the first sentence of the caption of a plot."""
    plot, system = contents.plot, contents.system
    vertical, horizontal = _y_then_x(contents)
    what = (
        f"{name_in_words(vertical.name).capitalize()}: {vertical.meaning}"
        if vertical
        else "Regimes"
    )
    against = (
        [f"{name_in_words(horizontal.name)} ({horizontal.meaning})"]
        if horizontal
        else [parameter_phrase(system, name) for name in contents.axes]
    )
    parts = [f"{what}, {_over_phrase(plot, against, horizontal)}"]
    if plot.curves:
        parts.append("curves: " + ", ".join(parameter_phrase(system, name) for name in plot.curves))
    if plot.colour and plot.keys.observable != "colour":
        coloured = contents.coloured
        colour = parameter_phrase(system, coloured) if coloured else name_in_words(plot.colour)
        parts.append(f"colour: {colour}")
    if plot.panels:
        parts.append(f"panels: {parameter_phrase(system, plot.panels)}")
    return "; ".join(parts) + "."


def _y_then_x(contents: PlotContents) -> tuple[Observable | None, Observable | None]:
    """Return both observables as (y, x)."""
    observable, second = contents.observable, contents.second
    is_turned = second and contents.plot.keys.second == "y"
    return (second, observable) if is_turned else (observable, second)


def _over_phrase(plot: PlotFile, names: list[str], horizontal: Observable | None) -> str:
    """Return the part of a title that begins with "over" or "against"."""
    pattern = plot.keys.over if horizontal is None else "against {}"
    return pattern.format(in_words(names))
