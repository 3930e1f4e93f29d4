"""Made-up results for judges: points with known numbers and profiles, without files."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from types import SimpleNamespace
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr
from scipy.special import ndtri

from sim.claims.claim import claims
from sim.claims.evidence import Evidence
from sim.claims.place import Points
from sim.claims.verdict import NOT_REPRODUCED, Check, Untestable, combined_verdict
from sim.dataset.build import profiles, root
from sim.dataset.gather import ORIGIN as NAMES
from sim.dataset.gather import measure
from sim.dataset.results import Results, with_all_parameters
from sim.dataset.rows import OF_PROFILES, Row, row_scalars, tabulate_rows
from sim.parameters import Parameters, complete_values, field_info, parse_point, point_id
from sim.parameters.variables import observables
from sim.study.model import Point
from sim.study.papers import papers

#: A number, one per replicate, or a word.
ScalarValues = float | str | Sequence[float]

#: What made the runs.
ORIGIN = dict.fromkeys(NAMES, "")

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
    """Return a point that completed; omitted values are those of a good run.

    ``scalars`` are SI values by name of `SCALARS` or of measures: one number, about which the
    replicates scatter by ``scatter`` of it, one per replicate, or a word. ``profiles`` are
    functions of the heights (m), whose values scatter as a whole, or arrays (replicate, slice);
    those named ``column_...`` run along the belt. ``height`` (H,) are centres of slices, m.
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
        else np.broadcast_to(np.asarray(profile, float), (replicates, np.shape(profile)[-1]))
        for name, profile in (profiles or {}).items()
    }
    return MadePoint(point, values, arrays, height)


def made_results(
    *points: MadePoint,
    boundaries: Sequence[Mapping[str, object]] = (),
    particles: Mapping[str, xr.Dataset] | None = None,
) -> Results:
    """Return points, each only once, as the results of one study.

    ``boundaries`` are those of `made_boundary`; ``particles`` are groups by id of the point.
    """
    members = {one.id: Point(one.id, one.parameters, (), ()) for one in points}
    study: Any = SimpleNamespace(name="made", title="Made up", points=members)
    rows = {one.id: Row(one.id, ORIGIN, {**one.scalars, **_arrays(one)}) for one in points}
    dataset = with_all_parameters(root(tabulate_rows(rows, list(rows), row_scalars()), study))
    ids = {
        system: [one.id for one in points if one.parameters.system == system]
        for system in dict.fromkeys(one.parameters.system for one in points)
    }
    groups = {
        system: profiles(tabulate_rows(rows, of, OF_PROFILES, dataset.sizes["replicate"]))
        for system, of in ids.items()
    }
    columns = None if boundaries else ["system", "of", "along", "low", "high"]
    table = pd.DataFrame(list(boundaries), columns=columns)
    return Results(dataset, groups, table, dict(particles or {}))


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


def _arrays(point: MadePoint) -> dict[str, np.ndarray]:
    """Return the profiles of a point with the centres of their values."""
    arrays = {"height": point.height, **point.profiles}
    if any(map(_is_along, arrays)):
        arrays["column"] = _centres("column", point.parameters, point.height)
    return arrays


def measured(run: Mapping[Any, Any], system: str) -> dict[str, float]:
    """Return the observables of a replicate that have a value."""
    values = measure(run, observables(system), "a point")
    return {name: value for name, value in values.items() if not np.isnan(value)}


def headline_bounds(judge: Callable) -> dict[str, object]:
    """Return the bounds of a judge's claim, those of a partial function replaced."""
    function, others = getattr(judge, "func", judge), getattr(judge, "keywords", {})
    (bounds,) = (claim.bounds_at() for claim in claims() if claim.judge is function)
    return bounds | others


def checks_of(
    judge: Callable[..., list[Check]],
    points: Sequence[MadePoint],
    boundaries: Sequence[Mapping[str, object]] = (),
    protocol: str = "published",
) -> list[Check]:
    """Return the checks of a judge on made-up points."""
    results = made_results(*points, boundaries=boundaries)
    (paper,) = (claim.paper for claim in claims() if claim.judge is getattr(judge, "func", judge))
    evidence = Evidence(results, protocol, points=Points(results, papers()[paper]))
    return judge(evidence, **headline_bounds(judge))


def verdict_of(judge: Callable, points: Sequence[MadePoint], *args: object, **rest: object) -> str:
    """Return the verdict of a judge on made-up points; arguments are those of `checks_of`."""
    return combined_verdict(checks_of(judge, points, *args, **rest))


def by_part(checks: Sequence[Check]) -> dict[str, str]:
    """Return the verdict on each part of a claim that any check votes on."""
    votes = [check for check in checks if check.has_vote]
    names = dict.fromkeys(check.part for check in votes)
    return {
        name: combined_verdict(check for check in votes if check.part == name) for name in names
    }


def letters(judge: Callable, world: Sequence | tuple[Sequence, Sequence]) -> str:
    """Return the parts of a claim with R, N or I, as reproduced or not; "-" without a verdict.

    A world is made-up points, or points and boundaries.
    """
    points, boundaries = world if isinstance(world, tuple) else (world, ())
    try:
        verdicts = by_part(checks_of(judge, points, boundaries))
    except Untestable:
        return "-"
    return " ".join(f"{part}{verdict[0].upper()}" for part, verdict in verdicts.items())


def failed_quantities(checks: Iterable[Check]) -> list[str]:
    """Return the quantities that were not reproduced."""
    return [check.what for check in checks if check.verdict == NOT_REPRODUCED]
