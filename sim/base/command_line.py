"""The commands and their options: what a command line may say.

Only the parser is here. The function of a command is imported when the command is called: a run
starts without the libraries of the figures, and a figure without those of the engine.
"""

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import click
from click import Argument, Choice, Option, Parameter
from click.shell_completion import CompletionItem, get_completion_class

from sim.base.errors import InputError
from sim.base.numbers import integer, number
from sim.base.program import __version__, program

#: Exit code of a command line, study or file that cannot be used.
INPUT_ERROR = 2

#: Variable by which the script of a shell asks for the words that complete a command line.
COMPLETE = "_TALUS_COMPLETE"


class FileName(click.ParamType[Path]):
    """The path of a file or folder; what reads it says whether it can."""

    name = "path"

    def convert(self, value: Any, param: Parameter | None, ctx: click.Context | None) -> Path:
        return Path(value)

    def shell_complete(
        self, ctx: click.Context, param: Parameter, incomplete: str
    ) -> list[CompletionItem]:
        return [CompletionItem(incomplete, type="file")]


class Numeric(click.ParamType[Any]):
    """A number of a ``kind``, as `sim.base.numbers` reads it."""

    def __init__(self, kind: Callable[[str], float]):
        self.kind = kind
        self.name = kind.__name__

    def convert(self, value: Any, param: Parameter | None, ctx: click.Context | None) -> float:
        try:
            return self.kind(str(value))
        except ValueError as error:
            self.fail(f"{value!r} is {error}.", param, ctx)


FILE, WHOLE, REAL = FileName(), Numeric(integer), Numeric(number)


def _argument(name: str, metavar: str, type: Any = FILE, **more: Any) -> Argument:
    return Argument([name], type=type, metavar=metavar, **more)


def _option(name: str, metavar: str | None = None, help: str = "", **more: Any) -> Option:
    """Return an option of one or more names, parted by spaces; one without a metavar is a flag."""
    more |= {"is_flag": metavar is None and "type" not in more, "help": help}
    return Option(name.split(), metavar=metavar, show_default=bool(more.get("default")), **more)


def _file(name: str, metavar: str, help: str = "", **more: Any) -> Option:
    return _option(name, metavar, help, type=FILE, **more)


STUDY = _argument("study_path", "STUDY.yaml")
ANY_STUDY = _argument("study_path", "[STUDY.yaml]", required=False)
DATASET = _argument("dataset_path", "DATASET.nc")
CORES = _option("--cores", "N", "cores to use", type=WHOLE)
TEXT = _option("--format", type=Choice(("text", "json")), default="text")
TABLE = _option("--format", type=Choice(("table", "json")), default="table")
PROCESSES = _option("-j --processes", "N", "make N side by side", type=WHOLE, default=1)
CODE = _option("--code", "HASH", "leave out what this code has made", default="")

#: Commands for people: function, description and parameters. The function is called with the
#: values of the parameters. Its result is printed, or is the exit code if it is a number.
COMMANDS: dict[str, tuple[str, str, Sequence[Parameter]]] = {
    "init": (
        "sim.study.command:init",
        "Write a study file to start from, or a paper's files; nothing is overwritten.",
        [
            _argument("target", "[FILE.yaml or FOLDER]", default="."),
            _option("--from model", "NAME", "study to copy, such as paper_walton", default="first"),
            _option("--paper", "NAME", "a paper of your own and its study, into the folder"),
        ],
    ),
    "study": (
        "sim.study.command:study",
        "Check a study and run it with Snakemake, on all cores or those of a profile.",
        [
            STUDY,
            CORES,
            _option("--profile", "NAME", "slurm, or the folder of a profile of Snakemake"),
            _option("-n --dry-run", help="list what would be run, and run nothing"),
            _argument(
                "extra",
                "[-- ARGUMENT...]",
                click.UNPROCESSED,
                nargs=-1,
                help="for Snakemake, such as names of rules or files",
            ),
        ],
    ),
    "points": (
        "sim.report.points:show",
        "List the points of a study and what they cost, or describe a run file.",
        [
            _argument("path", "STUDY.yaml|RUN.nc"),
            TABLE,
            _option("--point as_point", help="print the point file of a run file instead"),
        ],
    ),
    "status": (
        "sim.report.status:show",
        "Show how far a study is, by default config/quick.yaml.",
        [
            ANY_STUDY,
            TEXT,
            _option("--watch", "SECONDS", "show it again and again until it is over", type=REAL),
            _option("--orphans", help="list runs of no point of the study instead"),
            _option("--remove", help="and remove them, with their states and logs"),
        ],
    ),
    "run": (
        "sim.engine.command:run",
        "Run one point.",
        [
            _argument("point", "POINT.yaml", str, help="- reads standard input"),
            _file("-o --output", "RUN.nc", required=True),
            _option("-q --quiet", help="no progress, only warnings"),
            _option("--record-failure", help="exit with 0 after a failed run; its file says why"),
        ],
    ),
    "export": (
        "sim.report.export:export",
        "Write the trajectory of a replicate, or without one its first and last state, in a format "
        "of other programs; as a movie; or the table of a study.",
        [
            _argument("path", "RUN.nc", help="or study file or folder of its results: all runs"),
            _option(
                "--to",
                type=Choice(
                    ("amber", "extxyz", "lammps-dump", "vtk", "gif", "html", "webp", "csv", "xlsx")
                ),
                help="format; default: that of the suffix of FILE; csv and xlsx of a study",
            ),
            _file(
                "-o --output",
                "FILE",
                "must not be there yet, and end as files of the format do; of a study a folder; "
                "default: named like the run or the study, in this folder",
            ),
            _option("--replicate", "N", "its number, from 0", type=WHOLE, default=0),
            _option(
                "--of",
                "OBSERVABLE",
                "in a table; may have a unit: 'velocity (mm/s)'; default: all with a value",
                multiple=True,
            ),
        ],
    ),
    "predict": (
        "sim.report.predict:predict",
        "Predict between the points of a study.",
        [
            _argument("source", "STUDY.yaml|FOLDER", help="study, or its results"),
            _option(
                "--at",
                "PARAMETER=VALUE",
                "value of a parameter, or several with commas; once for each parameter. A number "
                "that is left out is held in the middle of its range, as in pictures",
                multiple=True,
            ),
            _option("--highest", help="find the highest value over what --at leaves out"),
            _option("--lowest", help="find the lowest"),
            _option("--of", "NAME", "surrogate, or observable; default: the only surrogate"),
            _option("--extrapolate", help="outside the ranges of the points, too"),
            TABLE,
        ],
    ),
    "compare": (
        "sim.report.compare:show",
        "Compare two runs or two studies point by point. Of a study file alone: run some of its "
        "points by another engine, and say whether both agree.",
        [
            _argument("first", "A", help="run file or folder of results, or STUDY.yaml alone"),
            _argument("second", "[B]", required=False),
            _option("--of quantity", "QUANTITY", "any number of a replicate", default="velocity"),
            _option("--ignore ignored", "PARAMETER", "may differ in pairs, too", multiple=True),
            TEXT,
            _option("--engine", "NAME", "that is asked; default: the only other one", default=""),
            _option("--share", "SHARE", "of the points known to both", type=REAL, default=0.05),
            _option("--cores", "N", "runs at a time of the engine", type=WHOLE, default=1),
            _file("--results", "FOLDER", "folder of all results", default="results"),
        ],
    ),
    "decide": (
        "sim.report.decide:decide",
        "Add the replicates that open questions need; with --cores run study and rounds in turns, "
        "until nothing is to be added.",
        [STUDY, CORES],
    ),
    "figure": (
        "sim.figures.render:draw_figures",
        "Draw figures from a dataset.",
        [
            _argument("names", "NAME...", str, nargs=-1, required=True, help="such as walton_2"),
            DATASET,
            _file("-o --output out_folder", "FOLDER", required=True),
            _file("--study study_path", "STUDY.yaml", "study with plots of its own"),
            PROCESSES,
            CODE,
        ],
    ),
    "publish": (
        "sim.report.publish:publish",
        "Copy what readers need of a study.",
        [
            STUDY,
            _file("--to target", "FOLDER", "of all published studies", default="results/published"),
            _option("--crate", help="also describe it as an RO-Crate, by CITATION.cff"),
        ],
    ),
    "verify": (
        "sim.verify.command:verify",
        "Run the field's own tests, some two minutes; the exit code is 1 if one does not hold.",
        [
            _argument("names", "[ROW...]", str, nargs=-1, help="such as mfix_dem02; default: all"),
            _file("-o --output folder", "FOLDER", "write the table as a page, and a picture there"),
        ],
    ),
}

#: What the workflow and developers call, as ``talus job NAME``: function and parameters.
JOBS: dict[str, tuple[str, Sequence[Parameter]]] = {
    "warm": (
        "sim.__main__:warm",
        [ANY_STUDY, PROCESSES, _option("--clean", help="remove compiled code instead")],
    ),
    "batch": ("sim.engine.command:batch", [_argument("results", "FOLDER")]),
    "refine": (
        "sim.surrogates.inquiries:write_round",
        [STUDY, _argument("number", "ROUND", WHOLE)],
    ),
    "adopt": ("sim.dataset.adopted:adopt", [STUDY, DATASET]),
    "dataset": (
        "sim.dataset.build:build",
        [
            STUDY,
            PROCESSES,
            _option("--dask-scheduler scheduler", "ADDRESS", envvar="DASK_SCHEDULER_ADDRESS"),
            _file("--finished", "FILE.nc", "write only the points that have finished, to adopt"),
        ],
    ),
    "boundaries": ("sim.dataset.boundaries:build", [STUDY]),
    "questions": ("sim.surrogates.inquiries:build", [STUDY]),
    "claims": ("sim.claims.verdict_files:build", [STUDY]),
    "report": ("sim.report.page:build", [STUDY]),
    "preview": ("sim.report.preview:write", [STUDY]),
    "schema": (
        "sim.study.reference:show",
        [
            _file(
                "--write folder",
                "[FOLDER]",
                "write schema.json and the reference in README.md there; default: config",
                flag_value="config",
            )
        ],
    ),
}

#: Earlier names of commands, and what they stand for. They are not listed.
EARLIER_NAMES = {
    "orphans": ["status", "--orphans"],
    "info": ["points"],
    "second-opinion": ["compare"],
    "clean": ["job", "warm", "--clean"],
    **{name: ["job", name] for name in JOBS},
}


class Commands(click.Group):
    """Commands that are listed in the order of their table."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        return list(self.commands)


def parse(arguments: Sequence[str]) -> dict[str, Any]:
    """Return the options of a command line, with the command's function as ``function``.

    Raises `InputError` when there is no such command or option, and `SystemExit` when help, the
    version or a completion has been printed.
    """
    name, *words = arguments or [""]
    words = [*EARLIER_NAMES.get(name, [name] if arguments else []), *words]
    try:
        given = commands().main(words, program(), COMPLETE, standalone_mode=False)
    except click.UsageError as error:
        message = " ".join(error.format_message().split())
        path = error.ctx.command_path if error.ctx else program()
        raise InputError(f"{message} {path} -h tells more") from None
    if not isinstance(given, dict):
        raise SystemExit(given)
    return given


def commands() -> click.Group:
    """Return the parser of all commands."""
    people = [
        click.Command(name, help=text, callback=partial(dict, function=function), params=[*values])
        for name, (function, text, values) in COMMANDS.items()
    ]
    jobs = [
        click.Command(name, callback=partial(dict, function=function), params=[*values])
        for name, (function, values) in JOBS.items()
    ]
    job = Commands("job", commands=jobs, hidden=True, no_args_is_help=False)
    return Commands(
        commands=[*people, job],
        help="Parameter studies of granular flow.",
        epilog="talus job -h lists what the workflow calls.",
        no_args_is_help=False,
        context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100},
        params=[
            _option(
                "--version", help="print the version", **_printing(f"talus {__version__}".format)
            ),
            _option(
                "--print-completion",
                type=Choice(("bash", "zsh", "fish")),
                help="print the script that completes talus in this shell",
                **_printing(_completion),
            ),
        ],
    )


def _printing(text: Callable[[Any], str]) -> dict[str, Any]:
    """Return the settings of an option that prints a text made of its value, and ends."""

    def end(context: click.Context, _: Parameter, value: Any) -> None:
        if value:
            click.echo(text(value))
            context.exit()

    return {"callback": end, "expose_value": False, "is_eager": True}


def _completion(shell: str) -> str:
    complete = get_completion_class(shell)
    return complete(commands(), {}, "talus", COMPLETE).source() if complete else ""
