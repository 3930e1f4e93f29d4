"""The command line: ``python -m sim COMMAND``.

Each command imports what it needs when it is called, so that a run starts without the libraries
of the figures and a figure without those of the engine.
"""

import argparse
import logging
import os
import shutil
import signal
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from sim import __version__
from sim.errors import InputError

SYSTEM_ERROR = 1
INPUT_ERROR = 2
INTERRUPTED = 130
BROKEN_PIPE = 141

#: What numpy says of an array that no address could reach.
TOO_LARGE = "Maximum allowed dimension exceeded"

#: What makes a terminal start a new screen, and the seconds of a day.
CLEAR = "\x1b[H\x1b[2J"
DAY = 86_400


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command and return its exit code.

    Parameters
    ----------
    arguments : sequence of str, optional
        Command line without the program's name; ``sys.argv`` when omitted.

    Returns
    -------
    int
        0 on success, 2 after a one-line message on standard error for unusable input, 3 from
        ``run`` for a run that failed, 130 after an interrupt; 143 from a ``run`` that saved its
        state first.
    """
    options = _parser().parse_args(arguments)
    try:
        code = options.command(options) or 0
        sys.stdout.flush()
        return code
    except InputError as error:
        print(f"error: {error}", file=sys.stderr)
        return INPUT_ERROR
    except KeyboardInterrupt:
        print("interrupted", file=sys.stderr)
        return INTERRUPTED
    except BrokenPipeError:
        # The reader of a pipe has left; the interpreter's last flush must not complain about it.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return BROKEN_PIPE
    except OSError as error:
        print(f"error: {error}", file=sys.stderr)
        return SYSTEM_ERROR


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m sim", description="Granular flow on a chute and on a vibrating belt."
    )
    parser.add_argument("--version", action="version", version=f"talus {__version__}")
    commands = parser.add_subparsers(title="commands", metavar="COMMAND", required=True)
    for add in (_add_study_commands, _add_run_commands, _add_result_commands):
        add(commands)
    return parser


_Commands = argparse._SubParsersAction
_Command = Callable[[argparse.Namespace], int | None]


def _add(commands: _Commands, name: str, command: _Command, text: str) -> argparse.ArgumentParser:
    parser = commands.add_parser(name, help=text, description=f"{text[0].upper()}{text[1:]}.")
    parser.set_defaults(command=command)
    return parser


def _add_study(parser: argparse.ArgumentParser, **options: Any) -> None:
    parser.add_argument("study", type=Path, metavar="STUDY.yaml", **options)
    parser.add_argument(
        "--results",
        type=Path,
        default=Path("results"),
        metavar="FOLDER",
        help="folder of all results (default: results)",
    )


def _add_study_commands(commands: _Commands) -> None:
    points = _add(commands, "points", _points, "list the points of a study and what they cost")
    _add_study(points)
    points.add_argument("--format", choices=("table", "json"), default="table")
    status = _add(commands, "status", _status, "show how far a study is")
    _add_study(status, nargs="?", help="(default: config/quick.yaml)")
    status.add_argument("--format", choices=("text", "json"), default="text")
    status.add_argument(
        "--watch", type=float, metavar="SECONDS", help="show it again and again until it is over"
    )
    refine = _add(commands, "refine", _refine, "work out the points of a round of refinement")
    _add_study(refine)
    refine.add_argument(
        "round", type=int, metavar="ROUND", help="1 for the first after the study's"
    )
    schema = _add(commands, "schema", _schema, "print the JSON schema of studies and points")
    schema.add_argument(
        "--write",
        nargs="?",
        type=Path,
        const=Path("config"),
        metavar="FOLDER",
        help="write schema.json and the reference in README.md of FOLDER (default: config)",
    )


def _add_run_commands(commands: _Commands) -> None:
    run = _add(commands, "run", _run, "run one point")
    run.add_argument("point", metavar="POINT.yaml", help="- reads standard input")
    run.add_argument("-o", "--output", type=Path, required=True, metavar="RUN.nc")
    run.add_argument("-q", "--quiet", action="store_true", help="no progress, only warnings")
    run.add_argument(
        "--record-failure",
        action="store_true",
        help="exit with 0 after a run that failed, its file says why",
    )
    info = _add(commands, "info", _info, "describe a run file")
    info.add_argument("run", type=Path, metavar="RUN.nc")
    info.add_argument(
        "--point", action="store_true", help="print its parameters as a point file instead"
    )
    warm = _add(commands, "warm", _warm, "compile the engine, so that runs start at once")
    warm.add_argument(
        "study",
        type=Path,
        nargs="?",
        metavar="STUDY.yaml",
        help="compile what this study needs (default: both systems with their default readings)",
    )
    _add(commands, "bench", _bench, "measure speed, start-up and memory")


def _add_result_commands(commands: _Commands) -> None:
    _add_study(_add(commands, "dataset", _dataset, "combine the runs of a study in one dataset"))
    _add_study(_add(commands, "boundaries", _boundaries, "write the boundaries found as CSV"))
    _add_study(_add(commands, "claims", _claims, "judge the claims of both papers on a study"))
    figure = _add(commands, "figure", _figure, "draw one figure from a dataset")
    figure.add_argument("name", metavar="NAME", help="such as walton_2")
    figure.add_argument("dataset", type=Path, metavar="DATASET.nc")
    figure.add_argument("-o", "--output", type=Path, required=True, metavar="FOLDER")
    _add_study(_add(commands, "report", _report, "write the report of a study"))
    publish = _add(commands, "publish", _publish, "copy what readers need of a study")
    _add_study(publish)
    publish.add_argument(
        "--to",
        type=Path,
        default=None,
        metavar="FOLDER",
        help="folder of all published studies (default: results/published)",
    )


def _points(options: argparse.Namespace) -> None:
    from sim.study import load_study
    from sim.tables import as_json, as_table, warnings

    study = load_study(options.study, None)
    for warning in warnings(study, options.results):
        print(f"warning: {warning}", file=sys.stderr)
    print(as_json(study) if options.format == "json" else as_table(study))


def _status(options: argparse.Namespace) -> None:
    if options.watch is not None and not 1 <= options.watch <= DAY:
        raise InputError.of_value("--watch", "", options.watch, f"a number in [1, {DAY}]")
    if options.results.exists() and not options.results.is_dir():
        raise InputError.of_value("--results", "", str(options.results), "a folder")

    from sim.status import survey
    from sim.status_table import as_json, as_text
    from sim.study import DEFAULT_STUDY, load_study

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


def _refine(options: argparse.Namespace) -> None:
    from sim.regime_boundaries import write_round

    print(write_round(options.study, options.round, options.results))


def _schema(options: argparse.Namespace) -> None:
    from sim.reference import schema_text, write

    if options.write is None:
        print(schema_text(), end="")
    else:
        write(options.write)


def _run(options: argparse.Namespace) -> int:
    from sim.folders import require_writable
    from sim.parameters import parse_point, point_id
    from sim.yaml_input import read_yaml

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

    from sim.kept import kept_status
    from sim.run import BLOWN_UP, run_point

    if status := kept_status(options.output, parameters):
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


def _info(options: argparse.Namespace) -> None:
    from sim.info import describe

    print(describe(options.run, as_point=options.point))


def _warm(options: argparse.Namespace) -> None:
    from sim.parameters import SYSTEMS

    if options.study is None:
        points = [model() for model in SYSTEMS.values()]
    else:
        from sim.study import load_study

        study = load_study(options.study, None)
        points = [point.parameters for point in study.points.values()]

    from sim.warm import warm

    warm(points)


def _bench(_: argparse.Namespace) -> None:
    from sim.bench import main as bench

    bench()


def _dataset(options: argparse.Namespace) -> None:
    from sim.dataset import build

    print(build(options.study, options.results))


def _publish(options: argparse.Namespace) -> None:
    from sim.publish import PUBLISHED, publish

    print(publish(options.study, options.results, options.to or PUBLISHED))


def _boundaries(options: argparse.Namespace) -> None:
    from sim.regime_boundaries import build

    print(build(options.study, options.results))


def _figure(options: argparse.Namespace) -> None:
    from sim.figures import draw

    for path in draw(options.name, options.dataset, options.output):
        print(path)


def _claims(options: argparse.Namespace) -> None:
    from sim.claims.judge import build

    print(build(options.study, options.results))


def _report(options: argparse.Namespace) -> None:
    from sim.report import build

    print(build(options.study, options.results))
