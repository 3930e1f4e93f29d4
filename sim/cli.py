"""The command line: ``python -m sim COMMAND``."""

import argparse
import os
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from sim import __version__, actions
from sim.actions import SYSTEM_ERROR
from sim.base.errors import InputError

INPUT_ERROR = 2
INTERRUPTED = 130
BROKEN_PIPE = 141


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


def _add(commands: _Commands, name: str, text: str) -> argparse.ArgumentParser:
    """Add the command that the function of `sim.actions` of that name carries out."""
    parser = commands.add_parser(name, help=text, description=f"{text[0].upper()}{text[1:]}.")
    parser.set_defaults(command=getattr(actions, name))
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
    points = _add(commands, "points", "list the points of a study and what they cost")
    _add_study(points)
    points.add_argument("--format", choices=("table", "json"), default="table")
    status = _add(commands, "status", "show how far a study is")
    _add_study(status, nargs="?", help="(default: config/quick.yaml)")
    status.add_argument("--format", choices=("text", "json"), default="text")
    status.add_argument(
        "--watch", type=float, metavar="SECONDS", help="show it again and again until it is over"
    )
    refine = _add(commands, "refine", "work out the points of a round of refinement")
    _add_study(refine)
    refine.add_argument(
        "round", type=int, metavar="ROUND", help="1 for the first after the study's"
    )
    schema = _add(commands, "schema", "print the JSON schema of studies and points")
    schema.add_argument(
        "--write",
        nargs="?",
        type=Path,
        const=Path("config"),
        metavar="FOLDER",
        help="write schema.json and the reference in README.md of FOLDER (default: config)",
    )


def _add_run_commands(commands: _Commands) -> None:
    run = _add(commands, "run", "run one point")
    run.add_argument("point", metavar="POINT.yaml", help="- reads standard input")
    run.add_argument("-o", "--output", type=Path, required=True, metavar="RUN.nc")
    run.add_argument("-q", "--quiet", action="store_true", help="no progress, only warnings")
    run.add_argument(
        "--record-failure",
        action="store_true",
        help="exit with 0 after a run that failed, its file says why",
    )
    info = _add(commands, "info", "describe a run file")
    info.add_argument("run", type=Path, metavar="RUN.nc")
    info.add_argument(
        "--point", action="store_true", help="print its parameters as a point file instead"
    )
    warm = _add(commands, "warm", "compile the engine, so that runs start at once")
    warm.add_argument(
        "study",
        type=Path,
        nargs="?",
        metavar="STUDY.yaml",
        help="compile what this study needs (default: both systems with their default readings)",
    )
    _add(commands, "bench", "measure speed, start-up and memory")


def _add_result_commands(commands: _Commands) -> None:
    _add_study(_add(commands, "dataset", "combine the runs of a study in one dataset"))
    _add_study(_add(commands, "boundaries", "write the boundaries found as CSV"))
    _add_study(_add(commands, "claims", "judge the claims of both papers on a study"))
    figure = _add(commands, "figure", "draw one figure from a dataset")
    figure.add_argument("name", metavar="NAME", help="such as walton_2")
    figure.add_argument("dataset", type=Path, metavar="DATASET.nc")
    figure.add_argument("-o", "--output", type=Path, required=True, metavar="FOLDER")
    _add_study(_add(commands, "report", "write the report of a study"))
    publish = _add(commands, "publish", "copy what readers need of a study")
    _add_study(publish)
    publish.add_argument(
        "--to",
        type=Path,
        default=None,
        metavar="FOLDER",
        help="folder of all published studies (default: results/published)",
    )
