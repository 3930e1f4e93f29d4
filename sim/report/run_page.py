"""The page of a run: what it is, what came out, its pictures, its log, how to run it alone."""

import base64
import hashlib
import re
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np

from sim.base.errors import InputError
from sim.base.files import read_regular, read_seal, replacing, require_writable
from sim.dataset.run_file import RunFile
from sim.engine.stored_run import opened, parameters_of
from sim.parameters import Parameters, as_yaml, complete, default_of, field_info
from sim.parameters.words import setting
from sim.report.numbers import measured
from sim.report.templating import template

#: Last lines of a log that are shown.
LINES = 40

#: How pages begin.
_MARK = rb"<!-- [0-9a-f]{64} -->\n"

#: Attributes of a run that say what made it.
_MADE = ("created", "engine_version", "machine")


def write_pages(
    paths: Sequence[Path], folder: Path, report: str = "", code: str = "", processes: int = 1
) -> None:
    """Write a page per run file, ``<folder>/<name of the run>.html``.

    Parameters
    ----------
    paths : sequence of Path
        The run files.
    folder : Path
        Made if absent.
    report : str
        Address of the report of the study, for a link on each page.
    code : str
        Stands for the code that makes pages. With it, those are left as they are that it has made
        of the same run.
    processes : int
        How many are made side by side.

    Raises
    ------
    InputError
        When the folder cannot be written, something else has the name of a page, two runs have one
        name, or a run file is missing or damaged.
    """
    names = [path.stem for path in paths]
    for path in paths:
        if names.count(path.stem) > 1:
            allowed = "runs of different names, as their pages are named like them"
            raise InputError.of_value("page", "", str(path), allowed)
        if (output := folder / f"{path.stem}.html").exists() and not _begins_with(output, _MARK):
            raise InputError(f"{output}: is there already, and is no page of a run")
    require_writable(folder, "--output")
    folder.mkdir(parents=True, exist_ok=True)
    make = partial(_write, folder=folder, report=report, code=code)
    with ProcessPoolExecutor(max(1, min(processes, len(paths))), get_context("fork")) as pool:
        list(pool.map(make, paths))


def _write(path: Path, folder: Path, report: str, code: str) -> None:
    output = folder / f"{path.stem}.html"
    with opened(path) as file:
        mark = f"<!-- {hashlib.sha256(f'{code} {read_seal(path)}'.encode()).hexdigest()} -->\n"
        if code and _begins_with(output, mark.encode()):
            return
        parameters = parameters_of(file, path)
        page = _page(RunFile(file), parameters, _log_of(path), report)
    with replacing(output) as temporary:
        temporary.write_text(mark + page, encoding="utf-8")


def _begins_with(path: Path, mark: bytes) -> bool:
    try:
        return bool(re.match(mark, read_regular(path)))
    except OSError:
        return False


def _log_of(path: Path) -> str:
    """Return the end of the log of a run of a study, empty where there is none."""
    log = path.absolute().parent.with_name("logs") / "runs" / f"{path.stem}.log"
    try:
        lines = read_regular(log).decode("utf-8", "replace").splitlines()
    except OSError:
        return ""
    return "\n".join(lines[-LINES:])


def _page(run: RunFile, parameters: Parameters, log: str, report: str) -> str:
    # A second, which those do without whose pages are there.
    from sim.figures.run import pictures
    from sim.figures.run_particles import animation

    drawn = {
        title: _address("image/svg+xml", svg.encode())
        for title, svg in pictures(run, parameters).items()
    }
    moving = animation(run, parameters)
    attributes = run.attrs
    return template("run.html.j2").render(
        point=attributes["point_id"],
        system=parameters.system,
        said=said(parameters),
        status=attributes["status"],
        reason=attributes["reason"],
        caveat=attributes.get("caveat", ""),
        particles=parameters.particles,
        replicates=_replicates(run),
        pictures=drawn,
        animation=_address("image/webp", moving) if moving else "",
        parameters=_parameters(parameters),
        point_file=as_yaml(parameters),
        log=log,
        report=report,
        made={name: attributes[name] for name in _MADE if name in attributes},
    )


def _address(kind: str, content: bytes) -> str:
    return f"data:{kind};base64,{base64.b64encode(content).decode('ascii')}"


def said(parameters: Parameters) -> str:
    """Return the parameters of a point that differ from the paper's, in words."""
    values = complete(parameters)
    unusual = [
        setting(parameters.system, name, value)
        for name, value in values.items()
        if name != "system" and value != default_of(type(parameters), name, values)
    ]
    return ", ".join(unusual) or "all as in the paper"


def _replicates(run: RunFile) -> list[dict[str, Any]]:
    """Return a row per replicate: what it came to."""
    rows = []
    for number, status in enumerate(np.asarray(run["status"])):
        held = {
            name: np.asarray(run[name])[number]
            for name in ("regime", "quality", "stopped", "reason")
        }
        values = (float(run[name][number]) for name in ("velocity", "velocity_half_width"))
        rows.append(
            {name: str(value) for name, value in held.items()}
            | {
                "number": number,
                "status": str(status),
                "velocity": measured(*(one if np.isfinite(one) else None for one in values)),
                "overlap": float(run["max_overlap"][number]),
                "residual": float(run["energy_residual"][number]),
                "samples": float(run["independent_samples"][number]),
                "wall_time": float(run["wall_time"][number]),
            }
        )
    return rows


def _parameters(parameters: Parameters) -> list[dict[str, Any]]:
    """Return a row per parameter: its value, unit and meaning, and whether it is the paper's."""
    values = complete(parameters)
    return [
        {
            "name": name,
            "value": f"{value:.6g}" if isinstance(value, float) else str(value),
            "unit": "" if (row.scale or row.unit) == "1" else row.scale or row.unit,
            "meaning": row.description,
            "usual": value == default_of(type(parameters), name, values),
        }
        for name, row in field_info(type(parameters)).items()
        if name != "system"
        for value in [values[name]]
    ]
