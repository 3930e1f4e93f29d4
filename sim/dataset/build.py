"""The runs of a study as one labelled table: ``dataset.nc`` over points and replicates.

The root group holds scalars. The groups ``natural`` and ``si`` hold velocities in natural units
and parameters in SI. A group per system holds the profiles of its points. The group ``states``
holds the particles of points whose particles a figure draws. The group ``runs`` names the run file
of each row, so that the file need not be read again.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import netCDF4
import numpy as np
import pandas as pd
import xarray as xr

from sim.base.errors import InputError
from sim.base.files import atomic_write, require_writable
from sim.base.seals import seal
from sim.dataset.boundaries import add_rounds, find_sides, tabulate
from sim.dataset.grids import Values
from sim.dataset.replicates import caveats, outcomes
from sim.dataset.results import COLUMNS, GROUP, Results, with_all_parameters
from sim.dataset.rounds import add_further_points, points_of_rounds
from sim.dataset.rows import (
    ARRAYS,
    OF_PROFILES,
    PARTICLES,
    PATH_VARIABLES,
    RUNS,
    SCALAR_DIGITS,
    Row,
    Table,
    reader_hash,
    row_arrays,
    row_scalars,
    stored_names,
    tabulate_rows,
)
from sim.dataset.sources import gather_rows, keep_dataset
from sim.engine.stored_run import current_status
from sim.parameters import SYSTEMS, Parameters, complete_values, field_info, in_si, point_id
from sim.parameters.variables import variables_of
from sim.study.expand import point_with_membership
from sim.study.load import Boundary, Point, Study, load_study
from sim.study.model import Sides
from sim.study.plottable import Shown

#: NetCDF compression of arrays.
COMPRESSION = {"zlib": True, "complevel": 9, "shuffle": True}

#: Number of points from which on their columns are compressed; the index of a compressed variable
#: takes some 2 kB.
LONG_COLUMN = 300

#: Binary digits of profiles and of particle positions; run files have all digits. The 9 digits of
#: profiles are an error of 1e-3 of each value, far below that of the mean of a replicate.
PROFILE_DIGITS, POSITION_DIGITS = 9, 20


def build(
    study_path: str | Path,
    results: str | Path = "results",
    processes: int = 1,
    scheduler: str | None = None,
    finished: Path | None = None,
) -> Path:
    """Combine the run files of a study into ``results/<study>/dataset.nc``.

    Run files that the earlier dataset was made from are not read again; the result is the same. The
    points of the study file, with those of all rounds of refinement, name them. The dataset appears
    complete or not at all; its group ``boundaries`` has the table of boundaries. For ``processes``
    and ``scheduler`` see `sim.dataset.sources.read_files`. With ``finished``, that file is written
    instead, which must not exist yet: its dataset has only points whose run files are undamaged and
    have what is wanted of them, and no boundaries. All damaged run
    files are set aside, so that the workflow computes them again. Raises `InputError` when a run
    file is missing or damaged, naming it; with ``finished``, when that file exists, or when there
    is no such point.
    """
    study = load_study(study_path, results)
    folder = Path(results) / study.name
    if finished is not None:
        study = _select_finished(study, folder, finished)
    output = finished or folder / "dataset.nc"
    gather = partial(gather_rows, study, folder, processes=processes, scheduler=scheduler)
    rows = gather(study.points)
    sides = find_sides(study, folder / "runs")
    first, study = study.points, add_rounds(study, sides)
    study = add_further_points(study, points_of_rounds(study, folder))
    rows |= gather({key: point for key, point in study.points.items() if key not in first})
    with atomic_write(output) as temporary:
        # Opening a file once per group would take longer than writing most of them.
        with netCDF4.Dataset(temporary, "w") as file:
            values = Values()
            for group, dataset in _groups(rows, study, sides):
                encoding = _encodings(dataset, group)
                values.define(dataset, file.createGroup(group) if group else file, encoding)
                if group in SYSTEMS:
                    # Profiles are large, and not held until all groups are defined.
                    values.fill()
            values.fill()
        seal(temporary)
        if not finished:
            keep_dataset(temporary, folder)
    return output


def gather_results(
    study: Study, folder: Path, series: str, points: Mapping[str, Parameters]
) -> Results:
    """Return the results of points of a series without writing a dataset.

    ``points`` are those of the series by id, those of rounds included, and ``folder`` has the
    results of the study. Raises `InputError` when a run file is missing or damaged, see
    `gather_rows`.
    """
    members = {
        key: study.points.get(key) or Point(key, point, (series,), ())
        for key, point in points.items()
    }
    rows = gather_rows(study, folder, members)
    part = replace(study, points=members, boundaries=())
    groups = dict(_groups(rows, part, ()))
    return Results(
        dataset=with_all_parameters(groups[None]),
        profiles={name: groups[name] for name in SYSTEMS if name in groups},
        boundaries=pd.DataFrame(columns=COLUMNS),
    )


def _select_finished(study: Study, folder: Path, output: Path) -> Study:
    """Return a study of the points that have finished, with those of rounds, here or elsewhere."""
    if output.exists():
        raise InputError.of_value("--finished", "", str(output), "a file that is not there yet")
    if output.parent.resolve() == (folder / "runs").resolve():
        raise InputError.of_value(
            "--finished", "", str(output), "a file that is not among the runs"
        )
    require_writable(output.parent, "--finished")
    known = points_of_rounds(study, folder)
    points = dict(add_further_points(study, known).points)
    for key, parameters in known.items():
        for boundary in study.boundaries if key not in study.points else ():
            if _is_along(boundary, parameters):
                points[key] = point_with_membership(
                    points, parameters, boundary.name, boundary.figures
                )
    finished = {
        key: point
        for key, point in points.items()
        if current_status(folder / "runs" / f"{key}.nc", point.parameters, study.need(key))
    }
    if not finished:
        raise InputError(f"{study.path}: no point has a run file with all that is wanted of it")
    output.parent.mkdir(parents=True, exist_ok=True)
    return replace(study, points=finished, boundaries=())


def _is_along(boundary: Boundary, parameters: Parameters) -> bool:
    """Return whether a point is one of the points of a boundary, at its value along it."""
    value = getattr(parameters, boundary.along, None)
    with suppress(InputError):
        return value is not None and point_id(boundary.parameters_at(value)) == point_id(parameters)
    return False


def _groups(
    rows: Mapping[str, Row], study: Study, sides_of_boundaries: Sequence[Sides]
) -> Iterator[tuple[str | None, xr.Dataset]]:
    """Yield the groups of the dataset by name, the root first."""
    table = tabulate_rows(rows, list(study.points), row_scalars())
    scalars = root(table, study)
    yield None, scalars
    yield "natural", natural_velocities(scalars)
    yield "si", si_parameters(list(study.points.values()))
    yield RUNS, runs(table)
    for system in SYSTEMS:
        members = [
            key
            for key, point in study.points.items()
            if point.parameters.system == system and study.need(key).profiles
        ]
        if members and row_arrays(system):
            replicates = scalars.sizes["replicate"]
            yield system, profiles(tabulate_rows(rows, members, OF_PROFILES, replicates))
    for key, point in study.points.items():
        state, need = rows[key].state, study.particles_shown(point.figures)
        if state is not None and need:
            state = state.drop_encoding()
            if need < Shown.PATH:
                state = state.drop_vars(PATH_VARIABLES, errors="ignore")
            # Sorted, because the library returns attributes in an order of its own.
            state.attrs = dict(sorted(state.attrs.items()))
            yield f"{PARTICLES}/{key}", state
    if study.boundaries:
        yield GROUP, tabulate(study, sides_of_boundaries).to_xarray()


def _encodings(dataset: xr.Dataset, group: str | None) -> dict[str, Any]:
    """Return the netCDF encoding of the variables of a group; the root has no name."""
    encodings = {str(name): _encoding(values, group) for name, values in dataset.variables.items()}
    # CF allows only numbers as coordinates, so labels are stored as letters in two dimensions.
    labels = (name for name in ("point", "run") if name in dataset.coords)
    return encodings | {name: COMPRESSION | {"dtype": "S1"} for name in labels}


def _encoding(values: xr.Variable, group: str | None) -> dict[str, Any]:
    """Return the netCDF encoding of a variable: compression, characters for text, digits."""
    is_column = values.ndim < 2 and group != RUNS
    if is_column and values.size < LONG_COLUMN:
        return {}
    if values.dtype.kind in "OUT":
        # Text is compressed when stored as characters, unlike strings.
        return COMPRESSION | {"dtype": "S1"}
    if values.dtype == np.float32:
        digits = PROFILE_DIGITS if group in SYSTEMS else POSITION_DIGITS
    else:
        digits = SCALAR_DIGITS if values.dtype == np.float64 and group not in SYSTEMS else 0
    if is_column or not digits:
        return COMPRESSION
    return COMPRESSION | {"quantize_mode": "BitRound", "significant_digits": digits}


_REPLICATE = {"units": "1", "long_name": "number of the replicate"}

_VELOCITIES = ("velocity", "velocity_half_width", "point_velocity", "point_half_width")


def root(rows: Table, study: Study) -> xr.Dataset:
    """Return the root group: the scalars of runs over ``point`` and ``replicate``.

    ``rows`` are in the order of the points of the study, which gives series and figures of each.
    Variables are padded with NaN and ``""`` where a point has fewer replicates than another. Every
    parameter of the systems of the study is a coordinate over ``point``, NaN or ``""`` where the
    point's system does not have it.
    """
    scalars = xr.Dataset(
        {
            name: (("point", "replicate"), values, _attributes_of(name))
            for name, values in rows.values.items()
        }
    )
    told = [
        caveats(own, {name: values[row] for name, values in rows.values.items()}, point.parameters)
        for row, (own, point) in enumerate(
            zip(rows.origin["caveat"], study.points.values(), strict=True)
        )
    ]
    numbers = np.arange(scalars.sizes["replicate"])
    dataset = scalars.assign_coords(
        _labels(study, told, rows.origin["source_hash"])
        | _parameters(list(study.points.values()))
        | {"replicate": ("replicate", numbers, _REPLICATE)}
    )
    dataset.attrs = _attributes(rows.origin, study)
    return dataset.assign(_pooled_variables(dataset))


def profiles(rows: Table) -> xr.Dataset:
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


def runs(rows: Table) -> xr.Dataset:
    """Return the group `RUNS`: seal, amounts and versions of the run file behind each row.

    Attribute ``reads`` has the names of all variables that a row has if its run file has them.
    """
    columns = {name: ("point", np.array(texts, object)) for name, texts in rows.origin.items()}
    reads = " ".join(sorted(stored_names()))
    return xr.Dataset(columns, attrs={"code": reader_hash(), "reads": reads})


def _column(name: str, values: Iterable[Any], kind: Any = None) -> Any:
    """Return a variable over ``point`` with its unit and long name."""
    return "point", np.array(list(values), kind), _attributes_of(name)


def _attributes_of(name: str) -> dict[str, str]:
    return (variables_of("point") | row_scalars())[name].attributes


def _pooled_variables(dataset: xr.Dataset) -> dict[str, Any]:
    """Return the variables ``point_*``: statistics of each point pooled over its replicates."""
    rows = outcomes(dataset)
    kinds = {"velocity": float, "half_width": float, "regime": object}
    kinds |= {"quality": object, "stopped": object}
    return {
        f"point_{name}": _column(f"point_{name}", (row[name] for row in rows), kind)
        for name, kind in kinds.items()
    }


def _attributes(origin: Mapping[str, Sequence[str]], study: Study) -> dict[str, str]:
    """Return the global attributes: title and study, and the versions that made the runs."""
    attrs = {"Conventions": "CF-1.11", "title": study.title or study.name, "study": study.name}
    distinct = ("engine_version", "numerics", "source_hash", "versions")
    attrs |= {name: ", ".join(dict.fromkeys(origin[name])) for name in distinct}
    dates = origin["created"]
    first, last = min(dates), max(dates)
    return attrs | {
        "source": f"Talus {attrs['engine_version']}, numerics {attrs['numerics']}",
        # Without the present date, so that the same runs give the same file.
        "history": f"{last}: the last of {len(dates)} runs, here combined; the first: {first}",
        "first_run": first,
        "last_run": last,
    }


def _labels(study: Study, told: Iterable[str], hashes: Iterable[str]) -> dict[str, Any]:
    """Return coordinates of each point: id, series, figures, caveat, source, particles, looks."""
    points = list(study.points.values())
    texts = {
        "series": (" ".join(point.series) for point in points),
        "figures": (" ".join(point.figures) for point in points),
        "caveat": told,
        "run_source_hash": hashes,
    }
    return {
        "point": _column("point", study.points),
        **{name: _column(name, values, object) for name, values in texts.items()},
        "particles": _column("particles", (point.parameters.particles for point in points)),
        "looks": _column("looks", (point.looks for point in points)),
    }


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
        return "point", np.array(["" if one is None else one for one in values], object), attrs
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


def natural_velocities(root: xr.Dataset) -> xr.Dataset:
    """Return the velocities of the root group in units of √(g · diameter) of each point."""
    if "gravity" not in root:
        return xr.Dataset()
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
    ids = "point", [point.id for point in points], {"long_name": "point id"}
    return xr.Dataset(variables, {"point": ids})
