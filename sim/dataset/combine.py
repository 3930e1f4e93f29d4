"""Rows of runs as the groups of a dataset, in the order of the study's points."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

from sim.dataset.caveats import caveat
from sim.dataset.earlier import names_read, reading_code
from sim.dataset.replicates import outcomes
from sim.dataset.rows import (
    ARRAYS,
    OF_PROFILES,
    Rows,
    lined_up,
    origins,
    points_of,
    row_scalars,
    sizes_of,
)
from sim.parameters import SYSTEMS, complete, field_info
from sim.parameters.variables import variables
from sim.study.load import Point, Study

_REPLICATE = {"units": "1", "long_name": "number of the replicate"}


def root(blocks: Sequence[Rows], study: Study) -> xr.Dataset:
    """Line up the scalars of runs along ``point`` and their replicates along ``replicate``.

    Parameters
    ----------
    blocks : sequence of Rows
        The runs of the study.
    study : Study
        Says in which order they come, and which series and figures each belongs to.

    Returns
    -------
    xarray.Dataset
        Variables over (point, replicate), padded with NaN and ``""`` where a point has fewer
        replicates than another; every parameter of the systems that the study has as a coordinate
        over ``point``, NaN or ``""`` where it is not one of the point's system.
    """
    order, sizes = _order(blocks, study.points), sizes_of(blocks)
    made = origins(blocks).iloc[order]
    held = xr.Dataset(
        {
            name: (("point", "replicate"), lined_up(blocks, name, sizes)[order], _described(name))
            for name in row_scalars()
            if any(name in block.values for block in blocks)
        }
    )
    caveats = map(
        caveat,
        made["caveat"],
        held["missing_energy"].values,
        [point.parameters for point in study.points.values()],
        held["max_overlap"].where(held["status"] == "completed").values,
        (held["steps"] * held["time_step_used"]).values,
    )
    found = held.assign_coords(
        _labels(study, caveats, made["source_hash"])
        | _parameters(list(study.points.values()))
        | {"replicate": ("replicate", np.arange(sizes["replicate"]), _REPLICATE)}
    )
    found.attrs = _attributes(made, study)
    return found.assign(_together(found))


def profiles(blocks: Sequence[Rows], points: Sequence[str], replicates: int) -> xr.Dataset:
    """Return the profiles of the runs of one system over (run, replicate, slice).

    Coordinate ``run`` is the id of the point. Fewer slices or replicates than those of another run
    are filled up with NaN; ``height`` (run, slice) holds the centres of the slices. Profiles along
    the belt are over (run, replicate, square), and ``column`` (run, square) holds the centres;
    those over its cycle (run, replicate, moment), and ``cycle_phase`` (run, moment) the phases.
    """
    order, sizes = _order(blocks, points), sizes_of(blocks) | {"replicate": replicates}
    held = {
        name: (("run", *dimensions), lined_up(blocks, name, sizes)[order], ARRAYS[name].attributes)
        for name, dimensions in OF_PROFILES.items()
        if any(name in block.values for block in blocks)
    }
    return xr.Dataset(held, {"run": ("run", list(points), {"long_name": "point id"})})


def runs(blocks: Sequence[Rows], points: Iterable[str]) -> xr.Dataset:
    """Return the group `RUNS`: seal, amounts and versions of the run file behind each row.

    ``reads`` are the names of all that a row could have, if its run file has it.
    """
    made = origins(blocks).iloc[_order(blocks, points)]
    words = {name: ("point", made[name].to_numpy(object)) for name in made}
    reads = " ".join(sorted(names_read()))
    return xr.Dataset(words, attrs={"code": reading_code(), "reads": reads})


def _order(blocks: Iterable[Rows], points: Iterable[str]) -> np.ndarray:
    """Return the rows of points, in their order."""
    rows = {point: row for row, point in enumerate(points_of(blocks))}
    return np.array([rows[point] for point in points])


def ids(points: Sequence[Point]) -> Any:
    """Return the coordinate ``point``."""
    return "point", [point.id for point in points], {"long_name": "point id"}


def _described(name: str) -> dict[str, str]:
    return (variables("point") | row_scalars())[name].attributes


def _together(found: xr.Dataset) -> dict[str, Any]:
    """Return the variables ``point_*``, the results of each point over its replicates."""
    each = outcomes(found)
    made = {
        f"point_{name}": ("point", np.array([one[name] for one in each], float))
        for name in ("velocity", "half_width")
    }
    for name in ("regime", "quality", "stopped"):
        made[f"point_{name}"] = _words(one[name] for one in each)
    return _told_of_points(made)


def _told_of_points(made: Mapping[str, Any]) -> dict[str, Any]:
    """Return variables over ``point`` with their units and long names."""
    return {name: (*values[:2], _described(name)) for name, values in made.items()}


def _attributes(made: pd.DataFrame, study: Study) -> dict[str, str]:
    """Return the global attributes: what this is and what made its runs."""
    what = {"Conventions": "CF-1.11", "title": study.title or study.name, "study": study.name}
    distinct = ("engine_version", "numerics", "source_hash", "versions")
    what |= {name: ", ".join(made[name].unique()) for name in distinct}
    first, last = made["created"].min(), made["created"].max()
    # No date of its own: the same runs give the same file.
    combined = f"{last}: the last of {len(made)} runs, here combined; the first: {first}"
    source = f"Talus {what['engine_version']}, numerics {what['numerics']}"
    return what | {
        "source": source,
        "history": combined,
        "first_run": first,
        "last_run": last,
    }


def _labels(study: Study, caveats: Iterable[str], hashes: Iterable[str]) -> dict[str, Any]:
    """Return id, series, figures, caveat and number of particles of each point as coordinates."""
    points = list(study.points.values())
    return _told_of_points(
        {
            "point": ids(points),
            "series": _words(" ".join(point.series) for point in points),
            "figures": _words(" ".join(point.figures) for point in points),
            "caveat": _words(caveats),
            "run_source_hash": _words(hashes),
            "particles": ("point", [point.parameters.particles for point in points]),
        }
    )


def _parameters(points: Sequence[Point]) -> dict[str, Any]:
    """Return every parameter of the points' systems as a coordinate with its unit."""
    given = [complete(point.parameters) for point in points]
    names = dict.fromkeys(name for one in given for name in one)
    return {name: _parameter(name, given) for name in names}


def _parameter(name: str, given: Sequence[Mapping[str, Any]]) -> Any:
    values = [one.get(name) for one in given]
    systems = dict.fromkeys(one["system"] for one in given if name in one)
    attrs = {"long_name": declared(name, "description", systems)}
    if any(isinstance(value, str) for value in values):
        return _words(("" if value is None else value for value in values), attrs)
    rows = {system: field_info(SYSTEMS[system])[name] for system in systems}
    units = {system: row.unit for system, row in rows.items()}
    comments = {
        system: f"multiple of {row.scale}" if row.scale else "" for system, row in rows.items()
    }
    for kind, told in (("units", units), ("comment", comments)):
        # Two units in one attribute could be read by nobody; as a comment they can.
        kept = kind if len(set(told.values())) == 1 else "comment"
        if any(told.values()):
            attrs[kept] = "; ".join(filter(None, (attrs.get(kept), _by_system(told))))
    return "point", np.array([np.nan if value is None else value for value in values], float), attrs


def _by_system(texts: Mapping[str, str]) -> str:
    """Write a text per system, or once where the systems agree."""
    if len(set(texts.values())) == 1:
        return next(iter(texts.values()))
    return "; ".join(f"{system}: {text}" for system, text in texts.items() if text)


def declared(name: str, what: str, systems: Iterable[str]) -> str:
    """Join what some systems declare about a parameter, once where they agree."""
    rows = [field_info(SYSTEMS[system]).get(name) for system in systems]
    return "; ".join(dict.fromkeys(getattr(row, what) for row in rows if row))


def _words(values: Iterable[str], attrs: Mapping[str, str] | None = None) -> Any:
    return "point", np.array(list(values), dtype=object), dict(attrs or {})
