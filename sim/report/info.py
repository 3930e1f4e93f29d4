"""A summary of a run file as text, and the point file that reproduces it."""

import json
from pathlib import Path

import netCDF4

from sim.dataset.replicates import caveats, layer_orders
from sim.engine.stored_run import RunFile, open_run_file, parameters_of, summary_of
from sim.parameters import Parameters, as_yaml, complete_values, field_info
from sim.parameters.variables import SCALARS

_PER_REPLICATE = tuple(name for name in SCALARS if name != "replicate_seed")
_PROVENANCE = (
    "engine_version",
    "numerics",
    "source_hash",
    "created",
    "versions",
    "machine",
    "command",
)


def describe(path: str | Path, as_point: bool = False) -> str:
    """Describe a run file.

    Parameters
    ----------
    path : str or Path
        The run file.
    as_point : bool
        Return the text of a point file that reproduces the run instead.

    Raises
    ------
    InputError
        When there is no such file, or it is not a run file.
    """
    path = Path(path)
    with open_run_file(path) as file:
        parameters = parameters_of(file, path)
        run = summary_of(path)
        scalars = run.scalars | {"layer_order": layer_orders(RunFile(file), parameters)}
        caveat = caveats(run.attrs.get("caveat", ""), scalars, parameters)
        return as_yaml(parameters).rstrip() if as_point else _summary(file, parameters, caveat)


def _summary(file: netCDF4.Dataset, parameters: Parameters, caveat: str) -> str:
    sizes = ", ".join(f"{name} {len(dimension)}" for name, dimension in file.dimensions.items())
    head = [file.getncattr("point_id"), f"status: {file.getncattr('status')}"]
    if file.getncattr("reason"):
        head.append(f"reason: {file.getncattr('reason')}")
    if caveat:
        head.append(f"caveat: {caveat}")
    if "adopted" in file.ncattrs():
        head.append(f"only its row of dataset {file.adopted}, which was adopted")
    sections = [
        [*head, f"particles: {parameters.particles:,}", f"dimensions: {sizes}"],
        ["parameters", *_indent(_parameter_lines(parameters))],
        ["replicates", *_indent(_replicate_lines(file))],
        ["provenance", *_indent(_attribute_lines(file))],
    ]
    return "\n\n".join("\n".join(lines) for lines in sections)


def _indent(rows: list[tuple[str, str]]) -> list[str]:
    width = max(len(name) for name, _ in rows)
    return [f"  {name:<{width}}  {text}".rstrip() for name, text in rows]


def _parameter_lines(parameters: Parameters) -> list[tuple[str, str]]:
    values = complete_values(parameters)
    lines = []
    for name, row in field_info(parameters).items():
        value, unit = values[name], row.scale or row.unit
        text = f"{value:g}" if isinstance(value, float) else json.dumps(value).strip('"')
        lines.append((name, text if unit in ("", "1") else f"{text} {unit}"))
    limits = parameters.limits.items()
    return lines + [(name, f"{value:.6g} m s-2") for name, (value, _) in limits]


def _replicate_lines(file: netCDF4.Dataset) -> list[tuple[str, str]]:
    lines = []
    for name in _PER_REPLICATE:
        if name not in file.variables:
            continue
        variable = file.variables[name]
        values = [v if isinstance(v, str) else f"{v:.6g}" for v in variable[:].tolist()]
        if not any(values):
            continue
        unit = getattr(variable, "units", "")
        lines.append((name if unit in ("", "1") else f"{name} ({unit})", " | ".join(values)))
    return lines


def _attribute_lines(file: netCDF4.Dataset) -> list[tuple[str, str]]:
    return [(name, file.getncattr(name)) for name in _PROVENANCE if name in file.ncattrs()]
