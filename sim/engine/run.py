"""One point -> one netCDF file: settle, transient, averaging window, for every replicate."""

import logging
import platform
import shlex
import sys
from collections import Counter
from datetime import UTC, datetime
from functools import cache
from pathlib import Path

import numpy as np

from sim.base.files import alone
from sim.base.program import __version__
from sim.base.statistics import mean_interval
from sim.engine.identity import NUMERICS, library_versions, source_hash
from sim.engine.observe.recorder import Record
from sim.engine.observe.run_file import Layout, Stage, write
from sim.engine.observe.system import System
from sim.engine.origin import Origin, is_alike, origin_of
from sim.engine.progress import length, progress
from sim.engine.replicate import Replicate
from sim.engine.stages import read_stages
from sim.engine.states import States, checkpoint_interval
from sim.engine.stored_run import current_status, started_at
from sim.parameters import Parameters, amounts, more, point_id

log = logging.getLogger("talus")

#: Of the sources that this process has loaded, whatever becomes of the files.
engine_hash = cache(source_hash)

#: Exit code of a run that was stopped by a blow-up; its file says why.
BLOWN_UP = 3


def run_point(
    parameters: Parameters, output: Path, quiet: bool = False, record_failure: bool = False
) -> int:
    """Run all replicates of a point and write its file.

    Parameters
    ----------
    parameters : Parameters
        The point.
    output : Path
        The netCDF file; it appears, complete, at the end. One that is there grows, and stays as it
        is where it holds all that is wanted.
    quiet : bool
        Neither bar nor log lines about progress.
    record_failure : bool
        Count a blow-up as a result: the file says what happened and the exit code is 0.

    Returns
    -------
    int
        Exit code: 0, or 3 when a replicate blew up.
    """
    name = point_id(parameters)
    log.info("%s: %d particles, %s", name, parameters.particles, length(parameters))
    if parameters.caveat:
        log.warning("%s: %s", name, parameters.caveat)
    with alone(output):
        origin = origin_of(parameters, output)
        is_old = origin is not None and not is_alike(origin.samples, started_at(output))
        if is_old:
            log.info("%s: what it starts from has gone on; computed anew", name)
        status = "" if is_old else current_status(output, parameters)
        if not status:
            status = _compute(parameters, output, quiet, origin, is_old)
            log.info("%s: written", output)
    return BLOWN_UP if status == "failed" and not record_failure else 0


def _compute(
    parameters: Parameters, output: Path, quiet: bool, origin: Origin | None, is_old: bool
) -> str:
    """Run what is wanted and not known yet of a point; write the file and return its status.

    Known are the records of a run file of the same point, as far as the lengths are the same, and
    the states of replicates, which are run on; where ``is_old``, its start is another, nothing is.
    """
    held = [] if is_old else read_stages(output, parameters)
    if held:
        parameters = more(parameters, amounts(held[0].parameters))
    same = bool(held) and _lengths(held[0].parameters) == _lengths(parameters)
    records = list(held[0].records) if same else []
    if held and not same:
        for record in held[0].records:
            # They belong to the longest run alone, and are large.
            record.frames.clear()
    samples = origin.samples if origin else ()
    states = States(output, parameters, checkpoint_interval(), samples)
    left = range(len(records), parameters.replicates)
    known = [states.samples(number) for number in left if number in states]
    if held or known:
        log.info("%s: %s", output, "grows" if held else "continued from a checkpoint")
    done = len(records) * parameters.steps + sum(known) * parameters.sample_steps
    with states, progress(parameters, output, quiet, done) as advanced:
        for number in left:
            replicate = states.replicate(parameters, number) or Replicate(parameters, number)
            records.append(replicate.run(advanced, states, origin and origin.start))
    # They shall know at least as much as the run file.
    states.save()
    stages = [Stage(parameters, records), *(held[1:] if same else held)]
    attributes = _attributes(parameters, records)
    if origin:
        attributes["origin"] = " ".join(map(str, samples[: parameters.replicates]))
    write(output, stages, _layout(parameters, replicate.system), attributes)
    _tell(parameters, output, records)
    return attributes["status"]


def _lengths(parameters: Parameters) -> dict[str, float]:
    """Return the amounts of which a replicate needs to be run for longer."""
    return {name: one for name, one in amounts(parameters).items() if name != "replicates"}


def _tell(parameters: Parameters, output: Path, records: list[Record]) -> None:
    """Log how the replicates ended, each and together."""
    if any(record.scalars["reason"] for record in records):
        command = shlex.join(["python", "-m", "sim", "info", str(output), "--point"])
        log.warning("%s: its point, to see the failure again: %s", point_id(parameters), command)
    for record in records:
        log.log(*_closing_line(parameters, record))
    if len(records) > 1:
        log.info(_together(parameters, records))


def _closing_line(parameters: Parameters, record: Record) -> tuple[int, str]:
    """Return level and text of the line that says how a replicate ended."""
    name, values = point_id(parameters), record.scalars
    if values["reason"]:
        return logging.WARNING, f"{name}: failed: {values['reason']}"
    regime = values["regime"]
    if regime == "accelerating":
        regime += f" at {values['acceleration']:.4g} ± {values['acceleration_half_width']:.2g} m/s²"
        limits = "".join(f", {key} {v:.4g}" for key, (v, _) in parameters.limits.items())
        regime += limits.replace("_", " ")
    velocity = (float(values[key]) for key in ("velocity", "velocity_half_width"))
    return logging.INFO, (
        f"{name}: {_velocity(*velocity)}, {regime}; "
        f"{values['quality']}; stopped: {values['stopped']}"
    )


def _together(parameters: Parameters, records: list[Record]) -> str:
    """Return the line that says what several replicates gave together."""
    name, scalars = point_id(parameters), [record.scalars for record in records]
    failed = sum(bool(each["reason"]) for each in scalars)
    if failed:
        return f"{name}: failed: {failed} of {len(records)} replicates"
    velocities = np.array([each["velocity"] for each in scalars])
    half_width, _ = mean_interval(
        velocities, np.array([each["velocity_half_width"] for each in scalars])
    )
    counts = Counter(str(each["regime"]) for each in scalars).most_common()
    regimes = ", ".join(f"{count} {regime}" if counts[1:] else regime for regime, count in counts)
    return (
        f"{name}: {_velocity(velocities.mean(), half_width)}, {regimes}; {len(records)} replicates"
    )


def _velocity(value: float, half_width: float) -> str:
    """Write a mean velocity with its 95 % interval, where that is known."""
    if np.isnan(half_width):
        return f"velocity {value:.4g} m/s, interval not known"
    return f"velocity {value:.4g} ± {half_width:.2g} m/s"


def _layout(parameters: Parameters, system: System) -> Layout:
    return Layout(
        interval=parameters.sample_steps * parameters.time_step,
        height=system.profile_height,
        series=system.series,
        axes=system.axes,
        coordinates=system.coordinates,
    )


def _attributes(parameters: Parameters, records: list[Record]) -> dict:
    """Return the global attributes: what this is and how it was made."""
    reasons = [str(record.scalars["reason"]) for record in records if record.scalars["reason"]]
    versions = " ".join(f"{name} {number}" for name, number in library_versions().items())
    created = datetime.now(UTC).isoformat(timespec="seconds")
    command = shlex.join(["python", "-m", "sim", *sys.argv[1:]])
    return {
        "Conventions": "CF-1.11",
        "title": f"Talus run {point_id(parameters)}",
        "source": f"Talus {__version__}, numerics {NUMERICS}",
        "history": f"{created}: {command}",
        "system": parameters.system,
        "point_id": point_id(parameters),
        "engine_version": __version__,
        "numerics": NUMERICS,
        "source_hash": engine_hash(),
        "created": created,
        "versions": versions,
        "machine": platform.machine(),
        "command": command,
        "velocity_unit": parameters.velocity_unit,
        "status": "failed" if reasons else "completed",
        "reason": "; ".join(reasons),
        "caveat": parameters.caveat,
        "steps": sum(record.scalars["steps"] for record in records),
        "wall_time": sum(record.scalars["wall_time"] for record in records),
    }
