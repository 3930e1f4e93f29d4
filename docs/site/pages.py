"""Pages of the site that are made from the code: commands, and variables of files."""

import argparse
from collections.abc import Iterable, Mapping, Sequence
from functools import partial

from sim.__main__ import COMMANDS, parser
from sim.parameters import SYSTEMS
from sim.parameters.variables import Variable
from sim.parameters.variables import variables as of_kind

#: Characters of a line of help, whatever the terminal.
HELP = partial(argparse.HelpFormatter, width=90)

#: Dimensions of what a run file holds.
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


#: What follows from the parameters of a point, besides `limits`.
DERIVED = {
    "particles": ("1", "number of particles"),
    "time_step": ("s", "time step"),
}


def commands() -> str:
    """Return the reference of the command line."""
    found = parser("talus")
    (held,) = (a for a in found._actions if isinstance(a, argparse._SubParsersAction))
    parts = [
        "# Commands",
        "`talus COMMAND` where the package is installed, `python -m sim COMMAND` in the repository."
        " Exit codes: 0, 1 (an error of the system), 2 (input that cannot be used), 3 (a run blew"
        " up), 130 and 143 (ended by a signal).",
        _table(("command", ""), [(f"[`{n}`](#{n})", text) for n, (_, text) in COMMANDS.items()]),
    ]
    for name, one in held.choices.items():
        one.formatter_class = HELP
        parts += [f"## {name}", f"```text\n{one.format_help().rstrip()}\n```"]
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
        *_listed("Scalars", of_kind("scalar")),
        *(
            line
            for system in SYSTEMS
            for line in _listed(f"Time series of a {system}", of_kind("series", system=system))
        ),
        *_listed("Profiles", of_kind("profile")),
        *_listed("Particles", of_kind("particle")),
        *_listed("Trajectory", of_kind("trajectory")),
        *_listed("Tables", of_kind("table")),
        "## In a dataset",
        "All scalars of run files, over `(point, replicate)`; all parameters over `(point)`, as"
        " coordinates; and",
        *_listed("Of points", of_kind("point")),
        *_listed("Measures, over `(point, replicate)`", of_kind("measure")),
        *_listed("Groups of the systems, besides the profiles", of_kind("group")),
    ]
    return "\n\n".join(parts) + "\n"


def _limits() -> dict[str, tuple[str, str]]:
    limits = [model().limits for model in SYSTEMS.values()]
    return {name: ("m s-2", text) for each in limits for name, (_, text) in each.items()}


def _section(title: str, shape: str, held: Mapping[str, tuple[str, str]]) -> list[str]:
    heading = f"### {title}" + (f", `{shape}`" if shape else "")
    rows = [(f"`{name}`", unit, meaning) for name, (unit, meaning) in held.items()]
    return [heading, _table(("variable", "unit", "meaning"), rows)]


def _listed(title: str, rows: Mapping[str, Variable]) -> list[str]:
    """Return variables of the table; columns that say the same for all are in the heading."""
    shapes = {name: f"({', '.join(row.dims)})" for name, row in rows.items()}
    columns = {
        "variable": [f"`{name}`" for name in rows],
        "shape": [f"`{shape}`" for shape in shapes.values()],
        "unit": [row.unit for row in rows.values()],
        "meaning": [row.attributes["long_name"] for row in rows.values()],
        "systems": [", ".join(row.systems) for row in rows.values()],
        "where": [f"`{row.asked_by}`" if row.asked_by else "" for row in rows.values()],
    }
    same = {name for name in ("shape", "systems", "where") if len(set(columns[name])) == 1}
    shape = columns["shape"][0]
    heading = f"### {title}" + (f", {shape}" if "shape" in same and "over" not in title else "")
    columns = {name: cells for name, cells in columns.items() if name not in same}
    return [heading, _table(tuple(columns), list(zip(*columns.values(), strict=True)))]


def _table(headings: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    lines = (headings, ["---"] * len(headings), *rows)
    cells = ([cell.replace("|", "\\|") for cell in line] for line in lines)
    return "\n".join(f"| {' | '.join(line)} |" for line in cells)
