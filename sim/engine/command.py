"""The commands ``run`` and ``batch``: points in, run files or a line about what is wrong out."""

import json
import logging
import signal
import sys
from pathlib import Path

from sim.base.errors import InputError
from sim.base.files import require_writable
from sim.base.program import program
from sim.base.yaml import read_yaml
from sim.parameters import Parameters, parse_point, point_id

log = logging.getLogger("talus")

SYSTEM_ERROR = 1

#: What numpy says of an array that no address could reach, and of one that no integer could count.
TOO_LARGE = ("Maximum allowed dimension exceeded", "negative dimensions are not allowed")


class _BeyondAllMachines(Exception):
    """No machine can compute the point; the message says which and why."""


def run(point: str, output: Path, quiet: bool, record_failure: bool) -> int:
    """Run one point, unless its run file is there already, and return the exit code.

    Parameters
    ----------
    point : str
        The point file, or ``-`` for standard input.
    output : Path
        The run file; its folder is made.
    quiet : bool
        Neither bar nor log lines about progress.
    record_failure : bool
        Count a blow-up as a result: the file says what happened and the exit code is 0.

    Returns
    -------
    int
        0; 3 for a run that failed; 1 where no machine could compute the point.

    Raises
    ------
    InputError
        When the point or the output cannot be used.
    """
    parameters = _point(point)
    _require_usable(output, point)
    output.parent.mkdir(parents=True, exist_ok=True)
    level = logging.WARNING if quiet else logging.INFO
    logging.basicConfig(format="%(message)s", level=level, stream=sys.stderr)
    signal.signal(signal.SIGINT, save_and_end)
    try:
        return _run_one(parameters, output, quiet, record_failure)
    except _BeyondAllMachines as error:
        print(f"error: {error}", file=sys.stderr)
        return SYSTEM_ERROR


def batch(results: Path) -> int:
    """Run points one after the other in this process, those with a current run file left out.

    Each has a run file, a log and a checkpoint of its own, and a blow-up counts as a result. What
    goes wrong with one keeps no other from being run.

    Parameters
    ----------
    results : Path
        Folder of the results of a study, in which run files go to ``runs/<id>.nc`` and logs to
        ``logs/runs/<id>.log``. The points are a JSON list on the standard input.

    Returns
    -------
    int
        0; 1 where a point could not be run, as its log says.

    Raises
    ------
    InputError
        When a point or the folder cannot be used.
    """
    points = [parse_point(mapping, "<stdin>") for mapping in json.load(sys.stdin)]
    runs, logs = results / "runs", results / "logs" / "runs"
    for folder in (runs, logs):
        require_writable(folder, "results")
        folder.mkdir(parents=True, exist_ok=True)
    logging.getLogger().setLevel(logging.INFO)
    signal.signal(signal.SIGINT, save_and_end)
    codes = [_logged(point, runs, logs) for point in points]
    return SYSTEM_ERROR if any(codes) else 0


def _logged(parameters: Parameters, runs: Path, logs: Path) -> int:
    """Run a point with a log of its own; return the exit code."""
    name = point_id(parameters)
    handler = logging.FileHandler(logs / f"{name}.log", mode="w", encoding="utf-8")
    root = logging.getLogger()
    root.addHandler(handler)
    try:
        return _run_one(parameters, runs / f"{name}.nc", quiet=False, record_failure=True)
    except SystemExit:
        print(f"{name}: terminated; the next start continues it", file=sys.stderr)
        raise
    except (_BeyondAllMachines, InputError) as error:
        log.error("error: %s", error)
        print(f"error: {error}", file=sys.stderr)
        return SYSTEM_ERROR
    except Exception:
        log.exception("%s: the program has gone wrong", name)
        print(
            f"error: {name}: the program has gone wrong, see {handler.baseFilename}",
            file=sys.stderr,
        )
        return SYSTEM_ERROR
    finally:
        root.removeHandler(handler)
        handler.close()


def _run_one(parameters: Parameters, output: Path, quiet: bool, record_failure: bool) -> int:
    """Run a point unless its run file is there; return the exit code."""
    # A mistake in a point is told without waiting for these.
    from sim.engine.run import BLOWN_UP, run_point
    from sim.engine.stored_run import current_status

    # A run that starts from another is current only if that has not gone on.
    if not parameters.start_from and (status := current_status(output, parameters)):
        log.info("%s: already there", output)
        return BLOWN_UP if status == "failed" and not record_failure else 0
    try:
        return run_point(parameters, output, quiet=quiet, record_failure=record_failure)
    except (MemoryError, ArithmeticError, ValueError) as error:
        # From values that are allowed one by one, and together beyond all memory or numbers.
        if isinstance(error, ValueError) and not str(error).startswith(TOO_LARGE):
            raise
        said = " ".join(str(error).split()) or "out of memory"
        raise _BeyondAllMachines(f"{point_id(parameters)}: cannot be computed: {said}") from None


def save_and_end(*_: object) -> None:
    """Answer an interrupt as a running computation answers SIGTERM; the second one ends at once."""
    signal.signal(signal.SIGINT, signal.default_int_handler)
    if signal.getsignal(signal.SIGTERM) is signal.SIG_DFL:
        raise KeyboardInterrupt
    signal.raise_signal(signal.SIGTERM)


def _point(path: str) -> Parameters:
    mapping = read_yaml(path)
    source = "<stdin>" if path == "-" else path
    if isinstance(mapping, dict) and "study" in mapping and "system" not in mapping:
        raise InputError(f"{source}: a study, not a point; {program()} study {source} runs it")
    return parse_point(mapping, source)


def _require_usable(output: Path, point: str) -> None:
    require_writable(output.parent, "--output")
    if output.exists() and not output.is_file():
        raise InputError.of_value("--output", "", str(output), "the name of a plain file")
    if point != "-" and output.resolve() == Path(point).resolve():
        raise InputError.of_value("--output", "", str(output), "not the point file itself")
