"""Pictures of one run: its mean velocity over time, its profiles, its particles."""

from io import StringIO
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import EllipseCollection
from matplotlib.figure import Figure

from sim.dataset.run_file import RunFile
from sim.figures.plot_time_series import thinned
from sim.figures.render import settle
from sim.figures.style import COLOURS, LEVEL, SETTINGS
from sim.figures.units import headed
from sim.parameters import Parameters
from sim.parameters.observables import PROFILES
from sim.study.catalogue.limits import SHARE

#: Inches of a picture's width, of its height, and at most of the height of one of particles and of
#: a diameter in it.
WIDTH, HEIGHT, TALLEST, LARGEST = 7.4, 2.8, 6.0, 0.5

#: Particles from which on a picture holds pixels, not outlines.
MANY = 1500

#: The velocities between which colours differ, as shares of the particles: a single fast one would
#: make all others one colour.
_SHOWN = (0.02, 0.98)

_REPLICATE = {"linewidth": 0.9, "alpha": 0.8}

#: The line at z = 0.
_BELOW = {"chute": "plane", "belt": "average position of the belt"}


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
            "Particles of the first completed replicate at the end": _particles(
                run, parameters, completed
            ),
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
    figure = Figure(figsize=(WIDTH, HEIGHT), layout="constrained")
    axes = figure.subplots()
    for number, one in enumerate(values):
        known = np.isfinite(one)
        look: dict[str, Any] = {"color": COLOURS[number % len(COLOURS)], **_REPLICATE}
        axes.plot(thinned(time[known]), thinned(one[known]), label=f"replicate {number}", **look)
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
    figure = Figure(figsize=(WIDTH, HEIGHT), layout="constrained")
    panels = figure.subplots(1, len(names), sharey=True)
    for axes, name in zip(panels, names, strict=True):
        for number in completed:
            look: dict[str, Any] = {"color": COLOURS[number % len(COLOURS)], **_REPLICATE}
            axes.plot(np.asarray(run[name])[number][:top], height[:top], **look)
        unit, meaning = PROFILES[name]
        axes.set_xlabel(headed(meaning, "m/s" if unit == "m s-1" else ""))
    panels[0].set_ylabel(headed("height", "diameters"))
    return figure


def _particles(run: RunFile, parameters: Parameters, completed: np.ndarray) -> Figure | None:
    """Draw particles from the side, those at the front last, coloured by velocity along x."""
    if not completed.size or "position" not in run:
        return None
    first, axes_names = completed[0], list(run["axis"])
    position = np.asarray(run["position"])[first, -1]
    speed = np.asarray(run["particle_velocity"])[first, -1, :, 0]
    order = np.argsort(-position[:, 1]) if "y" in axes_names else np.arange(len(position))
    x, z = position[order, 0], position[order, -1]
    wide = parameters.period
    place = np.column_stack([np.mod(x, wide), z]) / parameters.diameter
    size = 2 * np.asarray(run["radius"])[first][order] / parameters.diameter
    figure, axes = _to_scale(place, size, wide / parameters.diameter)
    held = EllipseCollection(
        size,
        size,
        np.zeros_like(size),
        units="xy",
        offsets=place,
        offset_transform=axes.transData,
        array=speed[order],
        clim=np.quantile(speed, _SHOWN),
        cmap="cividis",
        edgecolors="black",
        linewidths=0.3,
        rasterized=len(size) > MANY,
    )
    axes.add_collection(held)
    figure.colorbar(
        held, ax=axes, label=headed("velocity along x", "m/s"), extend="both", shrink=0.9
    )
    axes.axhline(0, color="black", linewidth=1.3)
    axes.set_xlabel(headed("x", "diameters") + f"; the line is the {_BELOW[parameters.system]}")
    return figure


def _to_scale(place: np.ndarray, size: np.ndarray, wide: float) -> tuple[Figure, Axes]:
    """Return a figure with axes that show particles to scale."""
    low = min(0.0, float((place[:, 1] - size / 2).min())) - 0.3
    high = float((place[:, 1] + size / 2).max()) + 0.3
    scale = min((WIDTH - 2) / wide, TALLEST / (high - low), LARGEST)
    shape = max(4.0, wide * scale + 2), max(2.0, (high - low) * scale + 0.7)
    figure = Figure(figsize=shape, layout="compressed")
    axes = figure.subplots()
    axes.set(xlim=(0, wide), ylim=(low, high), aspect="equal")
    axes.set_ylabel(headed("z", "diameters"))
    axes.grid(visible=False)
    return figure, axes
