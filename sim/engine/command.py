"""The commands ``run``, ``batch`` and ``warm``: points become run files, or an error line.

``warm`` compiles the engine before many runs start, so that no two compile the same code.
"""

import hashlib
import json
import logging
import signal
import sys
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager, suppress
from functools import partial
from multiprocessing import get_context
from pathlib import Path

from sim.base.errors import InputError
from sim.base.files import require_writable
from sim.base.program import program
from sim.base.yaml import read_yaml
from sim.engine.identity import cache_directory, library_versions
from sim.parameters import Parameters, canonical_values, parse_point, point_id
from sim.parameters.given import STATES, read_states
from sim.parameters.laws import LAW
from sim.parameters.roles import compiled_parameters

log = logging.getLogger("talus")

SYSTEM_ERROR = 1

#: Errors of numpy for an array beyond the address space, and for a size beyond its integers.
TOO_LARGE = ("Maximum allowed dimension exceeded", "negative dimensions are not allowed")


def run(point: str, output: Path, quiet: bool, record_failure: bool) -> int:
    """Run one point, unless a current run file exists; return 0, or 3 for a run that failed.

    The ``point`` is a file, or ``-`` for standard input; the folder of the run file ``output`` is
    created. For ``quiet`` and ``record_failure`` see `sim.engine.run.run_point`. Raises
    `InputError` when the point or the output cannot be used, and `OSError` when the system fails,
    or no machine could compute the point.
    """
    parameters = _read_point(point)
    _require_usable(output, point)
    output.parent.mkdir(parents=True, exist_ok=True)
    level = logging.WARNING if quiet else logging.INFO
    logging.basicConfig(format="%(message)s", level=level, stream=sys.stderr)
    signal.signal(signal.SIGINT, save_and_end)
    # Imported late, so that an error in a point is reported without waiting for numba.
    from sim.engine.run import run_point

    with _named_if_too_large(parameters):
        return run_point(parameters, output, quiet=quiet, record_failure=record_failure)


def batch(results: Path) -> int:
    """Run points one after the other in this process, except those with a current run file.

    The points are read from standard input as a JSON list. ``results`` is the folder of a study's
    results: run files go to ``runs/<id>.nc`` and logs to ``logs/runs/<id>.log`` in it. A blow-up
    counts as a result, and an error of one point does not stop the others: the exit code is then 1.
    Raises `InputError` when a point or the folder cannot be used.
    """
    listed = None
    with suppress(ValueError, AttributeError):  # without a standard input, there is no such file
        listed = json.load(sys.stdin)
    if not isinstance(listed, list):
        raise InputError("<stdin>: not a list of points; allowed: a JSON list of mappings")
    points = [parse_point(mapping, "<stdin>") for mapping in listed]
    runs, logs = results / "runs", results / "logs" / "runs"
    read_states(runs / STATES, points)
    for folder in (runs, logs):
        require_writable(folder, "results")
        folder.mkdir(parents=True, exist_ok=True)
    logging.getLogger().setLevel(logging.INFO)
    signal.signal(signal.SIGINT, save_and_end)
    codes = [_run_with_log(point, runs, logs) for point in points]
    return SYSTEM_ERROR if any(codes) else 0


def _run_with_log(parameters: Parameters, runs: Path, logs: Path) -> int:
    """Run a point, unless a current run file exists, with its own log; return the exit code."""
    from sim.engine.run import run_point
    from sim.engine.shared_runs import find_runs, take_runs

    name = point_id(parameters)
    path = logs / f"{name}.log"
    # A new file, never one that a link names.
    path.unlink(missing_ok=True)
    handler = logging.FileHandler(path, mode="x", encoding="utf-8")
    root = logging.getLogger()
    root.addHandler(handler)
    try:
        # Another study may have run it since the jobs were planned.
        shared = find_runs(runs, {name: parameters})
        for key in take_runs(runs, shared):
            log.info("%s: taken from %s", key, shared[key].path)
        with _named_if_too_large(parameters):
            return run_point(parameters, runs / f"{name}.nc", record_failure=True)
    except SystemExit:
        print(f"{name}: terminated; the next start continues it", file=sys.stderr)
        raise
    except (InputError, OSError) as error:
        log.error("error: %s", error)
        print(f"error: {error}", file=sys.stderr)
    except Exception:
        log.exception("%s: the program has gone wrong", name)
        print(f"error: {name}: the program has gone wrong, see {path.resolve()}", file=sys.stderr)
    finally:
        root.removeHandler(handler)
        handler.close()
    return SYSTEM_ERROR


@contextmanager
def _named_if_too_large(parameters: Parameters) -> Iterator[None]:
    """Turn errors of a point that no machine can compute into an ``OSError`` that names it.

    Each value is allowed alone, but together they exceed the memory or the range of numbers.
    """
    try:
        yield
    except (MemoryError, ArithmeticError, ValueError) as error:
        if isinstance(error, ValueError) and not str(error).startswith(TOO_LARGE):
            raise
        reason = " ".join(str(error).split()) or "out of memory"
        raise OSError(f"{point_id(parameters)}: cannot be computed: {reason}") from None


def save_and_end(*_: object) -> None:
    """Treat an interrupt as SIGTERM, so that a running computation saves its state and ends.

    A second interrupt ends the process at once.
    """
    signal.signal(signal.SIGINT, signal.default_int_handler)
    if signal.getsignal(signal.SIGTERM) is signal.SIG_DFL:
        raise KeyboardInterrupt
    signal.raise_signal(signal.SIGTERM)


def _read_point(path: str) -> Parameters:
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


def variants(points: Iterable[Parameters]) -> list[Parameters]:
    """Return one small, short point per set of compiled kernels that the points need."""
    small: dict[tuple, Parameters] = {}
    for point in points:
        if not point.is_flow:
            continue
        model = type(point)
        choices = {name: getattr(point, name) for name in compiled_parameters(model)}
        if choices.get("schedule"):
            # All take the same code.
            choices["schedule"] = "angle 0:0 0:0"
        if hasattr(point, LAW.name):
            choices |= point.option(LAW.name).selects(point)
        small[(model, *choices.values())] = model(**model.smallest_values, **choices)
    return list(small.values())


def warm(points: Iterable[Parameters], processes: int = 1) -> None:
    """Compile everything that runs of these points will call, and store it in the cache folder.

    Systems share little code: with several ``processes`` they are compiled in parallel, and a
    process that is left compiles ahead of another one. A mark in the folder says what has been
    compiled there, so that the next call need not load numba.
    """
    small = variants(points)
    mark = cache_directory() / f"warm-{_compiled_for(small)}"
    if mark.exists():
        return
    systems: dict[type, list[Parameters]] = {}
    for point in small:
        systems.setdefault(type(point), []).append(point)
    if processes == 1:
        _compile(small)
    else:
        groups = list(systems.values())
        with ProcessPoolExecutor(processes, get_context("fork")) as pool:
            ahead = pool.map(_compile_ahead, groups[: max(0, processes - len(groups))])
            list(pool.map(_compile, groups))
            list(ahead)
    with suppress(OSError):
        mark.touch()


def _compiled_for(points: Iterable[Parameters]) -> str:
    """Return a hash of points, libraries and processor: a home may be that of several machines."""
    processor = Path("/proc/cpuinfo")
    lines = processor.read_text("utf-8").splitlines() if processor.exists() else []
    kind = {line for line in lines if line.startswith(("model name", "flags", "Features"))}
    # numba keeps code by the path of its source.
    place = str(Path(__file__).parent)
    facts = [canonical_values(point) for point in points], library_versions(), sorted(kind), place
    return hashlib.sha256(repr(facts).encode()).hexdigest()[:12]


def _compile(
    points: Iterable[Parameters], run: Callable[..., object] = lambda task: task()
) -> None:
    from sim.engine.systems import build

    for point in points:
        system = build(point, 0)
        run(system.settle)
        run(partial(system.sample, 1, profiles=True))


def _compile_ahead(points: Iterable[Parameters]) -> None:
    from sim.engine.compile import compile_ahead

    log.setLevel(logging.WARNING)
    _compile(points, compile_ahead)
