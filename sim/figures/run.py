"""Pictures of one run: its mean velocity over time, its profiles, its particles."""

from io import StringIO
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from sim.dataset.run_file import RunFile
from sim.figures.render import settle
from sim.figures.run_particles import picture
from sim.figures.style import COLOURS, LEVEL, SETTINGS
from sim.figures.time_series import average_successive
from sim.figures.units import label_with_unit
from sim.parameters import Parameters
from sim.parameters.variables import variables_of
from sim.study.figure_spec import SHARE

#: Inches of a picture's width and height.
SIZE = (7.4, 2.8)


def _look(number: int) -> dict[str, Any]:
    """Return the style of the lines of a replicate."""
    return {"color": COLOURS[number % len(COLOURS)], "linewidth": 0.9, "alpha": 0.8}


def pictures(run: RunFile, parameters: Parameters) -> dict[str, str]:
    """Return pictures of a run as SVG texts, by title; pictures without data are left out.

    Parameters
    ----------
    run : RunFile
        The run.
    parameters : Parameters
        Its point.
    """
    completed = np.flatnonzero(np.asarray(run["status"]) == "completed")
    with mpl.rc_context(SETTINGS):
        drawn = {
            "Mean velocity of all particles": _series(run),
            "Profiles over the height": _profiles(run, parameters, completed),
            "Particles of the first completed replicate at the end": picture(run, parameters),
        }
        return {title: _as_svg(figure) for title, figure in drawn.items() if figure}


def _as_svg(figure: Figure) -> str:
    settle(figure)
    text = StringIO()
    figure.savefig(text, format="svg", metadata={"Date": None})
    return text.getvalue()


def _series(run: RunFile) -> Figure | None:
    """Draw the velocity of each replicate, and a dotted line where averaging begins.

    None without any finite velocity.
    """
    values, time = np.asarray(run["mean_velocity"]), np.asarray(run["time"])
    if not np.isfinite(values).any():
        return None
    figure = Figure(figsize=SIZE, layout="constrained")
    axes = figure.subplots()
    for number, velocity in enumerate(values):
        is_known = np.isfinite(velocity)
        label = f"replicate {number}"
        axes.plot(
            average_successive(time[is_known]),
            average_successive(velocity[is_known]),
            label=label,
            **_look(number),
        )
    starts = np.asarray(run["average_start"], float)
    if np.isfinite(starts).any():
        axes.axvline(float(np.nanmean(starts)), **LEVEL)
    axes.set_xlabel(label_with_unit("time since the start", "s"))
    axes.set_ylabel(label_with_unit("mean velocity", "m/s"))
    if 1 < len(values) <= len(COLOURS):
        figure.legend(loc="outside upper center", ncols=4)
    return figure


def _profiles(run: RunFile, parameters: Parameters, completed: np.ndarray) -> Figure | None:
    """Draw the profiles of all completed replicates, up to the height below which `SHARE` is.

    None without a completed replicate or without profiles.
    """
    names = "velocity_profile", "packing_profile"
    if not completed.size or not all(name in run for name in names):
        return None
    height = np.asarray(run["height"]) / parameters.diameter
    cumulative = np.cumsum(np.nanmean(np.asarray(run["packing_profile"])[completed], axis=0))
    top = int(np.searchsorted(cumulative, SHARE * cumulative[-1])) + 1
    figure = Figure(figsize=SIZE, layout="constrained")
    panels = figure.subplots(1, len(names), sharey=True)
    for axes, name in zip(panels, names, strict=True):
        for number in completed:
            axes.plot(np.asarray(run[name])[number][:top], height[:top], **_look(number))
        row = variables_of("profile")[name]
        axes.set_xlabel(label_with_unit(row.meaning, "m/s" if row.unit == "m s-1" else ""))
    panels[0].set_ylabel(label_with_unit("height", "diameters"))
    return figure
