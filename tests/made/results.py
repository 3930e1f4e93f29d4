"""Made-up results for judges: points with known numbers and profiles, without files."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
import pandas as pd
import xarray as xr
from scipy.special import ndtri

from sim.dataset.replicates import outcomes
from sim.dataset.results import Results
from sim.parameters import SYSTEMS, Parameters, complete_values, field_info, parse_point, point_id

#: A number, one per replicate, or a word.
ScalarValues = float | str | Sequence[float]

#: Default scatter of replicates relative to the value.
SCATTER = 1e-3

#: Default height of a slice, in diameters, and default number of slices.
SLICE = {"chute": 0.25, "belt": 1.0}
SLICES = 200

#: Default values of every completed replicate.
USUAL = {
    "regime": "steady",
    "quality": "reliable",
    "stopped": "length",
    "status": "completed",
    "reason": "",
    "independent_samples": 50.0,
    "acceleration": 0.0,
    "acceleration_half_width": 1e-6,
}


@dataclass(frozen=True)
class MadePoint:
    """A point, its scalars per replicate (R,) by name, its profiles (R, H) and their heights."""

    parameters: Parameters
    scalars: Mapping[str, np.ndarray]
    profiles: Mapping[str, np.ndarray] = field(default_factory=dict)
    height: np.ndarray | None = None

    @property
    def id(self) -> str:
        """Name of the point."""
        return point_id(self.parameters)


def spread(replicates: int) -> np.ndarray:
    """Return fixed numbers with mean 0, standard deviation 1 and a normal distribution."""
    if replicates == 1:
        return np.zeros(1)
    values = ndtri((np.arange(replicates) + 0.5) / replicates)
    return values / values.std(ddof=1)


def made_point(
    system: str,
    scalars: Mapping[str, ScalarValues] | None = None,
    profiles: Mapping[str, Callable[[np.ndarray], np.ndarray] | np.ndarray] | None = None,
    *,
    replicates: int = 5,
    scatter: float = SCATTER,
    height: np.ndarray | None = None,
    **parameters: object,
) -> MadePoint:
    """Return a point; omitted values are those of a good run.

    Parameters
    ----------
    system : {'chute', 'belt'}
    scalars : mapping, optional
        SI values by name of anything in `sim.parameters.variables.SCALARS` or of measures: one
        number (replicates then scatter about it), one per replicate, or a word.
    profiles : mapping, optional
        By name: a function of the heights (m), whose values then scatter over replicates as a
        whole, or an array (replicate, slice). Those named ``column_...`` run along the belt.
    replicates : int
        All of them completed.
    scatter : float
        Standard deviation of replicates, relative to the value.
    height : (H,) array, optional
        Centres of the slices, m.
    **parameters
        Parameters that differ from the paper.
    """
    point = parse_point(
        {"system": system, "replicates": replicates} | parameters, "tests.made.results"
    )
    factors = 1.0 + scatter * spread(replicates)
    values = {
        name: _replicated(value, factors) for name, value in (USUAL | dict(scalars or {})).items()
    }
    own = np.abs(values.get("velocity", np.full(replicates, np.nan))) * scatter
    usual = {"velocity": own, "velocity_error": own / 2, "velocity_half_width": own}
    usual |= {
        "steps": np.full(replicates, float(point.steps)),
        "time_step_used": np.full(replicates, point.time_step),
        "average_start": np.full(replicates, point.transient * point.time_unit),
        "replicate_seed": np.arange(replicates),
    }
    values = usual | values
    if height is None:
        height = (np.arange(SLICES) + 0.5) * SLICE[system] * point.diameter
    arrays = {
        name: np.outer(factors, profile(_centres(name, point, height)))
        if callable(profile)
        else np.asarray(profile, float)
        for name, profile in (profiles or {}).items()
    }
    return MadePoint(point, values, arrays, height)


def made_results(
    *points: MadePoint,
    boundaries: Sequence[Mapping[str, object]] = (),
    particles: Mapping[str, xr.Dataset] | None = None,
) -> Results:
    """Return points as the results of one study.

    Parameters
    ----------
    *points : MadePoint
        Each of them only once.
    boundaries : sequence of mapping, optional
        One per boundary, from `made_boundary`.
    particles : mapping, optional
        Group ``particles`` by id of the point.
    """
    count = max(len(point.scalars["status"]) for point in points)
    names = dict.fromkeys(name for point in points for name in point.scalars)
    data = {name: (("point", "replicate"), _table(points, name, count)) for name in names}
    root = xr.Dataset(data, coords=_coordinates(points) | {"replicate": np.arange(count)})
    root = root.assign_attrs(study="made", title="Made up", engine_version="0", versions="none")
    profiles = {
        system: _profiles([point for point in points if point.parameters.system == system], count)
        for system in {point.parameters.system for point in points}
    }
    columns = None if boundaries else ["system", "of", "along", "low", "high"]
    table = pd.DataFrame(list(boundaries), columns=columns)
    return Results(root.assign(_together(root)), profiles, table, dict(particles or {}))


def made_boundary(
    system: str,
    of: str,
    along: str,
    low: float,
    high: float,
    *,
    verdict: str = "found",
    **parameters: object,
) -> dict[str, object]:
    """Return a boundary between ``low`` and ``high``; omitted parameters are the paper's."""
    point = parse_point({"system": system} | parameters, "tests.made.results")
    settings = {
        name: value if isinstance(value, str) else float(value)
        for name, value in complete_values(point).items()
    }
    declared = field_info(point)[along]
    return settings | {
        "name": f"{of}-{along}",
        "system": system,
        "of": of,
        "along": along,
        "unit": declared.scale or declared.unit,
        "figures": "",
        "low": low,
        "high": high,
        "below": "below",
        "above": "above",
        "verdict": verdict,
        "points": 8,
        along: low,
    }


def _is_along(name: str) -> bool:
    """True where a profile runs along the belt."""
    return name.startswith("column")


def _centres(name: str, point: Parameters, height: np.ndarray) -> np.ndarray:
    """Return the positions (m) of a profile's values."""
    if not _is_along(name):
        return height
    return (np.arange(round(point.width)) + 0.5) * point.diameter


def _replicated(values: ScalarValues, factors: np.ndarray) -> np.ndarray:
    """Return one value per replicate."""
    if isinstance(values, str):
        return np.full(factors.size, values, object)
    if np.ndim(values) == 0:
        return float(values) * factors
    if all(isinstance(value, str) for value in values):
        return np.array(values, object)
    return np.asarray(values, float)


def _table(points: Sequence[MadePoint], name: str, count: int) -> np.ndarray:
    """Return a scalar of all points (point, replicate), padded as the dataset is."""
    word = any(name in point.scalars and point.scalars[name].dtype == object for point in points)
    table = np.full((len(points), count), "" if word else np.nan, object if word else float)
    for row, point in zip(table, points, strict=True):
        if name in point.scalars:
            row[: len(point.scalars[name])] = point.scalars[name]
    return table


def _coordinates(points: Sequence[MadePoint]) -> dict[str, object]:
    """Return ids, particle numbers and every parameter of all systems, as in a dataset."""
    empty = np.full(len(points), "", object)
    labels = {
        "point": [point.id for point in points],
        "series": ("point", empty),
        "figures": ("point", empty),
        "caveat": ("point", empty),
        "particles": ("point", [point.parameters.particles for point in points]),
    }
    names = dict.fromkeys(name for model in SYSTEMS.values() for name in model.model_fields)
    for name in names:
        values = [getattr(point.parameters, name, None) for point in points]
        word = any(isinstance(value, str) for value in values)
        missing = "" if word else np.nan
        filled = [missing if value is None else value for value in values]
        labels[name] = ("point", np.array(filled, object if word else float))
    return labels


def _together(root: xr.Dataset) -> dict[str, object]:
    """Return statistics pooled over replicates, under the names of the dataset."""
    rows = outcomes(root)
    names = {"velocity": float, "half_width": float, "regime": object, "quality": object}
    return {
        f"point_{name}": ("point", np.array([row[name] for row in rows], kind))
        for name, kind in names.items()
    }


def _profiles(points: Sequence[MadePoint], count: int) -> xr.Dataset:
    """Return the profiles of one system's points, padded to the longest."""
    names = dict.fromkeys(name for point in points for name in point.profiles)
    data = {}
    for dimension, centres in (("slice", "height"), ("square", "column")):
        own = [name for name in names if _is_along(name) == _is_along(centres)]
        if not own and _is_along(centres):
            continue
        rows = [_centres(centres, point.parameters, point.height) for point in points]
        data[centres] = ("run", dimension), _padded(rows, (max(map(len, rows)),))
        for name in own:
            rows = [point.profiles.get(name, np.empty((0, 0))) for point in points]
            shape = (count, data[centres][1].shape[1])
            data[name] = ("run", "replicate", dimension), _padded(rows, shape)
    return xr.Dataset(data, coords={"run": [point.id for point in points]})


def _padded(rows: Sequence[np.ndarray], shape: tuple[int, ...]) -> np.ndarray:
    """Return arrays filled up with NaN to one shape, as one array."""
    table = np.full((len(rows), *shape), np.nan)
    for filled, row in zip(table, rows, strict=True):
        filled[tuple(slice(size) for size in row.shape)] = row
    return table
