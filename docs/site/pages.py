"""Pages of the site that are generated from the code: commands, and variables of files."""

import argparse
from collections.abc import Iterable, Mapping, Sequence
from functools import partial

from sim.__main__ import COMMANDS, parser
from sim.engine.observe import arrays
from sim.parameters import SYSTEMS, observables
from sim.parameters.observables import BELT_FORCES, PROFILES

#: Formatter of help with lines of 90 characters, independent of the terminal.
HELP = partial(argparse.HelpFormatter, width=90)

#: Table of the dimensions of run files.
DIMENSIONS = """\
| dimension | size |
| --- | --- |
| `replicate` | replicates of the point |
| `time` | samples of the longest replicate; shorter ones end in not-a-number |
| `height` | slices of the profiles |
| `frame` | 2: first and last state |
| `particle` | all particles, the spheres glued to a plane included |
| `axis` | directions: x, y, z of a chute or conveyor, x, z of a belt |
| `quaternion` | 4 |
| `trajectory_time` | frames of the trajectory |
| `contact`, `partner` | contacts that a frame has room for, and the two partners of each |
| `path_time` | states of the path that particles are followed on once the run is over |
| `column`, `level` | squares of the field of a belt |
| `block` | parts of the window, for profiles that change |
| `overlap_bin` | intervals of overlaps; `overlap_edges` are their edges |
"""


PATH = {"path": ("m", "position, not wrapped into the cell", ("path_time", "particle", "axis"))}

#: Variables derived from the parameters of a point, besides `limits`.
DERIVED = {
    "particles": ("1", "number of particles"),
    "time_step": ("s", "time step"),
}


def commands() -> str:
    """Return the reference of the command line."""
    talus_parser = parser("talus")
    (subcommands,) = (
        action for action in talus_parser._actions if isinstance(action, argparse._SubParsersAction)
    )
    parts = [
        "# Commands",
        "`talus COMMAND` where the package is installed, `python -m sim COMMAND` in the repository."
        " Exit codes: 0, 1 (an error of the system), 2 (input that cannot be used), 3 (a run blew"
        " up), 130 and 143 (ended by a signal).",
        _table(("command", ""), [(f"[`{n}`](#{n})", text) for n, (_, text) in COMMANDS.items()]),
    ]
    for name, subparser in subcommands.choices.items():
        subparser.formatter_class = HELP
        parts += [f"## {name}", f"```text\n{subparser.format_help().rstrip()}\n```"]
    return "\n\n".join(parts) + "\n"


def variables() -> str:
    """Return the reference of the variables of run files and datasets."""
    parts = [
        "# Variables",
        "What run files (`runs/<id>.nc`) and datasets (`dataset.nc`) hold, with SI units as UDUNITS"
        " reads them; [Data](../data.md) tells how they are laid out.",
        "## In a run file",
        DIMENSIONS.rstrip(),
        "All parameters of the point are scalars of the same names"
        " ([study files](studies.md#reference)), and there is what follows from them:",
        *_section("Of the point", "", DERIVED | _limits()),
        *_section("Scalars", "(replicate)", observables.SCALARS),
        *_section("Time series of a chute", "(replicate, time)", observables.CHUTE_SERIES),
        *_section("Time series of a belt", "(replicate, time)", observables.BELT_SERIES),
        *_section("Time series of a conveyor", "(replicate, time)", observables.CONVEYOR_SERIES),
        *_section("Where `belt_forces` is set", "(replicate, time)", BELT_FORCES),
        *_section("Profiles", "(replicate, height)", PROFILES),
        "Those with `_instantaneous` behind their names are of the last sample alone.",
        *_shaped("Particles", arrays.SNAPSHOTS),
        *_shaped("Path of the particles once the run is over", PATH),
        *_shaped("Trajectory, where `trajectory` is set", _frames()),
        *_shaped("Tables, each where the system or a parameter asks for it", arrays.TABLES),
        "## In a dataset",
        "All scalars of run files, over `(point, replicate)`; all parameters over `(point)`, as"
        " coordinates; and",
        *_section("Of points", "(point)", observables.OF_POINTS),
        *_section("Measures of all", "(point, replicate)", observables.ENERGY_MEASURES),
        *_section("Measures of a chute", "(point, replicate)", observables.CHUTE_MEASURES),
        *_section("Measures of a belt", "(point, replicate)", observables.BELT_MEASURES),
        *_section("Measures of a conveyor", "(point, replicate)", observables.CONVEYOR_MEASURES),
        *_section("Groups of the systems, besides the profiles", "", observables.ALONG),
    ]
    return "\n\n".join(parts) + "\n"


def _limits() -> dict[str, tuple[str, str]]:
    limits = [model().limits for model in SYSTEMS.values()]
    return {
        name: ("m s-2", text)
        for system_limits in limits
        for name, (_, text) in system_limits.items()
    }


def _frames() -> dict[str, tuple[str, str, tuple[str, ...]]]:
    variables = arrays.SNAPSHOTS | arrays.OF_CONTACTS
    return {
        name: (*variables[source][:2], ("trajectory_time", *variables[source][2][1:]))
        for name, source in arrays.FRAMES.items()
    }


def _section(title: str, shape: str, variables: Mapping[str, tuple[str, str]]) -> list[str]:
    heading = f"### {title}" + (f", `{shape}`" if shape else "")
    rows = [(f"`{name}`", unit, meaning) for name, (unit, meaning) in variables.items()]
    return [heading, _table(("variable", "unit", "meaning"), rows)]


def _shaped(title: str, variables: Mapping[str, tuple[str, str, tuple[str, ...]]]) -> list[str]:
    rows = [
        (f"`{name}`", f"`({', '.join(('replicate', *dimensions))})`", unit, meaning)
        for name, (unit, meaning, dimensions) in variables.items()
    ]
    return [f"### {title}", _table(("variable", "shape", "unit", "meaning"), rows)]


def _table(headings: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    lines = (headings, ["---"] * len(headings), *rows)
    cells = ([cell.replace("|", "\\|") for cell in line] for line in lines)
    return "\n".join(f"| {' | '.join(line)} |" for line in cells)
