"""Pages of the site that are generated: commands, variables, what judges may use, licences."""

from collections.abc import Iterable, Mapping, Sequence
from importlib.metadata import Distribution, distribution
from pathlib import Path

import click
from pydantic import BaseModel

from sim.base.command_line import COMMANDS
from sim.base.command_line import commands as parser
from sim.claims import FOR_JUDGES
from sim.claims.claim import Claim, Number
from sim.parameters import SYSTEMS
from sim.parameters.variables import Variable, observable_variables, variables_of
from sim.study.figure_spec import KEYS_OF_ALL, FigureFile, Measure, Style, keys_of_papers
from sim.study.papers import Paper, Readings
from sim.study.plottable import kinds

#: Packages that studies need, with their versions.
LOCK = Path(__file__).parents[2] / "requirements.lock"

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


#: Variables derived from the parameters of a point, besides `limits`.
DERIVED = {
    "particles": ("1", "number of particles"),
    "time_step": ("s", "time step"),
}


def commands() -> str:
    """Return the reference of the command line."""
    talus = parser()
    job = talus.commands["job"]
    assert isinstance(job, click.Group)
    parts = [
        "# Commands",
        "`talus COMMAND`, where the package is installed and in the repository after `make setup`."
        " Exit codes: 0, 1 (an error of the system), 2 (input that cannot be used), 3 (a run blew"
        " up), 130 and 143 (ended by a signal).",
        _table(("command", ""), [(f"[`{n}`](#{n})", text) for n, (_, text, _) in COMMANDS.items()]),
    ]
    jobs = {f"job {name}": command for name, command in job.commands.items()}
    for name, command in {**talus.commands, **jobs}.items():
        if command is not job:
            context = click.Context(command, info_name=f"talus {name}", terminal_width=90)
            parts += [f"## {name}", f"```text\n{command.get_help(context).rstrip()}\n```"]
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
        *_listed("Scalars", variables_of("scalar")),
        *(
            line
            for system in SYSTEMS
            for line in _listed(f"Time series of a {system}", variables_of("series", system=system))
        ),
        *_listed("Profiles", variables_of("profile")),
        *_listed("Particles", variables_of("particle")),
        *_listed("Trajectory", variables_of("trajectory")),
        *_listed("Tables", variables_of("table")),
        "## In a dataset",
        "All scalars of run files, over `(point, replicate)`; all parameters over `(point)`, as"
        " coordinates; and",
        *_listed("Of points", variables_of("point")),
        *_listed("Measures, over `(point, replicate)`", observable_variables()),
        *_listed("Groups of the systems, besides the profiles", variables_of("group")),
    ]
    return "\n\n".join(parts) + "\n"


#: What a judge asks of evidence and of a place, in the order of their use.
_MEMBERS = {
    "Evidence": "at line boundary brackets has_runs with_reading with_default",
    "Place": "velocity velocity_change value values profile measure measure_replicates regime "
    "samples completed replicates window",
    "Check": "",
}

_JUDGES = """\
# What a judge may use

A judge is a function of evidence that returns checks ([a judge](../extending.md#a-judge),
[your paper](../new_paper.md)). All names below stand in one module and stay there:

```python
from talus.claims import ANY, Untestable, above, quotient, trend
```

`place["angle"]` is a parameter of a place; `ANY`, as the value of a numerical setting, takes runs
that differ in it.
"""


def judges() -> str:
    """Return what judges may use, whose docstrings the site fills in, and the keys of a paper."""
    headings = {
        "evidence": "Evidence",
        "place": "Places, and numbers with intervals",
        "checks": "Checks",
        "inference": "Tests without an interval",
        "verdict": "What comes of it",
    }
    parts = [_JUDGES.rstrip()]
    for module, names in FOR_JUDGES.items():
        parts.append(f"## {headings[module]}")
        parts += (_directive(module, name) for name in names if name != "ANY")
    ends = {"id": "its name"}, {"judge": "function of the folder, as `judges.steeper`"}
    of_claim = [ends[0], _meanings(Claim, "id paper system judge"), ends[1]]
    in_figures = {"name": "its name (required)", "kind": "kind of plot (`curves`)"}
    for name in ("title", "about", "lead", "named", "says"):
        in_figures[name] = f"{FigureFile.model_fields[name].description} (required)"
    figure = "paper foreign scattered answer plugin series parameters colour"
    by_kind = [
        (f"`{name}`", ", ".join(f"`{key}`" for key in keys_of_papers(kind.keys)))
        for name, kind in kinds().items()
        # The others draw answers, which no paper asks for.
        if kind.keys.every or kind.keys.systems
    ]
    parts += [
        "## Keys of paper.yaml",
        _keys(_meanings(Paper, "folder package")),
        "Under `readings`:",
        _keys(_meanings(Readings)),
        "Of each of the `controls`: `values`, by parameter, and `why`.",
        "## Keys of claims.yaml",
        "Under `claims`, a list; of each:",
        _keys({name: text for part in of_claim for name, text in part.items()}),
        "Of `number`:",
        _keys(_meanings(Number)),
        "## Keys of figures.yaml",
        "Under `words`, texts for the braces of all figures; under `figures`, a list; of each:",
        _keys(_meanings(FigureFile, figure) | in_figures),
        "Of each of the `styles`, and of the `quantities`:",
        _keys(_meanings(Style) | _meanings(Measure)),
        "Besides " + ", ".join(f"`{key}`" for key in KEYS_OF_ALL) + ", a figure has by its kind:",
        _table(("kind", "keys"), by_kind),
    ]
    return "\n\n".join(parts) + "\n"


def _directive(module: str, name: str) -> str:
    """Return the lines by which the site shows signature and docstring, of a class its members."""
    members = _MEMBERS.get(name, "").split()
    shown = f"\n    options:\n      members: [{', '.join(members)}]" if name in _MEMBERS else ""
    return f"::: sim.claims.{module}.{name}{shown}"


def _meanings(model: type[BaseModel], left_out: str = "") -> dict[str, str]:
    return {
        name: (field.description or "") + " (required)" * field.is_required()
        for name, field in model.model_fields.items()
        if name not in left_out.split()
    }


def _keys(meanings: Mapping[str, str]) -> str:
    return "\n".join(f"- `{name}`: {text}" for name, text in meanings.items())


def licences() -> str:
    """Return the licences of the packages that studies need, as their metadata states them."""
    pins = [line.split("==") for line in LOCK.read_text(encoding="utf-8").split()]
    rows = [(name, version, _licence(distribution(name))) for name, version in pins]
    return "\n\n".join(
        (
            "# Licences",
            "Talus itself has the BSD 3-clause licence (`LICENSE`). It uses the packages of"
            " `requirements.lock`, whose metadata state these licences. A report contains the"
            " explorer's library Vega (`sim/report/vega` has it, with its licences).",
            _table(("package", "version", "licence"), rows),
        )
    )


def _licence(package: Distribution) -> str:
    """Return the licence of a package: an SPDX expression, its name, or the head of its text."""
    known = package.metadata
    named = known.get("License-Expression") or known.get("License") or ""
    classifiers = known.get_all("Classifier") or []
    classes = [one.split(" :: ")[-1] for one in classifiers if one.startswith("License ::")]
    texts = [
        file.read_text().strip() for file in package.files or () if "LICEN" in file.name.upper()
    ]
    (first, *_) = [*filter(_is_name, [named, ", ".join(classes)]), *texts, "not stated"]
    return first.splitlines()[0].strip()


def _is_name(text: str) -> bool:
    """Return whether a text is the name of a licence and not the licence."""
    return 0 < len(text) < 80 and "\n" not in text


def _limits() -> dict[str, tuple[str, str]]:
    limits = [model().limits for model in SYSTEMS.values()]
    return {
        name: ("m s-2", text)
        for system_limits in limits
        for name, (_, text) in system_limits.items()
    }


def _section(title: str, shape: str, variables: Mapping[str, tuple[str, str]]) -> list[str]:
    heading = f"### {title}" + (f", `{shape}`" if shape else "")
    rows = [(f"`{name}`", unit, meaning) for name, (unit, meaning) in variables.items()]
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
