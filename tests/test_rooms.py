"""Rooms import only what the table says, in no circle; what starts fast imports nothing heavy."""

import ast
import re
import subprocess
import sys
from graphlib import TopologicalSorter
from pathlib import Path

import pytest
import yaml

from sim.base.program import PAPERS, ROOMS
from tests.made.processes import ROOT
from tests.mutations.__main__ import BUGS

PACKAGE = Path(__file__).parents[1] / "sim"
MODULES = sorted(PACKAGE.rglob("*.py"))

#: Modules of a room that others may import, where they may import no others of it. Of the engine:
#: names that run files and datasets share, how much they hold, and what tells of runs under way;
#: figures read series from run files.
#: Papers: what a plug-in may import, and the engine for experiments on Walton's model.
ONLY = {
    "dataset": {"engine": {"stored_run", "identity"}},
    "figures": {"engine": {"stored_run"}},
    "report": {"engine": {"shared_runs", "stored_run", "identity", "progress"}},
    "papers": {
        "base": {"plugins", "statistics"},
        "parameters": {"", "belt"},
        "study": {"papers"},
        "engine": {"boundary.drive", "contact", "contact.walton_braun", "systems.chute"},
        "dataset": {"belt"},
        "measures": {"belt", "layers", "plug"},
        "claims": {
            *("checks", "claim", "evidence", "experiments", "inference", "place", "verdict"),
        },
    },
}

#: Most lines of code of each room: no docstring, comment, import or blank line. Whoever adds takes
#: away elsewhere; a commit that raises a number here says what for.
WEIGHT = {
    "base": 1_644,
    "parameters": 2_036,
    "study": 3_283,
    "engine": 6_091,
    "laws": 223,
    "engines": 443,
    "measures": 566,
    "dataset": 1_471,
    "surrogates": 1_941,
    "figures": 3_423,
    "claims": 1_470,
    "papers": 2_509,
    "report": 2_547,
    "verify": 462,
}


def dotted(path: Path) -> str:
    parts = path.relative_to(PACKAGE.parent).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


KNOWN = {dotted(path) for path in MODULES}


def imported(path: Path) -> set[str]:
    """Return the modules of the package that a file imports, wherever in it."""
    found = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            assert not node.level, f"{path}: a relative import"
            names = {f"{node.module}.{alias.name}" for alias in node.names}
            found |= (names & KNOWN) or {node.module}
    return {name for name in found if name.split(".")[0] == "sim"}


WITH_DOCSTRING = (ast.Module, ast.FunctionDef, ast.ClassDef)


def lines_of_code(path: Path) -> int:
    """Count the lines of a file that are no docstring, comment, import or blank."""
    text = path.read_text(encoding="utf-8")
    lines = {k for k, line in enumerate(text.splitlines(), 1) if line.split("#")[0].strip()}
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, (ast.Import, ast.ImportFrom)):
            lines -= set(range(node.lineno, (node.end_lineno or 0) + 1))
        elif isinstance(node, WITH_DOCSTRING) and ast.get_docstring(node) is not None:
            lines -= set(range(node.body[0].lineno, (node.body[0].end_lineno or 0) + 1))
    return len(lines)


@pytest.mark.parametrize("room", [*ROOMS, PAPERS])
def test_a_room_is_no_heavier_than_its_price(room):
    weight = sum(map(lines_of_code, (PACKAGE / room).rglob("*.py")))
    remedy = "take as many away, or raise WEIGHT and say in the commit what for"
    assert weight <= WEIGHT[room], f"{room}: {weight} lines of code: {remedy}"


def test_the_package_holds_its_rooms_and_the_papers():
    entries = {path.name for path in PACKAGE.iterdir() if path.name != "__pycache__"}
    assert entries == {"__init__.py", "__main__.py", PAPERS, *ROOMS}
    assert all(any((PACKAGE / room).glob("*.py")) for room in ROOMS)


def test_the_table_of_rooms_has_no_circle_and_is_complete():
    order = list(TopologicalSorter(ROOMS).static_order())
    assert set(order) == set(ROOMS)
    for room, others in ROOMS.items():
        assert set(others) >= {far for near in others for far in ROOMS[near]}, room


@pytest.mark.parametrize("room", ROOMS)
def test_a_room_imports_only_what_it_may(room):
    for path in (PACKAGE / room).rglob("*.py"):
        for name in imported(path):
            other, _, rest = name.removeprefix("sim").lstrip(".").partition(".")
            if other in ("", room):
                continue
            assert other in ROOMS[room], f"{path}: {name}"
            allowed = ONLY.get(room, {}).get(other, {rest})
            assert rest in allowed, f"{path}: {name}"


def test_no_module_imports_itself_by_way_of_others():
    graph = {dotted(path): imported(path) & KNOWN - {dotted(path)} for path in MODULES}
    assert list(TopologicalSorter(graph).static_order())


HEAVY = {"numba", "xarray", "pandas", "matplotlib", "scipy", "dask", "snakemake"}


def loaded(code: str) -> set[str]:
    """Return the modules that a few lines of Python import."""
    lines = f"import sys\n{code}\nprint(*sys.modules)"
    command = [sys.executable, "-c", lines]
    return set(subprocess.check_output(command, cwd=PACKAGE.parent, text=True).split())


def test_help_imports_no_library_at_all():
    code = "import sim.__main__\ntry: sim.__main__.main(['-h'])\nexcept SystemExit: pass"
    assert not loaded(code) & (HEAVY | {"pydantic", "yaml", "numpy"})


def test_parameters_and_tables_of_points_import_nothing_heavy():
    code = "import sim.__main__, sim.parameters, sim.study.load, sim.report.points"
    assert not loaded(code) & HEAVY


def test_pages_name_no_paper():
    """A report takes the names of papers from them, so that it names a stranger's as well."""
    for path in (PACKAGE / "report" / "templates").iterdir():
        assert not re.search("walton|gallas", path.read_text(encoding="utf-8"), re.IGNORECASE), path


@pytest.mark.parametrize(
    "bug", yaml.safe_load(BUGS.read_text(encoding="utf-8")), ids=lambda bug: bug["new"]
)
def test_the_text_of_a_bug_occurs_once(bug):
    source = (ROOT / "sim" / bug["file"]).read_text(encoding="utf-8")
    assert source.count(bug["old"]) == 1 and bug["new"] != bug["old"]
    assert all((ROOT / "tests" / target).exists() for target in bug["tests"].split())
