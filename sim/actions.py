"""What each command of ``python -m sim`` does, given its options.

Each imports what it needs when it is called, so that a run starts without the libraries of the
figures and a figure without those of the engine.
"""

import logging
import shutil
import signal
import sys
import time
from argparse import Namespace
from pathlib import Path

from sim.base.errors import InputError

SYSTEM_ERROR = 1

#: What numpy says of an array that no address could reach.
TOO_LARGE = "Maximum allowed dimension exceeded"

#: What makes a terminal start a new screen, and the seconds of a day.
CLEAR = "\x1b[H\x1b[2J"
DAY = 86_400


def points(options: Namespace) -> None:
    """Print the points of a study, and warnings before them."""
    from sim.report.points import as_json, as_table, warnings
    from sim.study.load import load_study

    study = load_study(options.study, None)
    for warning in warnings(study, options.results):
        print(f"warning: {warning}", file=sys.stderr)
    print(as_json(study) if options.format == "json" else as_table(study))


def status(options: Namespace) -> None:
    """Print how far a study is, again and again if asked to."""
    if options.watch is not None and not 1 <= options.watch <= DAY:
        raise InputError.of_value("--watch", "", options.watch, f"a number in [1, {DAY}]")
    if options.results.exists() and not options.results.is_dir():
        raise InputError.of_value("--results", "", str(options.results), "a folder")

    from sim.report.status import survey
    from sim.report.status_table import as_json, as_text
    from sim.study.load import DEFAULT_STUDY, load_study

    study = load_study(options.study or DEFAULT_STUDY, None)
    is_terminal = sys.stdout.isatty()
    width = shutil.get_terminal_size().columns if is_terminal else None
    while True:
        status = survey(study, options.results)
        shown = as_json(status) if options.format == "json" else as_text(status, width)
        print(f"{CLEAR}{shown}" if is_terminal and options.watch else shown, flush=True)
        if options.watch is None or status.is_over:
            return
        time.sleep(options.watch)


def refine(options: Namespace) -> None:
    """Write the points of a round of refinement."""
    from sim.dataset.rounds import write_round

    print(write_round(options.study, options.round, options.results))


def schema(options: Namespace) -> None:
    """Print the schema of studies and points, or write it with the reference."""
    from sim.study.reference import schema_text, write

    if options.write is None:
        print(schema_text(), end="")
    else:
        write(options.write)


def run(options: Namespace) -> int:
    """Run one point and return the exit code."""
    from sim.base.files import require_writable
    from sim.base.yaml import read_yaml
    from sim.parameters import parse_point, point_id

    mapping = read_yaml(options.point)
    source = "<stdin>" if options.point == "-" else options.point
    if isinstance(mapping, dict) and "study" in mapping and "system" not in mapping:
        raise InputError(f"{source}: a study, not a point; snakemake --configfile {source} runs it")
    parameters = parse_point(mapping, source)
    require_writable(options.output.parent, "--output")
    if options.output.exists() and not options.output.is_file():
        raise InputError.of_value("--output", "", str(options.output), "the name of a plain file")
    if options.point != "-" and options.output.resolve() == Path(options.point).resolve():
        raise InputError.of_value("--output", "", str(options.output), "not the point file itself")
    options.output.parent.mkdir(parents=True, exist_ok=True)
    level = logging.WARNING if options.quiet else logging.INFO
    logging.basicConfig(format="%(message)s", level=level, stream=sys.stderr)

    from sim.engine.current import current_status
    from sim.engine.run import BLOWN_UP, run_point

    if status := current_status(options.output, parameters):
        logging.getLogger("talus").info("%s: already there", options.output)
        return BLOWN_UP if status == "failed" and not options.record_failure else 0
    signal.signal(signal.SIGINT, save_and_end)
    try:
        return run_point(
            parameters, options.output, quiet=options.quiet, record_failure=options.record_failure
        )
    except (MemoryError, ArithmeticError, ValueError) as error:
        # From values that are allowed one by one, and together beyond all memory or numbers.
        if isinstance(error, ValueError) and TOO_LARGE not in str(error):
            raise
        said = " ".join(str(error).split()) or "out of memory"
        print(f"error: {point_id(parameters)}: cannot be computed: {said}", file=sys.stderr)
        return SYSTEM_ERROR


def save_and_end(*_: object) -> None:
    """Answer an interrupt as a running computation answers SIGTERM; the second one ends at once."""
    signal.signal(signal.SIGINT, signal.default_int_handler)
    if signal.getsignal(signal.SIGTERM) is signal.SIG_DFL:
        raise KeyboardInterrupt
    signal.raise_signal(signal.SIGTERM)


def info(options: Namespace) -> None:
    """Print what a run file holds."""
    from sim.report.info import describe

    print(describe(options.run, as_point=options.point))


def warm(options: Namespace) -> None:
    """Compile what points need."""
    from sim.parameters import SYSTEMS

    if options.study is None:
        points = [model() for model in SYSTEMS.values()]
    else:
        from sim.study.load import load_study

        study = load_study(options.study, None)
        points = [point.parameters for point in study.points.values()]

    from sim.engine.warm import warm

    warm(points)


def bench(_: Namespace) -> None:
    """Print speed, start-up and memory."""
    from sim.engine.bench import main as bench

    bench()


def dataset(options: Namespace) -> None:
    """Write the dataset of a study."""
    from sim.dataset.build import build

    print(build(options.study, options.results))


def publish(options: Namespace) -> None:
    """Write the folder of a study that readers need."""
    from sim.report.publish import PUBLISHED, publish

    print(publish(options.study, options.results, options.to or PUBLISHED))


def boundaries(options: Namespace) -> None:
    """Write the boundaries that a study has found."""
    from sim.dataset.boundaries import build

    print(build(options.study, options.results))


def figure(options: Namespace) -> None:
    """Write the files of a figure."""
    from sim.figures.render import draw

    for path in draw(options.name, options.dataset, options.output):
        print(path)


def claims(options: Namespace) -> None:
    """Write the verdicts of a study."""
    from sim.claims.judge import build

    print(build(options.study, options.results))


def report(options: Namespace) -> None:
    """Write the report of a study."""
    from sim.report import build

    print(build(options.study, options.results))
