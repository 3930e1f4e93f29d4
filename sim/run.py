"""One point -> one netCDF file: settle, transient, averaging window, for every replicate."""

import logging
import platform
import shlex
import sys
import time
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

import numpy as np

from sim import __version__
from sim.dynamics.status import BlowUp
from sim.observe.recorder import Record, Recorder
from sim.observe.run_file import write
from sim.parameters import Parameters, point_id
from sim.progress import length, progress
from sim.provenance import library_versions, source_hash
from sim.systems import System, build

log = logging.getLogger("talus")

#: Exit code of a run that was stopped by a blow-up; its file says why.
BLOWN_UP = 3


@dataclass(frozen=True)
class Layout:
    """What the replicates of a run have in common.

    ``time`` (T,) end of each sample interval (s), ``height`` (H,) centres of the slices (m),
    ``series`` name -> (unit, long name), ``axes`` names of the directions.
    """

    time: np.ndarray
    height: np.ndarray
    series: dict[str, tuple[str, str]]
    axes: tuple[str, ...]


def run_point(
    parameters: Parameters, output: Path, quiet: bool = False, record_failure: bool = False
) -> int:
    """Run all replicates of a point and write its file.

    Parameters
    ----------
    parameters : Parameters
        The point.
    output : Path
        The netCDF file; it appears, complete, at the end.
    quiet : bool
        Neither bar nor log lines about progress.
    record_failure : bool
        Count a blow-up as a result: the file says what happened and the exit code is 0.

    Returns
    -------
    int
        Exit code: 0, or 3 when a replicate blew up.
    """
    started = time.perf_counter()
    log.info("%s: %d particles, %s", point_id(parameters), parameters.particles, length(parameters))
    if parameters.caveat:
        log.warning("%s: %s", point_id(parameters), parameters.caveat)
    records = []
    with progress(parameters, output, quiet) as advanced:
        for replicate in range(parameters.replicates):
            system = build(parameters, replicate)
            records.append(_run_replicate(system, parameters, replicate, advanced))
    wall = time.perf_counter() - started
    reasons = [record.scalars["reason"] for record in records if record.scalars["reason"]]
    write(
        output,
        parameters,
        records,
        _layout(parameters, system, max(len(r.series["mean_velocity"]) for r in records)),
        _attributes(parameters, records, reasons, wall),
    )
    for record in records:
        log.log(*_closing_line(point_id(parameters), record))
    log.info("%s: written", output)
    return BLOWN_UP if reasons and not record_failure else 0


def _run_replicate(system: System, parameters: Parameters, replicate: int, advanced) -> Record:
    """Run one replicate to its end or to its blow-up."""
    started = time.perf_counter()
    recorder = Recorder(system)
    failure = ""
    try:
        system.settle()
        recorder.take_snapshot()
        while not recorder.stopped:
            recorder.take(system.advance())
            advanced(parameters.sample_steps)
    except BlowUp as error:
        failure = str(error)
        if not recorder.snapshots:
            recorder.take_snapshot()
    recorder.take_snapshot()
    record = recorder.finish(failure)
    record.scalars |= {
        "steps": recorder.taken * parameters.sample_steps,
        "wall_time": time.perf_counter() - started,
        "replicate_seed": replicate,
    }
    return record


def _closing_line(name: str, record: Record) -> tuple[int, str]:
    """Return level and text of the line that says how a replicate ended."""
    values = record.scalars
    if values["reason"]:
        return logging.WARNING, f"{name}: failed: {values['reason']}"
    return logging.INFO, (
        f"{name}: velocity {values['velocity']:.4g} ± {values['velocity_half_width']:.2g} m/s, "
        f"{values['regime']}, {values['quality']}, stopped by {values['stopped']}"
    )


def _layout(parameters: Parameters, system: System, samples: int) -> Layout:
    interval = parameters.sample_steps * parameters.time_step
    return Layout(
        time=np.arange(1, samples + 1) * interval,
        height=system.profile_height,
        series=system.series,
        axes=("x", "y", "z") if parameters.system == "chute" else ("x", "z"),
    )


def _attributes(
    parameters: Parameters, records: list[Record], reasons: list[str], wall: float
) -> dict:
    """Return the global attributes: what this is and how it was made."""
    versions = " ".join(f"{name} {number}" for name, number in library_versions().items())
    return {
        "Conventions": "CF-1.11",
        "title": f"Talus run {point_id(parameters)}",
        "system": parameters.system,
        "point_id": point_id(parameters),
        "engine_version": __version__,
        "source_hash": source_hash(),
        "created": datetime.now(UTC).isoformat(timespec="seconds"),
        "versions": versions,
        "machine": platform.machine(),
        "command": shlex.join(["python", "-m", "sim", *sys.argv[1:]]),
        "status": "failed" if reasons else "completed",
        "reason": "; ".join(reasons),
        "caveat": parameters.caveat,
        "steps": sum(record.scalars["steps"] for record in records),
        "wall_time": wall,
    }
