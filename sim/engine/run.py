"""Run a point into a netCDF file: settling, transient and averaging window of every replicate.

An existing run file of the point is continued from its records.
"""

import logging
import platform
import shlex
import sys
from collections import Counter
from contextlib import nullcontext
from datetime import UTC, datetime
from functools import cache
from pathlib import Path

import numpy as np

from sim.base.files import file_lock
from sim.base.program import __version__
from sim.base.statistics import mean_interval
from sim.engine.identity import NUMERICS, library_versions, source_hash
from sim.engine.progress import length, progress
from sim.engine.replicate import Origin, begin, origin_of, stored_replicate
from sim.engine.run_file import StoredRun, read_stored_run, write
from sim.engine.states import States, checkpoint_interval
from sim.engine.stored_run import current_status, is_alike, length_of, read_origin_samples
from sim.engine.systems.recorder import Record
from sim.parameters import Parameters, amounts, point_id, with_larger_amounts
from sim.parameters.laws import FUNCTION_NAME as FUNCTION
from sim.parameters.variables import observable_variables

log = logging.getLogger("talus")

#: The hash of the sources when this process first asks for it, even if the files change later.
engine_hash = cache(source_hash)

#: Exit code of a run that was stopped by a blow-up; the reason is in its file.
BLOW_UP_CODE = 3


def run_point(
    parameters: Parameters,
    output: Path,
    quiet: bool = False,
    record_failure: bool = False,
    temporary: bool = False,
) -> int:
    """Run all replicates of a point and write its file; return the exit code.

    The netCDF file ``output`` appears, complete, at the end. An existing one grows; it is left
    unchanged where it has all amounts of the point. ``quiet``: neither bar nor log lines about
    progress. ``record_failure``: a blow-up counts as a result: the file holds the reason and the
    exit code is 0, else 3. ``temporary``: the file will not last, so that no message sends anybody
    there.
    """
    name = point_id(parameters)
    log.info("%s: %d particles, %s", name, parameters.particles, length(parameters))
    if parameters.caveat:
        log.warning("%s: %s", name, parameters.caveat)
    with file_lock(output):
        origin = origin_of(parameters, output)
        is_old = origin is not None and not is_alike(origin.samples, read_origin_samples(output))
        if is_old:
            log.info("%s: what it starts from has gone on; computed anew", name)
        status = "" if is_old else current_status(output, parameters)
        if status:
            log.info("%s: already there", output)
        else:
            status = _compute(parameters, output, quiet, origin, is_old)
            if status == "failed" and not temporary:
                command = shlex.join(["python", "-m", "sim", "points", str(output), "--point"])
                log.warning("%s: its point, to see the failure again: %s", name, command)
            if not temporary:
                log.info("%s: written", output)
    return BLOW_UP_CODE if status == "failed" and not record_failure else 0


def _compute(
    parameters: Parameters, output: Path, quiet: bool, origin: Origin | None, is_old: bool
) -> str:
    """Run the missing parts of a point; write the file and return its status.

    Records of a run file of the same point are reused where their lengths are the same, and
    replicates continue from their stored states. Where ``is_old``, the run file started from
    another state, and nothing of it is reused.
    """
    stored = None if is_old else read_stored_run(output, parameters)
    records: list[Record] = []
    if stored:
        parameters = with_larger_amounts(parameters, amounts(stored.parameters))
        if length_of(stored.parameters) == length_of(parameters):
            records += stored.records
    samples = origin.samples if origin else ()
    states = States(output, parameters, checkpoint_interval(), samples)
    numbers = range(len(records), parameters.replicates)
    stored_samples = states.samples(numbers)
    if stored or stored_samples:
        log.info("%s: %s", output, "grows" if stored else "continued from a checkpoint")
    done = len(records) * parameters.steps + sum(stored_samples) * parameters.sample_steps
    quietly = nullcontext(lambda _: None)
    follow = progress(parameters, output, quiet, done) if parameters.is_flow else quietly
    with states, follow as report_steps:
        for number in numbers:
            replicate = stored_replicate(states, parameters, number) or begin(parameters, number)
            records.append(replicate.run(report_steps, states, origin and origin.start))
    if parameters.is_flow:
        # Before the run file: the states must be at least as far as its records.
        states.save()
    attributes = _attributes(parameters, records) | replicate.system.provenance
    if origin:
        attributes["origin"] = " ".join(map(str, samples[: parameters.replicates]))
    write(output, StoredRun(parameters, records), replicate.system, attributes)
    for record in records:
        log.log(*_closing_line(parameters, record))
    if len(records) > 1:
        log.info(_summary_line(parameters, records))
    return attributes["status"]


def _closing_line(parameters: Parameters, record: Record) -> tuple[int, str]:
    """Return level and text of the log line with the result of a replicate."""
    name, values = point_id(parameters), record.scalars
    if values["reason"]:
        return logging.WARNING, f"{name}: failed: {values['reason']}"
    if returned := values.keys() & observable_variables(FUNCTION):
        texts = (f"{key} {values[key]:.6g}" for key in values if key in returned)
        return logging.INFO, f"{name}: {', '.join(texts)}"
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


def _summary_line(parameters: Parameters, records: list[Record]) -> str:
    """Return the log line with the statistics pooled over several replicates."""
    name, scalars = point_id(parameters), [record.scalars for record in records]
    failed = sum(bool(values["reason"]) for values in scalars)
    if failed:
        return f"{name}: failed: {failed} of {len(records)} replicates"
    if not parameters.is_flow:
        return f"{name}: {len(records)} replicates"
    velocities = np.array([values["velocity"] for values in scalars])
    half_width, _ = mean_interval(
        velocities, np.array([values["velocity_half_width"] for values in scalars])
    )
    counts = Counter(str(values["regime"]) for values in scalars).most_common()
    regimes = ", ".join(f"{count} {regime}" if counts[1:] else regime for regime, count in counts)
    # The point's own regime is found later, from all replicates together.
    velocity = _velocity(velocities.mean(), half_width)
    return f"{name}: {velocity}; {len(records)} replicates, each by itself: {regimes}"


def _velocity(value: float, half_width: float) -> str:
    """Return the text of a mean velocity with its 95 % interval, where that is known."""
    if np.isnan(half_width):
        return f"velocity {value:.4g} m/s, interval not known"
    return f"velocity {value:.4g} ± {half_width:.2g} m/s"


def _attributes(parameters: Parameters, records: list[Record]) -> dict:
    """Return the global attributes: identity, provenance and outcome of the run."""
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
        **({"velocity_unit": parameters.velocity_unit} if parameters.is_flow else {}),
        "status": "failed" if reasons else "completed",
        "reason": "; ".join(reasons),
        "caveat": parameters.caveat,
        "steps": sum(record.scalars["steps"] for record in records),
        "wall_time": sum(record.scalars["wall_time"] for record in records),
    }
