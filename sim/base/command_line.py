"""The commands and their options: what a command line may say.

Only the parser is here. The function of a command is imported when the command is called: a run
starts without the libraries of the figures, and a figure without those of the engine.
"""

import argparse
import os
from collections.abc import Collection, Sequence
from pathlib import Path
from typing import Any, NoReturn

from sim.base.errors import printable
from sim.base.program import SHELLS, PrintCompletion, __version__, program

#: Exit code of a command line, study or file that cannot be used.
INPUT_ERROR = 2

#: Command -> its function and its description. The function is called with the options of the
#: command. Its result is printed, or is the exit code if it is a number.
COMMANDS = {
    "init": ("sim.study.command:init", "write a study file to start from"),
    "study": ("sim.study.command:study", "check a study and run it with Snakemake"),
    "points": ("sim.report.points:show", "list the points of a study and what they cost"),
    "status": ("sim.report.status_table:show", "show how far a study is"),
    "refine": (
        "sim.surrogates.rounds:write_round",
        "work out the points of a round, of boundaries and surrogates",
    ),
    "schema": ("sim.study.reference:show", "print the JSON schema of studies and points"),
    "run": ("sim.engine.command:run", "run one point"),
    "batch": ("sim.engine.command:batch", "run several points in one process"),
    "info": ("sim.report.info:describe", "describe a run file"),
    "page": ("sim.report.run_page:write_pages", "write a page on each of some runs"),
    "export": ("sim.report.export:export", "write the particles of a run in other formats"),
    "warm": ("sim.__main__:warm", "compile the engine, so that runs start at once"),
    "bench": ("sim.engine.bench:main", "measure speed, start-up and memory"),
    "adopt": (
        "sim.dataset.adopted:adopt",
        "take what a dataset has of a study instead of running it",
    ),
    "dataset": ("sim.dataset.build:build", "combine the runs of a study in one dataset"),
    "boundaries": ("sim.dataset.boundaries:build", "write the boundaries found as CSV"),
    "questions": (
        "sim.surrogates.inquiries:build",
        "answer the questions of a study from its dataset",
    ),
    "predict": ("sim.report.predict:predict", "predict between the points of a study"),
    "claims": ("sim.claims.verdict_files:build", "judge the claims of both papers on a study"),
    "decide": ("sim.report.decide:decide", "add the replicates that open questions need"),
    "figure": ("sim.figures.render:draw_figures", "draw figures from a dataset"),
    "report": ("sim.report.page:build", "write the report of a study"),
    "second-opinion": (
        "sim.report.second_opinion:ask",
        "run some points of a study by another engine and say whether both agree",
    ),
    "compare": ("sim.report.compare:show", "compare two runs or two studies point by point"),
    "orphans": (
        "sim.report.status_table:list_orphans",
        "list or remove runs of points no longer in a study",
    ),
    "publish": ("sim.report.publish:publish", "copy what readers need of a study"),
    "clean": ("sim.engine.identity:remove_cache", "remove compiled code; it is made again"),
}


def parse(arguments: Sequence[str]) -> dict[str, Any]:
    """Return the options of a command line, with the command's function as ``function``."""
    words, extra = list(arguments), []
    commands = parser(program())
    if words and words[0] not in COMMANDS:
        is_option, options = words[0].startswith("-"), commands._option_string_actions
        if not (is_option and any(name.startswith(words[0].split("=")[0]) for name in options)):
            reason = f"unknown {'option' if is_option else 'command'}"
            commands.refuse(words[0], reason, [*COMMANDS, *options])
    if words[:1] == ["study"] and "--" in words:
        # argparse would read the following words as its own options.
        place = words.index("--")
        words, extra = words[:place], words[place + 1 :]
    known, unknown = commands.parse_known_args(words)
    if unknown:
        command = commands.subparsers[words[0]]
        kind = "unknown option" if unknown[0].startswith("-") else "one word too many"
        command.refuse(unknown[0], kind, command._option_string_actions)
    given = vars(known)
    return given | {"extra": [*given["extra"], *extra]} if "extra" in given else given


class Parser(argparse.ArgumentParser):
    """A parser whose errors are one line.

    Attributes
    ----------
    subparsers : dict
        Parsers of the commands, by name.
    """

    subparsers: dict[str, "Parser"]

    def error(self, message: str) -> NoReturn:
        end = " " if message.endswith("?") else "; "
        self.exit(INPUT_ERROR, f"error: {message}{end}{self.prog} -h tells more\n")

    def refuse(self, word: str, reason: str, known: Collection[str]) -> NoReturn:
        """End with the error of a word, and a question with known words that are like it."""
        # Imported here, as every command would wait for the import.
        from sim.base.messages import did_you_mean

        self.error(f"{printable(word)}: {reason}; {did_you_mean(word, known)}".rstrip("; "))


def parser(prog: str) -> Parser:
    """Return the parser of all commands, for a program of this name."""
    parser = Parser(prog=prog, description="Parameter studies of granular flow.")
    parser.add_argument("--version", action="version", version=f"talus {__version__}")
    parser.add_argument(
        "--print-completion",
        action=PrintCompletion,
        choices=SHELLS,
        default=argparse.SUPPRESS,
        help="print the script that completes talus in this shell",
    )
    commands = parser.add_subparsers(title="commands", metavar="COMMAND", required=True)
    parser.subparsers = parsers = {}
    for name, (function, text) in COMMANDS.items():
        description = f"{text[0].upper()}{text[1:]}."
        parsers[name] = commands.add_parser(name, help=text, description=description)
        parsers[name].set_defaults(function=function)
    study_commands = (
        "points refine adopt dataset boundaries questions claims decide report second-opinion "
        "orphans publish"
    )
    for name in study_commands.split():
        _add_study(parsers[name])
    _add_study(parsers["status"], nargs="?", help="(default: config/quick.yaml)")
    _add_start_options(parsers["init"], parsers["study"])
    _add_study_options(parsers)
    _add_point_options(parsers)
    _add_predict_options(parsers["predict"])
    _add_dataset_options(parsers)
    _add_result_options(parsers)
    return parser


def _add_study(parser: argparse.ArgumentParser, **options: Any) -> None:
    parser.add_argument("study_path", type=Path, metavar="STUDY.yaml", **options)
    parser.add_argument(
        "--results",
        type=Path,
        default=Path("results"),
        metavar="FOLDER",
        help="folder of all results (default: results)",
    )


def _add_start_options(init: argparse.ArgumentParser, study: argparse.ArgumentParser) -> None:
    init.add_argument(
        "target",
        type=Path,
        nargs="?",
        default=Path(),
        metavar="FILE.yaml or FOLDER",
        help="file to write, or folder for it (default: this one); nothing is overwritten",
    )
    init.add_argument(
        "--from",
        dest="model",
        default="first",
        metavar="NAME",
        help="study that comes with Talus to copy, such as quick or paper_walton (default: first)",
    )
    study.usage = "%(prog)s [-h] [--cores N] [--profile NAME] [-n] STUDY.yaml [-- ARGUMENT ...]"
    study.epilog = "What follows -- goes to Snakemake, such as names of rules or files."
    study.add_argument("study_path", type=Path, metavar="STUDY.yaml")
    study.add_argument(
        "--cores",
        type=int,
        metavar="N",
        help="cores to use (default: all, or what the profile says)",
    )
    study.add_argument(
        "--profile", metavar="NAME", help="slurm, or the folder of a profile of Snakemake"
    )
    study.add_argument(
        "-n",
        "--dry-run",
        dest="extra",
        action="store_const",
        const=("--dry-run",),
        default=(),
        help="list what would be run, and run nothing",
    )


def _add_study_options(parsers: dict[str, Parser]) -> None:
    parsers["points"].add_argument("--format", choices=("table", "json"), default="table")
    parsers["status"].add_argument("--format", choices=("text", "json"), default="text")
    parsers["status"].add_argument(
        "--watch", type=float, metavar="SECONDS", help="show it again and again until it is over"
    )
    parsers["refine"].add_argument(
        "number", type=int, metavar="ROUND", help="1 for the first after the study's"
    )
    parsers["schema"].add_argument(
        "--write",
        dest="folder",
        nargs="?",
        type=Path,
        const=Path("config"),
        metavar="FOLDER",
        help="write schema.json and the reference in README.md of FOLDER (default: config)",
    )
    parsers["warm"].add_argument(
        "study_path",
        type=Path,
        nargs="?",
        metavar="STUDY.yaml",
        help="compile what this study needs (default: all systems with their default readings)",
    )
    parsers["warm"].add_argument(
        "-j", "--processes", type=int, default=1, metavar="N", help="compile N systems side by side"
    )


def _add_point_options(parsers: dict[str, Parser]) -> None:
    run, batch, info, page, export = (
        parsers[name] for name in ("run", "batch", "info", "page", "export")
    )
    run.add_argument("point", metavar="POINT.yaml", help="- reads standard input")
    run.add_argument("-o", "--output", type=Path, required=True, metavar="RUN.nc")
    run.add_argument("-q", "--quiet", action="store_true", help="no progress, only warnings")
    run.add_argument(
        "--record-failure",
        action="store_true",
        help="exit with 0 after a run that failed, its file says why",
    )
    batch.description = "Run points, a JSON list on the standard input, one after the other."
    batch.add_argument(
        "results", type=Path, metavar="FOLDER", help="results of the study: runs and logs/runs"
    )
    info.add_argument("path", type=Path, metavar="RUN.nc")
    info.add_argument(
        "--point",
        dest="as_point",
        action="store_true",
        help="print its parameters as a point file instead",
    )
    page.add_argument("paths", type=Path, nargs="+", metavar="RUN.nc")
    page.add_argument(
        "-o",
        "--output",
        dest="folder",
        type=Path,
        default=Path(),
        metavar="FOLDER",
        help="for pages named like the runs (default: this folder)",
    )
    page.add_argument("--report", default="", metavar="ADDRESS", help="report to link")
    page.add_argument(
        "-j", "--processes", type=int, default=1, metavar="N", help="make N pages side by side"
    )
    page.add_argument(
        "--code", default="", metavar="HASH", help="leave out what this code has made of the same"
    )
    export.description = (
        "Write the trajectory of a replicate, or without one its first and last state, in a format "
        "of other programs."
    )
    export.add_argument(
        "path",
        type=Path,
        metavar="RUN.nc",
        help="run file; or a study file, or the folder of its results, for all runs",
    )
    export.add_argument(
        "--to",
        choices=("amber", "extxyz", "lammps-dump", "vtk"),
        help="format (default: that of the suffix of FILE)",
    )
    export.add_argument(
        "-o",
        "--output",
        type=Path,
        metavar="FILE",
        help="must not be there yet, and end as files of the format do; of a study a folder "
        "(default: named like the run or the study, in this folder)",
    )
    export.add_argument(
        "--replicate", type=int, default=0, metavar="N", help="its number, from 0 (default: 0)"
    )


def _add_predict_options(predict: argparse.ArgumentParser) -> None:
    predict.add_argument(
        "source", type=Path, metavar="STUDY.yaml or FOLDER", help="study, or its results"
    )
    predict.add_argument(
        "--at",
        action="append",
        default=[],
        metavar="PARAMETER=VALUE",
        help="value of a parameter, or several with commas; once for each parameter",
    )
    predict.add_argument(
        "--of", metavar="NAME", help="surrogate, or observable (default: the only surrogate)"
    )
    predict.add_argument(
        "--extrapolate", action="store_true", help="outside the ranges of the points, too"
    )
    predict.add_argument("--format", choices=("table", "json"), default="table")
    predict.add_argument(
        "--results",
        type=Path,
        default=Path("results"),
        metavar="FOLDER",
        help="folder of all results (default: results)",
    )


def _add_dataset_options(parsers: dict[str, Parser]) -> None:
    dataset, figure = parsers["dataset"], parsers["figure"]
    dataset.add_argument(
        "-j", "--processes", type=int, default=1, metavar="N", help="read run files in N processes"
    )
    dataset.add_argument(
        "--dask-scheduler",
        dest="scheduler",
        default=os.environ.get("DASK_SCHEDULER_ADDRESS"),
        metavar="ADDRESS",
        help="have the workers of a dask cluster read them (default: $DASK_SCHEDULER_ADDRESS)",
    )
    dataset.add_argument(
        "--finished",
        type=Path,
        metavar="FILE.nc",
        help="write only the points that have finished or are adopted, to be adopted elsewhere",
    )
    parsers["adopt"].add_argument("dataset_path", type=Path, metavar="DATASET.nc")
    figure.add_argument("names", nargs="+", metavar="NAME", help="such as walton_2")
    figure.add_argument("dataset_path", type=Path, metavar="DATASET.nc")
    figure.add_argument(
        "-o", "--output", dest="out_folder", type=Path, required=True, metavar="FOLDER"
    )
    figure.add_argument(
        "-j", "--processes", type=int, default=1, metavar="N", help="draw N figures side by side"
    )
    figure.add_argument(
        "--study",
        dest="study_path",
        type=Path,
        metavar="STUDY.yaml",
        help="study file that defines plots of its own",
    )
    figure.add_argument(
        "--code", default="", metavar="HASH", help="leave out what this code has drawn of the same"
    )


def _add_result_options(parsers: dict[str, Parser]) -> None:
    parsers["decide"].add_argument(
        "--cores",
        type=int,
        metavar="N",
        help="run snakemake --cores N and decide, in turns, until there is nothing to add",
    )
    opinion = parsers["second-opinion"]
    opinion.add_argument(
        "--share",
        type=float,
        default=0.05,
        metavar="SHARE",
        help="of the points that both engines know (default: 0.05)",
    )
    opinion.add_argument("--cores", type=int, default=1, metavar="N", help="runs at a time")
    opinion.add_argument(
        "--engine", default="", metavar="NAME", help="that is asked (default: the only other one)"
    )
    compare = parsers["compare"]
    for name, letter in (("first", "A"), ("second", "B")):
        compare.add_argument(
            name, type=Path, metavar=letter, help="run file, or folder of a study's results"
        )
    compare.add_argument(
        "--of",
        dest="quantity",
        default="velocity",
        metavar="QUANTITY",
        help="what to compare: any number of a replicate (default: velocity)",
    )
    compare.add_argument(
        "--ignore",
        dest="ignored",
        action="append",
        default=[],
        metavar="PARAMETER",
        help="pair points that differ in it, too; may be given several times",
    )
    compare.add_argument("--format", choices=("text", "json"), default="text")
    parsers["orphans"].add_argument(
        "--remove", action="store_true", help="remove them, with their states and logs"
    )
    publish = parsers["publish"]
    publish.add_argument(
        "--to",
        dest="target",
        type=Path,
        default=argparse.SUPPRESS,
        metavar="FOLDER",
        help="folder of all published studies (default: results/published)",
    )
    publish.add_argument(
        "--crate",
        action="store_true",
        help="describe it as an RO-Crate, with the authors and the licence of CITATION.cff",
    )
