"""The page of a run: parameters, results, pictures, log, and how to run it alone."""

import base64
import hashlib
import re
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from multiprocessing import get_context
from operator import itemgetter
from pathlib import Path
from typing import Any

import numpy as np

from sim.base.errors import InputError
from sim.base.files import atomic_write, read_regular, require_writable
from sim.base.seals import read_seal
from sim.dataset.replicates import LEDGER_SCALARS, caveat_of_run, layer_orders
from sim.engine.stored_run import RunFile, open_run_file, parameters_of, summary_of
from sim.measures.layers import missing_energy
from sim.parameters import Parameters, as_yaml, complete_values, default_of, field_info
from sim.parameters.words import setting
from sim.report.numbers import template, value_with_interval

#: Number of lines shown from the end of a log.
LOG_LINES = 40

#: Pattern of the first line of a page: a hash of the run and of the code.
_MARK = rb"<!-- [0-9a-f]{64} -->\n"

#: Attributes of a run on its origin.
_PROVENANCE = ("created", "engine_version", "machine")


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
        Hash of the code that makes pages. If given, pages that this code made from the same run are
        left unchanged.
    processes : int
        Number of processes.

    Raises
    ------
    InputError
        When the folder cannot be written, another file has the name of a page, two runs have the
        same name, or a run file is missing or damaged.
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
    with open_run_file(path) as file:
        mark = f"<!-- {hashlib.sha256(f'{code} {read_seal(path)}'.encode()).hexdigest()} -->\n"
        if code and _begins_with(output, mark.encode()):
            return
        parameters = parameters_of(file, path)
        run = RunFile(file)
        run.require_whole(path)
        caveat = caveat_of_run(summary_of(path), parameters, layer_orders(run, parameters))
        page = _page(run, parameters, caveat, _log_end(path), report)
    with atomic_write(output) as temporary:
        temporary.write_text(mark + page, encoding="utf-8")


def _begins_with(path: Path, mark: bytes) -> bool:
    try:
        return bool(re.match(mark, read_regular(path)))
    except OSError:
        return False


def _log_end(path: Path) -> str:
    """Return the last lines of the log of a run of a study; empty without a log."""
    log = path.absolute().parent.with_name("logs") / "runs" / f"{path.stem}.log"
    try:
        lines = read_regular(log).decode("utf-8", "replace").splitlines()
    except OSError:
        return ""
    return "\n".join(lines[-LOG_LINES:])


def _page(run: RunFile, parameters: Parameters, caveat: str, log: str, report: str) -> str:
    # This import takes a second, which is saved where all pages are up to date.
    from sim.figures.run import animation, pictures

    images = {
        title: _data_uri("image/svg+xml", svg.encode())
        for title, svg in pictures(run, parameters).items()
    }
    movie = animation(run, parameters)
    attributes = run.attrs
    return template("run.html.j2").render(
        point=attributes["point_id"],
        system=parameters.system,
        unusual=unusual_parameters(parameters),
        status=attributes["status"],
        reason=attributes["reason"],
        caveat=caveat,
        particles=parameters.particles,
        replicates=_replicates(run, parameters),
        pictures=images,
        animation=_data_uri("image/webp", movie) if movie else "",
        parameters=_parameters(parameters),
        point_file=as_yaml(parameters),
        log=log,
        report=report,
        origin={name: attributes[name] for name in _PROVENANCE if name in attributes},
    )


def _data_uri(kind: str, content: bytes) -> str:
    return f"data:{kind};base64,{base64.b64encode(content).decode('ascii')}"


def unusual_parameters(parameters: Parameters) -> str:
    """Write the parameters of a point that differ from the paper's."""
    values = complete_values(parameters)
    texts = [
        setting(parameters.system, name, value)
        for name, value in values.items()
        if name != "system" and value != default_of(type(parameters), name, values)
    ]
    return ", ".join(texts) or "all as in the paper"


def _replicates(run: RunFile, parameters: Parameters) -> list[dict[str, Any]]:
    """Return a row per replicate with its results."""
    rows = []
    shared = {"particles": parameters.particles, "mass": parameters.mass}
    ledger = [name for name in LEDGER_SCALARS if name in run]
    for number, status in enumerate(np.asarray(run["status"])):
        texts = {
            name: np.asarray(run[name])[number]
            for name in ("regime", "quality", "stopped", "reason")
        }
        values = (float(run[name][number]) for name in ("velocity", "velocity_half_width"))
        rows.append(
            {name: str(value) for name, value in texts.items()}
            | {
                "number": number,
                "status": str(status),
                "velocity": value_with_interval(
                    *(
                        number_or_nan if np.isfinite(number_or_nan) else None
                        for number_or_nan in values
                    )
                ),
                "overlap": float(run["max_overlap"][number]) if "max_overlap" in run else np.nan,
                "residual": missing_energy(
                    shared | {name: float(run[name][number]) for name in ledger}
                ),
                "samples": float(run["independent_samples"][number]),
                "wall_time": float(run["wall_time"][number]),
            }
        )
    return rows


def _parameters(parameters: Parameters) -> list[dict[str, Any]]:
    """Return a row per parameter: its value, unit and meaning, and whether it is the paper's.

    Those that are not come first.
    """
    values = complete_values(parameters)
    rows: list[dict[str, Any]] = [
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
    return sorted(rows, key=itemgetter("usual"))
