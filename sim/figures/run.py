"""Pictures of one run: its mean velocity over time, its profiles, its particles."""

from io import StringIO
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from sim.dataset.run_file import RunFile
from sim.figures.plot_time_series import thinned
from sim.figures.render import settle
from sim.figures.run_particles import picture
from sim.figures.style import COLOURS, LEVEL, SETTINGS
from sim.figures.units import headed
from sim.parameters import Parameters
from sim.parameters.variables import variables
from sim.study.catalogue.limits import SHARE

#: Inches of a picture's width and height.
SIZE = (7.4, 2.8)


def _look(number: int) -> dict[str, Any]:
    """Return how a replicate is drawn."""
    return {"color": COLOURS[number % len(COLOURS)], "linewidth": 0.9, "alpha": 0.8}


def pictures(run: RunFile, parameters: Parameters) -> dict[str, str]:
    """Return pictures of a run as SVG, by their titles; none of which its replicates know nothing.

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
    """Draw the velocity of each replicate; dotted, where averaging begins."""
    values, time = np.asarray(run["mean_velocity"]), np.asarray(run["time"])
    if not np.isfinite(values).any():
        return None
    figure = Figure(figsize=SIZE, layout="constrained")
    axes = figure.subplots()
    for number, one in enumerate(values):
        known = np.isfinite(one)
        label = f"replicate {number}"
        axes.plot(thinned(time[known]), thinned(one[known]), label=label, **_look(number))
    starts = np.asarray(run["average_start"], float)
    if np.isfinite(starts).any():
        axes.axvline(float(np.nanmean(starts)), **LEVEL)
    axes.set_xlabel(headed("time since the start", "s"))
    axes.set_ylabel(headed("mean velocity", "m/s"))
    if 1 < len(values) <= len(COLOURS):
        figure.legend(loc="outside upper center", ncols=4)
    return figure


def _profiles(run: RunFile, parameters: Parameters, completed: np.ndarray) -> Figure | None:
    """Draw the profiles of every completed replicate, up to where hardly a particle is above."""
    names = "velocity_profile", "packing_profile"
    if not completed.size or not all(name in run for name in names):
        return None
    height = np.asarray(run["height"]) / parameters.diameter
    below = np.cumsum(np.nanmean(np.asarray(run["packing_profile"])[completed], axis=0))
    top = int(np.searchsorted(below, SHARE * below[-1])) + 1
    figure = Figure(figsize=SIZE, layout="constrained")
    panels = figure.subplots(1, len(names), sharey=True)
    for axes, name in zip(panels, names, strict=True):
        for number in completed:
            axes.plot(np.asarray(run[name])[number][:top], height[:top], **_look(number))
        row = variables("profile")[name]
        axes.set_xlabel(headed(row.meaning, "m/s" if row.unit == "m s-1" else ""))
    panels[0].set_ylabel(headed("height", "diameters"))
    return figure
