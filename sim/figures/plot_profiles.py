"""Profiles over the height, each the mean of the replicates of a point: a study's own plot.

Options of a figure: those of `sim.figures.plot_slices`, which draws one profile against another.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from sim.base.statistics import student_half_width
from sim.figures import plot_slices
from sim.figures.beside import beside_notes, draw_beside, values_beside, with_beside
from sim.figures.caption import unsteady_sentence
from sim.figures.data import FigureData
from sim.figures.kind import Kind
from sim.figures.plot import (
    above_zero,
    empty_text,
    groups,
    label_axes,
    legend,
    lost_note,
    named_columns,
    observable_label,
    panels,
    set_log,
    without_note,
)
from sim.figures.plot_slices import ENOUGH, extent_sentence, slices, there
from sim.figures.style import PALE
from sim.figures.units import headed, unit_of
from sim.study.plottable import profiles


def draw(data: FigureData) -> Figure:
    """Draw a line per point, about it the interval of its mean or, of few, its replicates."""
    spec = data.spec
    if spec.options["second"]:
        return plot_slices.draw(data)
    figure, shown = panels(data)
    for axes, rows in shown:
        for style, label, row in groups(data, rows):
            values = placed(data, profile(data, row))
            if values["mean"].isna().all():
                continue
            mean, half, height = (values[name] for name in ("mean", "half_width", "height"))
            axes.plot(mean, height, color=style.colour, linestyle=style.dashes, label=label)
            band: dict[str, Any] = {"color": style.colour, "alpha": 0.15, "linewidth": 0}
            own = values.filter(regex="^replicate")
            if row["completed"] < ENOUGH:
                axes.plot(own, height, color=style.colour, alpha=PALE, linewidth=0.7, zorder=1.5)
            else:
                axes.fill_betweenx(height, mean - half, mean + half, **band)
        if "x" in spec.options["log"]:
            set_log(axes, "x")
    one = profiles(spec.system)[spec.options["show"]]
    empty_text(shown, one.name + there(data))
    beside = draw_beside(data, shown)
    if not spec.options["between"]:
        # Panels share their axes, and limits that are set follow nothing that is drawn later.
        shown[0][0].set_ylim(bottom=min([0.0, *values_beside(data, "y")]))
    unit = unit_of("m", spec.options["units"], spec.system)
    label_axes(figure, shown, observable_label(data, one), headed("height z", unit))
    legend(figure, shown, beside)
    return figure


def profile(data: FigureData, row: Mapping[str, Any]) -> pd.DataFrame:
    """Return a profile of a point, those of its slices that are shown.

    Columns ``height``, ``mean`` over the replicates, ``half_width`` of its 95 % interval and
    ``replicate 1`` and so on, in the units of the plot; not-a-number where nothing is known.
    """
    one = profiles(data.spec.system)[data.spec.options["show"]]
    values, height = slices(data, row, one)
    known = [each[np.isfinite(each)] for each in values.T]
    return pd.DataFrame(
        {
            "height": height,
            "mean": [each.mean() if each.size else np.nan for each in known],
            "half_width": [float(student_half_width(each)) for each in known],
        }
        | {f"replicate {number}": one for number, one in enumerate(values, 1)}
    )


def placed(data: FigureData, found: pd.DataFrame) -> pd.DataFrame:
    """Return a `profile` with not-a-number for what has no place on a logarithmic axis."""
    kept = found.copy()
    for name in found.filter(regex="^(mean|replicate)"):
        kept[name] = above_zero(data, "x", found[name].to_numpy())
    return kept


def table(data: FigureData) -> pd.DataFrame:
    """Return the data behind the profiles, a row per point and slice, units in the headings."""
    if data.spec.options["second"]:
        return plot_slices.table(data)
    spec, one = data.spec, profiles(data.spec.system)[data.spec.options["show"]]
    units = [unit_of(unit, spec.options["units"], spec.system) for unit in (one.unit, "m")]
    known = data.rows[data.rows["completed"] > 0]
    named = named_columns(data, known)
    parts = []
    for (index, row), values in zip(known.iterrows(), _each(data), strict=True):
        own = {name: column[index] for name, column in named.items()}
        columns = {
            f"height [{units[1]}]": values["height"],
            f"{one.name} [{units[0] or '1'}]": values["mean"],
            f"half width of 95 % interval [{units[0] or '1'}]": values["half_width"],
        }
        parts.append(pd.DataFrame(own | columns | {"completed replicates": row["completed"]}))
    headings = [f"height [{units[1]}]", f"{one.name} [{units[0] or '1'}]"]
    found = pd.concat(parts) if parts else pd.DataFrame(columns=[*named, *headings])
    return with_beside(data, found, headings[1], headings[0])


def _each(data: FigureData) -> list[pd.DataFrame]:
    """Return the `profile` of each completed point."""
    known = data.rows[data.rows["completed"] > 0].to_dict("records")
    return [profile(data, {str(name): value for name, value in row.items()}) for row in known]


def notes(data: FigureData) -> list[str]:
    """Return what the caption says of lines and bands."""
    if data.spec.options["second"]:
        return plot_slices.notes(data)
    completed = data.rows["completed"]
    many, few = (completed >= ENOUGH).any(), ((completed > 1) & (completed < ENOUGH)).any()
    pale = f"of fewer than {ENOUGH}, each is a pale line"
    bands = "Bands: Student's 95 % interval of the mean over replicates"
    ends = extent_sentence(data, "Lines")
    unknown = sum(bool(each["mean"].isna().all()) for each in _each(data))
    lacking = [*without_note(unknown, f"a value{there(data)}"), *_notes_on_logarithms(data)]
    rest = [*lacking, unsteady_sentence(data.rows), *beside_notes(data)]
    if many:
        return [ends, f"{bands}; {pale}." if few else f"{bands}.", *rest]
    return [ends, *([f"Lines are means over replicates; {pale}."] if few else []), *rest]


def _notes_on_logarithms(data: FigureData) -> list[str]:
    """Say how many slices a logarithmic axis has no place for."""
    if "x" not in data.spec.options["log"]:
        return []
    means = np.concatenate([np.zeros(0), *(one["mean"].dropna() for one in _each(data))])
    return lost_note(int((means <= 0).sum()), "slices")


KIND = Kind(draw, table=table, notes=notes)
