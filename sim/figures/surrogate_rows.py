"""What the pictures of a surrogate show, as tables: sections, maps, runs, and sentences on them."""

from itertools import islice, product
from typing import Any

import numpy as np
import pandas as pd

from sim.base.statistics import MANY, student
from sim.figures.data import FigureData
from sim.figures.units import parameter_heading
from sim.parameters.words import setting
from sim.study.design import Axis
from sim.surrogates.fit import counted_probability
from sim.surrogates.sample import unit_cube
from sim.surrogates.storage import load_surrogate
from sim.surrogates.surrogate import Surrogate

#: Values along a section, and along each side of a map.
SECTION_STEPS, MAP_STEPS = 161, 61

#: Runs are near a section where each other parameter is within this share of its range.
NEAR = 0.25

#: Most combinations of words and switches that have a curve or a panel of their own.
_MOST_SETTINGS = 4


def find_surrogate(data: FigureData) -> tuple[Surrogate, list[Axis]]:
    """Return the surrogate that a figure shows, and the parameters on its axes."""
    surrogate: Surrogate = data.read_answer(load_surrogate)
    answer = data.spec.answer
    axes = {axis.name: axis for axis in surrogate.axes}
    return surrogate, [axes[name] for name in (answer.x, answer.y) if name]


def shown_settings(surrogate: Surrogate) -> list[dict[str, Any]]:
    """Return combinations of the words and switches, no more than are shown."""
    choices = surrogate.choices
    every = (dict(zip(choices, values, strict=True)) for values in product(*choices.values()))
    return list(islice(every, _MOST_SETTINGS))


def _steps(axis: Axis, count: int) -> np.ndarray:
    spread = np.geomspace if axis.scale == "log" else np.linspace
    return np.clip(spread(axis.low, axis.high, count), axis.low, axis.high)


def _middle(axis: Axis) -> float:
    return float(f"{_steps(axis, 3)[1]:.3g}")


def _predictions(
    surrogate: Surrogate, columns: dict[str, np.ndarray], chosen: dict[str, Any]
) -> pd.DataFrame:
    """Return predictions at values (n,) of some parameters, the others in the middle."""
    count = len(next(iter(columns.values())))
    rows = pd.DataFrame(
        {
            axis.name: columns.get(axis.name, np.full(count, _middle(axis)))
            for axis in surrogate.numeric
        }
    )
    there, x = surrogate.at(**chosen), rows.to_numpy()
    rows["mean"], error = there.predict(x)
    likely = counted_probability(there, there.probability(x))
    return rows.assign(half_width=student(MANY) * error, probability=likely, **chosen)


def section_rows(surrogate: Surrogate, axis: Axis, chosen: dict[str, Any]) -> pd.DataFrame:
    """Return predictions along a parameter."""
    return _predictions(surrogate, {axis.name: _steps(axis, SECTION_STEPS)}, chosen)


def surface_rows(surrogate: Surrogate, x: Axis, y: Axis, chosen: dict[str, Any]) -> pd.DataFrame:
    """Return predictions over two parameters, those along ``x`` in turn for each ``y``."""
    up, across = np.meshgrid(_steps(y, MAP_STEPS), _steps(x, MAP_STEPS), indexing="ij")
    return _predictions(surrogate, {x.name: across.ravel(), y.name: up.ravel()}, chosen)


def run_rows(surrogate: Surrogate, chosen: dict[str, Any]) -> pd.DataFrame:
    """Return the runs at a choice of words and switches; ``in_mean`` are those of the mean."""
    sample = surrogate.sample
    names = ["point", *(axis.name for axis in surrogate.axes), "mean"]
    rows = pd.DataFrame({name: sample[name].values for name in names})
    rows["in_mean"], rows["half_width"] = surrogate.in_mean, np.nan
    errors = student(MANY) * surrogate.leave_one_out["run_error"].values
    rows.loc[surrogate.in_mean, "half_width"] = errors
    is_chosen = [rows[name] == value for name, value in chosen.items()]
    return rows[np.all(is_chosen, axis=0)] if is_chosen else rows


def near_rows(surrogate: Surrogate, axis: Axis, chosen: dict[str, Any]) -> pd.DataFrame:
    """Return the runs near a section, moved onto it by what the surrogate says."""
    rows = run_rows(surrogate, chosen)
    rows = rows[rows["in_mean"]].drop(columns="in_mean")
    others = tuple(one for one in surrogate.numeric if one.name != axis.name)
    if others and len(rows):
        cube = unit_cube(others, {one.name: rows[one.name].to_numpy() for one in others})
        middle = unit_cube(others, {one.name: np.array([_middle(one)]) for one in others})
        rows = rows[(np.abs(cube - middle) <= NEAR).all(axis=1)]
    if others and len(rows):
        here, _ = surrogate.at(**chosen).predict(rows[list(surrogate.parameters)].to_numpy(float))
        there = _predictions(surrogate, {axis.name: rows[axis.name].to_numpy(float)}, chosen)
        rows = rows.assign(mean=rows["mean"] + there["mean"].to_numpy() - here)
    return rows


def agreement_rows(surrogate: Surrogate) -> pd.DataFrame:
    """Return each run of the mean beside what the others predict of it."""
    predicted, normal = surrogate.leave_one_out, float(student(MANY))
    rows = run_rows(surrogate, {})
    rows = rows[rows["in_mean"]].drop(columns="in_mean")
    rows = rows.rename(columns={"mean": "run", "half_width": "run_half_width"})
    return rows.assign(
        predicted=predicted["mean"].values, predicted_half_width=normal * predicted["error"].values
    )


#: Columns in the unit of the observable, and their headings.
_OF_OBSERVABLE = {
    "mean": "mean",
    "half_width": "half width of 95 % interval",
    "run": "run",
    "run_half_width": "half width of 95 % interval of the run",
    "predicted": "predicted from the other runs",
    "predicted_half_width": "half width of 95 % interval of the prediction",
}


def with_units(surrogate: Surrogate, rows: pd.DataFrame) -> pd.DataFrame:
    """Return a table with units in its headings."""
    headings = {name: f"{words} [{surrogate.unit}]" for name, words in _OF_OBSERVABLE.items()}
    names = [axis.name for axis in surrogate.axes]
    headings |= {name: parameter_heading(surrogate.system, name) for name in names}
    headings["probability"] = f"probability of {' or '.join(surrogate.mean_regimes)}"
    return rows.rename(columns=headings)


def held_note(surrogate: Surrogate, *shown: str) -> str:
    """Return the sentence on the parameters that are not on an axis."""
    others = [
        setting(surrogate.system, axis.name, _middle(axis))
        for axis in surrogate.numeric
        if axis.name not in shown
    ]
    return f"Held: {', '.join(others)}." if others else ""


def regime_note(surrogate: Surrogate, where: str) -> str:
    """Return the sentence on where the mean means nothing, as another regime is likelier."""
    others = [name for name in surrogate.regimes.names if name not in surrogate.mean_regimes]
    if not others:
        return ""
    return (
        f"{where} another regime ({' or '.join(others)}) is likelier than "
        f"{' or '.join(surrogate.mean_regimes)}."
    )
