"""The groups of a dataset, from the aligned rows of its runs."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr

from sim.dataset.caveats import caveat
from sim.dataset.earlier import reader_hash, stored_names
from sim.dataset.replicates import outcomes
from sim.dataset.rows import ARRAYS, OF_PROFILES, Rows, row_scalars
from sim.parameters import SYSTEMS, complete_values, field_info, in_si
from sim.parameters.variables import variables_of
from sim.study.load import Point, Study

_REPLICATE = {"units": "1", "long_name": "number of the replicate"}

_VELOCITIES = ("velocity", "velocity_half_width", "point_velocity", "point_half_width")


def root(rows: Rows, study: Study) -> xr.Dataset:
    """Return the root group: the scalars of runs over ``point`` and ``replicate``.

    Parameters
    ----------
    rows : Rows
        The runs of the study, in the order of its points.
    study : Study
        Gives the series and figures of each point.

    Returns
    -------
    xarray.Dataset
        Variables over (point, replicate), padded with NaN and ``""`` where a point has fewer
        replicates than another. Every parameter of the systems of the study is a coordinate over
        ``point``, NaN or ``""`` where the point's system does not have it.
    """
    scalars = xr.Dataset(
        {
            name: (("point", "replicate"), values, _attributes_of(name))
            for name, values in rows.values.items()
        }
    )
    # Not every engine tells it.
    unknown = xr.full_like(scalars["steps"], np.nan)
    overlaps = scalars.get("max_overlap", unknown)
    caveats = map(
        caveat,
        rows.origin["caveat"],
        scalars["missing_energy"].values,
        [point.parameters for point in study.points.values()],
        overlaps.where(scalars["status"] == "completed").values,
        (scalars["steps"] * scalars["time_step_used"]).values,
        scalars.get("layer_order", unknown).values,
    )
    numbers = np.arange(scalars.sizes["replicate"])
    dataset = scalars.assign_coords(
        _labels(study, caveats, rows.origin["source_hash"])
        | _parameters(list(study.points.values()))
        | {"replicate": ("replicate", numbers, _REPLICATE)}
    )
    dataset.attrs = _attributes(rows.origin, study)
    return dataset.assign(_pooled_variables(dataset))


def profiles(rows: Rows) -> xr.Dataset:
    """Return the profiles of the runs of one system over (run, replicate, slice).

    Coordinate ``run`` is the id of the point. A run with fewer slices or replicates than another is
    padded with NaN. ``height`` (run, slice) holds the centres of the slices. Profiles along the
    belt are over (run, replicate, square), and ``column`` (run, square) holds the centres of the
    squares. Profiles over the cycle of the belt are over (run, replicate, moment), and
    ``cycle_phase`` (run, moment) holds the phases.
    """
    variables = {
        name: (("run", *OF_PROFILES[name]), values, ARRAYS[name].attributes)
        for name, values in rows.values.items()
    }
    return xr.Dataset(variables, {"run": ("run", rows.points, {"long_name": "point id"})})


def runs(rows: Rows) -> xr.Dataset:
    """Return the group `RUNS`: seal, amounts and versions of the run file behind each row.

    Attribute ``reads`` has the names of all variables that a row has if its run file has them.
    """
    columns = {name: ("point", np.array(texts, object)) for name, texts in rows.origin.items()}
    reads = " ".join(sorted(stored_names()))
    return xr.Dataset(columns, attrs={"code": reader_hash(), "reads": reads})


def point_coordinate(points: Sequence[Point]) -> Any:
    """Return the coordinate ``point`` with the ids of the points."""
    return "point", [point.id for point in points], {"long_name": "point id"}


def _attributes_of(name: str) -> dict[str, str]:
    return (variables_of("point") | row_scalars())[name].attributes


def _pooled_variables(dataset: xr.Dataset) -> dict[str, Any]:
    """Return the variables ``point_*``: statistics of each point pooled over its replicates."""
    rows = outcomes(dataset)
    variables = {
        f"point_{name}": ("point", np.array([row[name] for row in rows], float))
        for name in ("velocity", "half_width")
    }
    for name in ("regime", "quality", "stopped"):
        variables[f"point_{name}"] = _text_variable(row[name] for row in rows)
    return _with_attrs(variables)


def _with_attrs(variables: Mapping[str, Any]) -> dict[str, Any]:
    """Return variables over ``point`` with their units and long names."""
    return {name: (*values[:2], _attributes_of(name)) for name, values in variables.items()}


def _attributes(origin: Mapping[str, Sequence[str]], study: Study) -> dict[str, str]:
    """Return the global attributes: title and study, and the versions that made the runs."""
    attrs = {"Conventions": "CF-1.11", "title": study.title or study.name, "study": study.name}
    distinct = ("engine_version", "numerics", "source_hash", "versions")
    attrs |= {name: ", ".join(dict.fromkeys(origin[name])) for name in distinct}
    dates = origin["created"]
    first, last = min(dates), max(dates)
    # Without the present date, so that the same runs give the same file.
    history = f"{last}: the last of {len(dates)} runs, here combined; the first: {first}"
    source = f"Talus {attrs['engine_version']}, numerics {attrs['numerics']}"
    return attrs | {
        "source": source,
        "history": history,
        "first_run": first,
        "last_run": last,
    }


def _labels(study: Study, caveats: Iterable[str], hashes: Iterable[str]) -> dict[str, Any]:
    """Return coordinates of each point: id, series, figures, caveat, source, particles, looks."""
    points = list(study.points.values())
    return _with_attrs(
        {
            "point": point_coordinate(points),
            "series": _text_variable(" ".join(point.series) for point in points),
            "figures": _text_variable(" ".join(point.figures) for point in points),
            "caveat": _text_variable(caveats),
            "run_source_hash": _text_variable(hashes),
            "particles": ("point", [point.parameters.particles for point in points]),
            "looks": ("point", [point.looks for point in points]),
        }
    )


def _parameters(points: Sequence[Point]) -> dict[str, Any]:
    """Return every parameter of the points' systems as a coordinate with its unit."""
    mappings = [complete_values(point.parameters) for point in points]
    names = dict.fromkeys(name for mapping in mappings for name in mapping)
    return {name: _parameter(name, mappings) for name in names}


def _parameter(name: str, mappings: Sequence[Mapping[str, Any]]) -> Any:
    values = [mapping.get(name) for mapping in mappings]
    systems = dict.fromkeys(mapping["system"] for mapping in mappings if name in mapping)
    attrs = {"long_name": join_declarations(name, "description", systems)}
    if any(isinstance(value, str) for value in values):
        return _text_variable(("" if value is None else value for value in values), attrs)
    rows = {system: field_info(SYSTEMS[system])[name] for system in systems}
    units = {system: row.unit for system, row in rows.items()}
    comments = {
        system: f"multiple of {row.scale}" if row.scale else "" for system, row in rows.items()
    }
    for kind, texts in (("units", units), ("comment", comments)):
        # No program can read two units in one attribute, so they become a comment.
        key = kind if len(set(texts.values())) == 1 else "comment"
        if any(texts.values()):
            attrs[key] = "; ".join(filter(None, (attrs.get(key), _by_system(texts))))
    return "point", np.array([np.nan if value is None else value for value in values], float), attrs


def _by_system(texts: Mapping[str, str]) -> str:
    """Join the texts of systems, each after its system, or return the text where they all agree."""
    if len(set(texts.values())) == 1:
        return next(iter(texts.values()))
    return "; ".join(f"{system}: {text}" for system, text in texts.items() if text)


def join_declarations(name: str, attribute: str, systems: Iterable[str]) -> str:
    """Join an attribute of a parameter as declared by some systems, without repetitions."""
    rows = [field_info(SYSTEMS[system]).get(name) for system in systems]
    return "; ".join(dict.fromkeys(getattr(row, attribute) for row in rows if row))


def _text_variable(values: Iterable[str], attrs: Mapping[str, str] | None = None) -> Any:
    return "point", np.array(list(values), dtype=object), dict(attrs or {})


def natural_velocities(root: xr.Dataset) -> xr.Dataset:
    """Return the velocities of the root group in units of √(g · diameter) of each point."""
    velocity_unit = np.sqrt(root["gravity"] * root["diameter"])
    velocities = {
        name: (root[name] / velocity_unit).assign_attrs(
            units="1",
            long_name=root[name].attrs["long_name"],
            comment="multiple of √(gσ), of a belt √(g⟨d⟩)",
        )
        for name in _VELOCITIES
    }
    return xr.Dataset(velocities).reset_coords(drop=True)[list(velocities)]


def si_parameters(points: Sequence[Point]) -> xr.Dataset:
    """Return the dimensional parameters over ``point`` in SI, NaN where a point has none."""
    values_in_si = [in_si(point.parameters) for point in points]
    names = dict.fromkeys(name for row in values_in_si for name in row)
    systems = list(dict.fromkeys(point.parameters.system for point in points))
    variables = {}
    for name in names:
        (unit,) = {row[name].unit for row in values_in_si if name in row}
        values = [row[name].value if name in row else np.nan for row in values_in_si]
        attrs = {"units": unit, "long_name": join_declarations(name, "description", systems)}
        variables[name] = ("point", np.array(values, float), attrs)
    return xr.Dataset(variables, {"point": point_coordinate(points)})
