"""The netCDF file of a run, written and read: all replicates of a point, SI, CF attributes."""

from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, NamedTuple

import netCDF4
import numpy as np

from sim.base.errors import InputError
from sim.base.files import atomic_write
from sim.base.seals import append_summary, seal
from sim.engine.stored_run import (
    STATE_TABLE,
    amounts_of,
    has_all,
    is_run_of,
    open_run_file,
    read_attributes,
)
from sim.engine.systems.recorder import Record
from sim.engine.systems.replica import Replica
from sim.parameters import Parameters, amounts, canonical_values, field_info, in_si
from sim.parameters.given import state_of
from sim.parameters.laws import FUNCTION_NAME as FUNCTION
from sim.parameters.variables import SCALARS, Variable, observable_variables, variables_of

#: How numbers are stored: compressed, and with a checksum of every chunk.
FILTERS = {"zlib": True, "complevel": 1, "shuffle": True, "fletcher32": True}

#: Size of a chunk of a trajectory in bytes; a chunk has at least one frame.
CHUNK = 2**20


class StoredRun(NamedTuple):
    """A run of a point: the records of its replicates; ``parameters`` have the run's amounts."""

    parameters: Parameters
    records: list[Record]

    @property
    def interval(self) -> float:
        """Time between two samples, s."""
        return self.parameters.sample_steps * self.parameters.time_step


def write(path: Path, run: StoredRun, system: Any, attributes: Mapping[str, Any]) -> None:
    """Write a run file under a temporary name, seal it, and rename it once it is complete.

    An existing one is replaced. ``system`` is one of the replicates, for heights, axes,
    coordinates, and names and units of the series; ``attributes`` are the global ones.
    """
    with atomic_write(path) as temporary:
        with netCDF4.Dataset(temporary, "w") as file:
            file.setncatts(attributes)
            writer = _Writer(file)
            _write_parameters(writer, run.parameters)
            _write_axes(writer, run, system)
            for name, (unit, long_name, values) in system.coordinates.items():
                _add_dimensions(writer, [name], [len(values)])
                _put(writer, name, (name,), values, unit, long_name)
            _write_records(writer, run.records, system)
            _write_trajectory(writer, run)
            writer.fill()
        records = run.records
        scalars = {name: [one.scalars[name] for one in records] for name in records[0].scalars}
        held = [amounts(run.parameters)]
        summary = {"attributes": attributes, "held": held, "scalars": scalars}
        append_summary(temporary, summary)
        seal(temporary)


class _Writer:
    """A file whose variables are defined first and filled later.

    For the library, a definition after data costs as much as all earlier definitions together.
    """

    def __init__(self, file: netCDF4.Dataset):
        self.file = file
        self.queue: list[tuple[netCDF4.Variable, Any, Any]] = []

    def fill(self) -> None:
        """Write the values in the queue."""
        for variable, index, values in self.queue:
            variable[index] = values


def _put(
    file: _Writer,
    name: str,
    dimensions: tuple[str, ...],
    values: Any,
    units: str = "",
    long_name: str = "",
) -> Any:
    """Define a variable of texts or numbers and queue its values."""
    values = np.asarray(values)
    is_text = values.dtype.kind in "UO"
    is_integer, is_single = values.dtype.kind in "ib", values.dtype == np.float32
    kind: Any = str if is_text else "i8" if is_integer else "f4" if is_single else "f8"
    options: dict[str, Any] = {} if is_text or not dimensions else FILTERS
    variable = file.file.createVariable(name, kind, dimensions, **options)
    if units:
        variable.units = units
    if long_name:
        variable.long_name = long_name
    file.queue.append((variable, ..., values.astype(object) if is_text else values))
    return variable


def _put_variable(file: _Writer, row: Variable, values: Any) -> Any:
    """Define a variable of the table."""
    return _put(file, row.name, row.dims, values, **row.attributes)


def _add_dimensions(file: _Writer, names: Sequence[str], sizes: Sequence[int]) -> None:
    """Define those of some dimensions that the group has not yet."""
    for name, size in zip(names, sizes, strict=True):
        if name not in file.file.dimensions:
            file.file.createDimension(name, size)


def _put_labels(file: _Writer, name: str, labels: Sequence[str], long_name: str) -> None:
    """Define the labels of a dimension as characters, because CF coordinates must be numbers."""
    width = max(map(len, labels))
    _add_dimensions(file, [letters := f"letters_{width}"], [width])
    variable = file.file.createVariable(name, "S1", (name, letters))
    variable.long_name, variable._Encoding = long_name, "utf-8"
    file.queue.append((variable, ..., np.array(labels, f"U{width}")))


def _write_parameters(file: _Writer, parameters: Parameters) -> None:
    rows, si = field_info(parameters), in_si(parameters)
    for name, value in canonical_values(parameters).items():
        row = rows[name]
        variable = _put(file, name, (), value, row.unit, row.description)
        if row.scale:
            variable.comment = f"multiple of {row.scale}"
            if name in si:
                variable.si_value, variable.si_units = si[name]
    if state := state_of(parameters):
        _put(file, STATE_TABLE, (), state.text, "", "the particles of initial_state, as CSV")
    _put(file, "particles", (), parameters.particles, "1", "number of particles")
    if not parameters.is_flow:
        return
    _put(file, "time_step", (), parameters.time_step, "s", "time step")
    for name, (value, meaning) in parameters.limits.items():
        _put(file, name, (), value, "m s-2", meaning)


def _write_axes(file: _Writer, run: StoredRun, system: Replica) -> None:
    numbers = np.arange(len(run.records))
    _add_dimensions(file, ["replicate"], [len(numbers)])
    _put(file, "replicate", ("replicate",), numbers, "1", "number of the replicate")
    if not system.series:
        return
    records, samples = run.records, _samples(run.records)
    names = ("time", "height", "frame", "particle", "axis", "quaternion")
    particles = records[0].snapshots["position"][0].shape
    sizes = (samples, len(system.profile_height), 2, *particles, 4)
    _add_dimensions(file, names, sizes)
    time = np.arange(1, samples + 1) * run.interval
    # An elapsed time without a date: in CF this is neither an axis T nor a time coordinate.
    _put(file, "time", ("time",), time, "s", "end of the sample interval, since the start")
    meaning = "height of the slice above the base"
    height = _put(file, "height", ("height",), system.profile_height, "m", meaning)
    height.axis, height.positive, height.standard_name = "Z", "up", "height"
    _put_labels(file, "frame", ("first", "last"), "first or last state")
    _put_labels(file, "axis", system.axes, "direction")


def _samples(records: list[Record]) -> int:
    """Return the number of samples of the longest replicate."""
    return max(len(record.series["mean_velocity"]) for record in records)


def _write_tables(file: _Writer, records: list[Record]) -> None:
    """Write tables, and the paths in single precision, which suffices for their use in figures."""
    arrays = variables_of("profile", "table")
    for name, values in records[0].tables.items():
        _add_dimensions(file, arrays[name].dims[1:], values.shape)
        tables = np.stack([record.tables[name] for record in records])
        _put_variable(file, arrays[name], tables)
    known_paths = [record.path for record in records if record.path is not None]
    if known_paths:
        blank = np.full_like(known_paths[0], np.nan)
        paths = [blank if record.path is None else record.path for record in records]
        _put_variable(file, arrays["path"], np.array(paths, np.float32))


def _write_trajectory(file: _Writer, run: StoredRun) -> None:
    """Write the frames of a trajectory; missing frames of a replicate are not-a-number."""
    spacing, records = run.parameters.trajectory_samples, run.records
    if not spacing:
        return
    count = _samples(records) // spacing
    file.file.createDimension("trajectory_time", count)
    time = spacing * run.interval * np.arange(1, count + 1)
    time_name = "time of the frame of the trajectory, since the start"
    _put(file, "trajectory_time", ("trajectory_time",), time, "s", time_name)
    for name, row in variables_of("trajectory").items():
        frames_of = {k: one.frames[name] for k, one in enumerate(records) if name in one.frames}
        if not frames_of:
            continue
        frame = next(iter(frames_of.values()))[0]
        _add_dimensions(file, row.dims[2:], frame.shape)
        chunk = (1, max(1, min(count, CHUNK // frame.nbytes)), *frame.shape)
        options: dict[str, Any] = FILTERS | {"chunksizes": chunk, "fill_value": np.nan}
        variable: Any = file.file.createVariable(name, "f4", row.dims, **options)
        variable.setncatts(row.attributes)
        for k, frames in frames_of.items():
            file.queue.append((variable, np.s_[k, : len(frames)], frames))


def _write_records(file: _Writer, records: list[Record], system: Replica) -> None:
    for name, series in system.series.items():
        values = np.full((len(records), _samples(records)), np.nan)
        for row, record in zip(values, records, strict=True):
            row[: len(record.series[name])] = record.series[name]
        _put_variable(file, series, values).cell_methods = series.cell_method
    profiles = variables_of("profile")
    for name in records[0].profiles:
        values = np.stack([record.profiles[name] for record in records])
        _put_variable(file, profiles[name], values)
    _write_tables(file, records)
    particles = variables_of("particle")
    for name, frames in records[0].snapshots.items():
        states = slice(None) if "frame" in particles[name].dims else 0
        if frames[0].size:
            values = np.array([record.snapshots[name][states] for record in records])
            _put_variable(file, particles[name], values)
    scalars = SCALARS | observable_variables(FUNCTION)
    for name in records[0].scalars:
        values = np.array([record.scalars[name] for record in records])
        _put_variable(file, scalars[name], values)


def read_stored_run(path: Path, parameters: Parameters) -> StoredRun | None:
    """Return the run in a run file of the same point and numerics.

    None where there is no such file, or where it is damaged or reduced. Raises ``OSError`` where
    the system does not give its bytes.
    """
    with suppress(InputError), open_run_file(path) as file:
        attributes = read_attributes(file)
        if is_run_of(attributes, parameters) and has_all(attributes, None):
            held = amounts_of(file, amounts(parameters)).items()
            values = {name: type(getattr(parameters, name))(value) for name, value in held}
            numbers = range(file.dimensions["replicate"].size)
            records = [_read_record(file, number) for number in numbers]
            return StoredRun(parameters.model_copy(update=values), records)
    return None


def _read_record(file: netCDF4.Dataset, index: int) -> Record:
    """Return the record of one replicate from a run file."""
    record = Record({})
    for name, variable in file.variables.items():
        dimensions = variable.dimensions
        if dimensions[:1] != ("replicate",) or name == "replicate":
            continue
        values = variable[index]
        if len(dimensions) == 1:
            record.scalars[name] = str(values) if variable.dtype is str else values.item()
        elif name in variables_of("particle"):
            record.snapshots[name] = list(values) if "frame" in dimensions else [values]
        elif dimensions[1:2] == ("trajectory_time",):
            record.frames[name] = values
        elif name == "path":
            record.path = None if np.isnan(values).all() else values
        elif dimensions == ("replicate", "time"):
            record.series[name] = values
        elif dimensions == ("replicate", "height") and not variables_of("profile")[name].asked_by:
            record.profiles[name] = values
        else:
            record.tables[name] = values
    return record
