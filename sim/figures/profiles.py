"""Profiles over the height, means over the replicates of a point: a plot that a study file defines.

Options of a figure: those of `sim.figures.profile_pairs`, which draws one profile against another.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from sim.base.statistics import student_half_width
from sim.figures import belt_profiles, profile_pairs
from sim.figures.axes import set_log
from sim.figures.caption import unsteady_sentence
from sim.figures.data import FigureData
from sim.figures.foreign_data import (
    append_foreign_data,
    draw_foreign_data,
    foreign_data_notes,
    foreign_values,
)
from sim.figures.plot import (
    above_zero,
    groups,
    label_axes,
    legend,
    missing_value_note,
    named_columns,
    nonpositive_note,
    observable_label,
    panels,
    write_no_data,
)
from sim.figures.profile_pairs import MIN_REPLICATES, extent_sentence, height_range_suffix, slices
from sim.figures.style import PALE
from sim.figures.units import label_with_unit, unit_of
from sim.study.plottable import profiles


def _other_module(data: FigureData) -> Any:
    """Return the module that draws a paper's profiles of the belt, or one against another."""
    if data.spec.paper and data.spec.system == "belt":
        return belt_profiles
    return profile_pairs if data.spec.options["second"] else None


def draw(data: FigureData) -> Figure:
    """Draw a line per point, with a band of its interval or, for few replicates, all of these."""
    spec = data.spec
    if module := _other_module(data):
        return module.draw(data)
    figure, shown = panels(data)
    for axes, rows in shown:
        for style, label, row in groups(data, rows):
            values = mask_nonpositive(data, point_profile(data, row))
            if values["mean"].isna().all():
                continue
            mean, half, height = (values[name] for name in ("mean", "half_width", "height"))
            axes.plot(mean, height, color=style.colour, linestyle=style.dashes, label=label)
            band: dict[str, Any] = {"color": style.colour, "alpha": 0.15, "linewidth": 0}
            replicates = values.filter(regex="^replicate")
            if row["completed"] < MIN_REPLICATES:
                axes.plot(
                    replicates, height, color=style.colour, alpha=PALE, linewidth=0.7, zorder=1.5
                )
            else:
                axes.fill_betweenx(height, mean - half, mean + half, **band)
        if "x" in spec.options["log"]:
            set_log(axes, "x")
    observable = profiles(spec.system)[spec.options["show"]]
    write_no_data(shown, observable.name + height_range_suffix(data))
    foreign = draw_foreign_data(data, shown)
    if not spec.options["between"]:
        # Panels share their axes, and set limits do not follow later data.
        shown[0][0].set_ylim(bottom=min([0.0, *foreign_values(data, "y")]))
    unit = unit_of("m", spec.options["units"], spec.system)
    label_axes(figure, shown, observable_label(data, observable), label_with_unit("height z", unit))
    legend(figure, shown, foreign)
    return figure


def point_profile(data: FigureData, row: Mapping[str, Any]) -> pd.DataFrame:
    """Return the shown slices of a profile of a point, in the units of the plot.

    Columns are ``height``, ``mean`` over the replicates, ``half_width`` of its 95 % interval, and
    ``replicate 1`` and so on. Unknown values are not-a-number.
    """
    observable = profiles(data.spec.system)[data.spec.options["show"]]
    values, height = slices(data, row, observable)
    samples = [sample[np.isfinite(sample)] for sample in values.T]
    return pd.DataFrame(
        {
            "height": height,
            "mean": [sample.mean() if sample.size else np.nan for sample in samples],
            "half_width": [float(student_half_width(sample)) for sample in samples],
        }
        | {f"replicate {number}": observable for number, observable in enumerate(values, 1)}
    )


def mask_nonpositive(data: FigureData, rows: pd.DataFrame) -> pd.DataFrame:
    """Return a `point_profile` with not-a-number for values ≤ 0 on a logarithmic axis."""
    masked = rows.copy()
    for name in rows.filter(regex="^(mean|replicate)"):
        masked[name] = above_zero(data, "x", rows[name].to_numpy())
    return masked


def table(data: FigureData) -> pd.DataFrame:
    """Return the plotted data, a row per point and slice, units in the headings."""
    if module := _other_module(data):
        return module.table(data)
    spec, observable = data.spec, profiles(data.spec.system)[data.spec.options["show"]]
    units = [unit_of(unit, spec.options["units"], spec.system) for unit in (observable.unit, "m")]
    completed = data.rows[data.rows["completed"] > 0]
    id_columns = named_columns(data, completed)
    parts = []
    for (index, row), values in zip(completed.iterrows(), _profiles_of_points(data), strict=True):
        point_columns = {name: column[index] for name, column in id_columns.items()}
        columns = {
            f"height [{units[1]}]": values["height"],
            f"{observable.name} [{units[0] or '1'}]": values["mean"],
            f"half width of 95 % interval [{units[0] or '1'}]": values["half_width"],
        }
        parts.append(
            pd.DataFrame(point_columns | columns | {"completed replicates": row["completed"]})
        )
    headings = [f"height [{units[1]}]", f"{observable.name} [{units[0] or '1'}]"]
    rows = pd.concat(parts) if parts else pd.DataFrame(columns=[*id_columns, *headings])
    return append_foreign_data(data, rows, headings[1], headings[0])


def _profiles_of_points(data: FigureData) -> list[pd.DataFrame]:
    """Return the `point_profile` of each completed point."""
    completed = data.rows[data.rows["completed"] > 0].to_dict("records")
    return [
        point_profile(data, {str(name): value for name, value in row.items()}) for row in completed
    ]


def notes(data: FigureData) -> list[str]:
    """Return the sentences of the caption on lines and bands."""
    if module := _other_module(data):
        return module.notes(data)
    completed = data.rows["completed"]
    many, few = (
        (completed >= MIN_REPLICATES).any(),
        ((completed > 1) & (completed < MIN_REPLICATES)).any(),
    )
    pale = f"of fewer than {MIN_REPLICATES}, each is a pale line"
    bands = "Bands: Student's 95 % interval of the mean over replicates"
    ends = extent_sentence(data, "Lines")
    missing = sum(bool(rows["mean"].isna().all()) for rows in _profiles_of_points(data))
    omissions = [
        *missing_value_note(missing, f"a value{height_range_suffix(data)}"),
        *_notes_on_logarithms(data),
    ]
    rest = [*omissions, unsteady_sentence(data.rows), *foreign_data_notes(data)]
    if many:
        return [ends, f"{bands}; {pale}." if few else f"{bands}.", *rest]
    return [ends, *([f"Lines are means over replicates; {pale}."] if few else []), *rest]


def _notes_on_logarithms(data: FigureData) -> list[str]:
    """Return the caption note on the slices omitted from a logarithmic axis."""
    if "x" not in data.spec.options["log"]:
        return []
    means = np.concatenate(
        [np.zeros(0), *(rows["mean"].dropna() for rows in _profiles_of_points(data))]
    )
    return nonpositive_note(int((means <= 0).sum()), "slices")
