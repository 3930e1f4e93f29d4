"""An initial state that is given: a table of particles in place of the random packing.

A point has the hash of its table, so its id depends on the content and on no path. This process
keeps the tables by their hashes; run files have them as text, and jobs find them beside run files.
"""

import hashlib
import re
from collections.abc import Iterable, Mapping
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from sim.base.errors import InputError
from sim.base.files import atomic_write
from sim.base.measured import FILE, PURE, MeasuredTable, parse_table, read_measured
from sim.base.messages import one_of
from sim.parameters.common import (
    LARGEST,
    MAX_PARTICLES,
    SMALLEST,
    Parameters,
    canonical_number,
    sphere_volume,
)
from sim.parameters.images import usual_cell, wider_cell

if TYPE_CHECKING:
    import numpy as np

#: Columns of a table and their units, which headings may leave out; and those of sizes, above 0.
UNITS = dict.fromkeys(("x", "y", "z", "radius", "diameter"), "m")
UNITS |= dict.fromkeys(("vx", "vy", "vz"), "m/s") | dict.fromkeys(("wx", "wy", "wz"), "1/s")
UNITS |= {"mass": "kg", "density": "kg/m³"}
_SIZES = ("radius", "diameter", "mass", "density")

#: Units of lengths that are multiples of the diameter of the point; the first is written.
_DIAMETERS = ("d", "σ", "⟨d⟩")

#: Columns that particles in a plane lack.
_OUT_OF_PLANE = ("y", "vy", "wx", "wz")


class GivenState(NamedTuple):
    """A ``table`` as it was read, the ``columns`` by name in the ``units`` m, d, m/s, 1/s, kg and
    kg/m³, and their ``text``, whose hash is that of the state. ``file`` is none of a text."""

    table: MeasuredTable
    columns: Mapping[str, tuple[float, ...]]
    units: Mapping[str, str]
    text: str
    file: Path | None


#: Folder beside run files with the states of their points.
STATES = ".states"

#: The states that this process has read, by hash.
_known: dict[str, GivenState] = {}


def remember(state: GivenState) -> str:
    """Keep a state for the points of this process; return its hash."""
    name = hashlib.sha256(state.text.encode()).hexdigest()[:12]
    _known.setdefault(name, state)
    return name


def remember_text(text: str, path: Path) -> None:
    """Keep the state in the text of a table, which messages name by ``path``."""
    remember(_state_of_text(text, str(path)))


def state_of(point: Parameters) -> GivenState | None:
    """Return the given state of a point, None without one and where it has not been read."""
    return _known.get(point.initial_state[:12])


def with_state(
    values: Mapping[str, Any], model: type[Parameters], source: str, paths: Mapping[str, str]
) -> dict[str, Any]:
    """Return values of parameters with the hash of a given state, and the depth that follows.

    It is given as the name of a CSV file beside ``source``, or as the text of such a file.
    """
    given = values.get("initial_state")
    given = given if isinstance(given, str) else ""
    is_table = "\n" in given or re.match(FILE, given)
    cell = values.get("cell", usual_cell(0, 0))
    sides = cell if isinstance(cell, list | tuple) else [cell, values.get("cell_across") or cell]
    are_sides = len(sides) == 2 and all(type(one) in (int, float) and one > 0 for one in sides)
    if not is_table or not are_sides:
        return dict(values)
    if "\n" in given:
        place = f"{source}: {paths.get('initial_state', 'initial_state')}"
        state = _state_of_text(given, place)
    else:
        path = Path(source).parent / given
        state = _state_of_table(read_measured(path), path)
    number = len(state.columns["x"])
    if "beads" in model.model_fields:
        key, value, count = "beads", number, values.get("beads", number)
    else:
        along, across = map(canonical_number, sides)
        area = along * (1 if values.get("shape") == "disc" else across)
        key, value = "depth", canonical_number(number / area)
        depth = values.get("depth", value)
        count = round(depth * area) if type(depth) in (int, float) and abs(depth) < 1e15 else depth
    if count != number:
        allowed = f"{value:.12g}, or nothing: {state.table.path} has {number} particles"
        raise InputError.of_value(source, paths.get(key, key), values[key], allowed)
    return {**values, "initial_state": remember(state), key: value}


@lru_cache(64)
def _state_of_text(text: str, place: str) -> GivenState:
    return _state_of_table(parse_table(text, Path(place)), None)


def _state_of_table(table: MeasuredTable, file: Path | None) -> GivenState:
    """Return the state in a table; raise ``InputError`` for other columns, and for no numbers."""
    for name in table.texts:
        if name not in UNITS:
            raise InputError.of_value(table.path, "heading", name, one_of(name, UNITS))
    for name, other in (("radius", "diameter"), ("mass", "density")):
        if name in table.texts and other in table.texts:
            raise InputError.of_value(table.path, "heading", other, f"{name} or {other}, not both")
    for name in ("x", "z"):
        table.require_column(name, "places of the particles")
    own, columns, units = dict(table.units), dict[str, tuple[float, ...]](), dict[str, str]()
    for name, unit in UNITS.items():
        if name not in table.texts:
            continue
        units[name] = _DIAMETERS[0] if unit == "m" and own[name] in _DIAMETERS else unit
        own[name] = "" if units[name] != unit else own[name].replace("rad", PURE)
        least = SMALLEST if name in _SIZES else -LARGEST
        columns[name] = replace(table, units=own).numbers(
            name, PURE if units[name] != unit else unit, low=least, high=LARGEST
        )
    if "diameter" in columns:
        columns["radius"] = tuple(0.5 * one for one in columns.pop("diameter"))
        units["radius"] = units.pop("diameter")
    at_rest = [one for one in columns if one[0] in "vw" and not any(columns[one])]
    columns = {name: columns[name] for name in UNITS if name in columns and name not in at_rest}
    lines = [",".join(f"{name} ({units[name]})" for name in columns)]
    lines += [",".join(map(repr, row)) for row in zip(*columns.values(), strict=True)]
    return GivenState(table, columns, units, "\n".join([*lines, ""]), file)


def table_text(state: Any, source: str) -> str:
    """Return a state that is given in Python as the text of a table.

    That is a data frame, a mapping of columns, or an `xarray.Dataset` with the particles of a run.
    Raises ``InputError``, which names ``source``, for anything else.
    """
    import pandas as pd

    if hasattr(state, "data_vars"):
        state = _columns_of_run(state, source)
    try:
        return pd.DataFrame(state).to_csv(index=False)
    except (TypeError, ValueError):
        allowed = "a data frame, a mapping of columns to numbers, or a Dataset of particles"
        raise InputError.of_value(source, "state", state, allowed) from None


def _columns_of_run(run: Any, source: str) -> dict[str, Any]:
    """Return the columns of the mobile particles in the last state of a run of one replicate."""
    last = run.isel(frame=-1) if "frame" in run.dims else run
    sizes = [name for name in ("position", "particle_velocity", "radius") if name not in last]
    if sizes or last.sizes.get("replicate", 1) != 1:
        allowed = "a Dataset with position, particle_velocity and radius of one replicate"
        raise InputError.of_value(source, "state", list(run.data_vars)[:4], allowed)
    last = last.isel(replicate=0) if "replicate" in last.dims else last
    mobile = last["fixed"].values == 0 if "fixed" in last else slice(None)
    axes = [bytes(one).decode() if isinstance(one, bytes) else str(one) for one in last.axis.values]
    columns = {"radius": last["radius"].values[mobile]}
    for name, prefix in (("position", ""), ("particle_velocity", "v"), ("particle_spin", "w")):
        for number, axis in enumerate(axes if name in last else ()):
            columns[prefix + axis] = last[name].values[mobile, number]
    return columns


class Particles(NamedTuple):
    """Given particles in SI: ``position``, ``velocity`` and ``spin`` (N, 3), y along the second
    axis, ``radius`` and ``mass`` (N,)."""

    position: "np.ndarray"
    velocity: "np.ndarray"
    spin: "np.ndarray"
    radius: "np.ndarray"
    mass: "np.ndarray"


def _sides(p: Parameters) -> list[float]:
    """Return the sides (m) of the periodic cell: along the flow, and across where it has one."""
    return [p.period] if p.is_flat else [p.period, p.breadth * p.diameter]


def given_particles(p: Parameters) -> Particles:
    """Return the particles of the given state of a point.

    Without columns they rest in the middle across the flow, have the diameter of the point and are
    of its material. Raises ``InputError`` where this process has not read the state.
    """
    import numpy as np

    state = state_of(p)
    if state is None:
        allowed = "a CSV file of particles; the content of this one is not at hand"
        raise InputError.of_value(p.system, "initial_state", p.initial_state, allowed)
    number = len(state.columns["x"])

    def column(name: str, usual: Any = 0.0) -> np.ndarray:
        scale = p.diameter if state.units.get(name) == _DIAMETERS[0] else 1.0
        return scale * np.array(state.columns.get(name, np.broadcast_to(usual, number)), float)

    def vectors(names: str, prefix: str = "") -> np.ndarray:
        return np.stack([column(prefix + name) for name in names], axis=1)

    flat, radius = p.is_flat, column("radius", 0.5 * p.diameter)
    position = vectors("xyz")
    if "y" not in state.columns and not flat:
        position[:, 1] = 0.5 * _sides(p)[1]
    mass = p.mass * (2.0 * radius / p.diameter) ** (2 if flat else 3)
    if "density" in state.columns:
        mass = column("density") * sphere_volume(1.0) * (2.0 * radius) ** 3
    return Particles(
        position, vectors("xyz", "v"), vectors("xyz", "w"), radius, column("mass", mass)
    )


def require_possible(p: Parameters) -> str:
    """Return the given state of a point with its least sizes, as the point has it.

    Raises ``InputError``, which names the file, a line and a column, for particles outside the
    cell, below the ground, too large, of a mass that the law excludes, or that overlap too much.
    """
    state = state_of(p)
    if state is None:
        return p.initial_state
    x = given_particles(p)
    _require_columns(p, state)
    _require_places(p, state, x)
    if p.axes == 3 and p.option("law").one_mass:
        wrong = abs(x.mass - p.mass) > 1e-9 * p.mass
        if wrong.any():
            allowed = f"particles of {p.mass:g} kg each with this law"
            raise _error(state, wrong, _SIZES[::-1], allowed)
    bumps = getattr(p, "bumps", 0.0)
    largest = x.radius.max()
    narrow = min(_sides(p)) / p.diameter
    reach = getattr(p, "law_reach", 0.0) / p.diameter
    if wider := wider_cell(narrow, float(2.0 * largest / p.diameter), bumps, reach):
        raise _error(state, x.radius == largest, _SIZES, f"smaller ones, or a cell that is {wider}")
    if pair := overlapping_pair(x.position, x.radius, p):
        row, other = max(pair), min(pair)
        line = state.table.lines[other]
        allowed = f"a place that overlaps the particle of line {line} by less than overlap_limit"
        raise state.table.error(row, "x", state.table.texts["x"][row], allowed)
    least = x.mass.min() / p.mass, 2.0 * x.radius.min() / p.diameter, x.mass.max() / p.mass
    is_usual = all(abs(one - 1.0) < 1e-12 for one in least)
    return p.initial_state[:12] + ("" if is_usual else "".join(f"_{one:.12g}" for one in least))


def _error(state: GivenState, wrong: Any, names: Iterable[str], allowed: str) -> InputError:
    """Return the error of the first wrong row in the first of some columns that the table has."""
    row, texts = int(wrong.argmax()), state.table.texts
    name = next((name for name in (*names, *texts) if name in texts), "")
    return state.table.error(row, name, texts[name][row], allowed)


def _require_columns(p: Parameters, state: GivenState) -> None:
    """Refuse motion out of the plane of discs, and spins of particles that do not rotate."""
    rotates = p.axes == 3 and getattr(p, "rotation", True)
    for name, values in state.columns.items():
        is_lacking = (p.is_flat and name in _OUT_OF_PLANE) or (name[0] == "w" and not rotates)
        if is_lacking and any(values):
            row = next(row for row, value in enumerate(values) if value)
            raise state.table.error(row, name, state.table.texts[name][row], "0, or no column")


def _require_places(p: Parameters, state: GivenState, x: Particles) -> None:
    """Refuse particles outside the periodic cell, and below the ground by too large an overlap."""
    for axis, side in enumerate(_sides(p)):
        outside = ~((x.position[:, axis] >= 0.0) & (x.position[:, axis] < side))
        if outside.any():
            allowed = f"a place in the periodic cell, in [0, {side:g}) m"
            raise _error(state, outside, "xy"[axis], allowed)
    overlap = 0.5 * (x.radius - (x.position[:, 2] - p.ground)) / x.radius
    below = ~(overlap < p.overlap_limit)
    if below.any():
        height = x.radius[below.argmax()] * (1.0 - 2.0 * p.overlap_limit) + p.ground
        allowed = f"above {height:.6g} m, where it overlaps the ground by less than overlap_limit"
        raise _error(state, below, ("z",), allowed)


def overlapping_pair(
    position: Any, radius: Any, p: Parameters, movable: int = MAX_PARTICLES
) -> tuple[int, int] | None:
    """Return two particles that overlap by ``overlap_limit`` of their radii or more, if any do.

    One of them is among the first ``movable``.
    """
    # Imported here: it takes a while, and no other points need it.
    import numpy as np
    from scipy.spatial import cKDTree

    box = np.array([p.period, _sides(p)[-1], 0.0])
    place = position % np.where(box > 0.0, box, np.inf)
    tree = cKDTree(np.where(place < np.where(box > 0.0, box, np.inf), place, 0.0), boxsize=box)
    pairs = tree.query_pairs(2.0 * radius.max(), output_type="ndarray")
    pairs = pairs[pairs.min(axis=1) < movable]
    gap = position[pairs[:, 0]] - position[pairs[:, 1]]
    gap[:, :2] -= box[:2] * np.round(gap[:, :2] / box[:2])
    overlap = 1.0 - np.sqrt((gap**2).sum(axis=1)) / radius[pairs].sum(axis=1)
    found = pairs[~(overlap < p.overlap_limit)]
    return (int(found[0, 0]), int(found[0, 1])) if len(found) else None


def write_states(folder: Path, points: Iterable[Parameters]) -> None:
    """Write the given states of points to a folder, where `read_states` finds them."""
    states = {point.initial_state[:12]: state_of(point) for point in points if point.initial_state}
    for name, state in states.items():
        if state:
            folder.mkdir(parents=True, exist_ok=True)
            with atomic_write(folder / f"{name}.csv") as temporary:
                temporary.write_text(state.text, encoding="utf-8")


def read_states(folder: Path, points: Iterable[Parameters]) -> None:
    """Read the given states of points that this process has not read yet."""
    for point in points:
        if point.initial_state and state_of(point) is None:
            path = folder / f"{point.initial_state[:12]}.csv"
            remember(_state_of_table(read_measured(path), path))
