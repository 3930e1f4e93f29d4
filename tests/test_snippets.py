"""What pages name is there, and what they show in fences works."""

import re
import shlex
import shutil
import subprocess
import sys
from importlib.util import find_spec
from itertools import dropwhile
from pathlib import Path
from typing import NamedTuple

import nbformat
import numpy as np
import pytest
import yaml

from sim.base.command_line import parse
from sim.base.statistics import student_half_width
from sim.claims.evidence import readings_of
from sim.parameters import parse_point
from sim.study.load import load_study, parse_study
from sim.study.papers import papers
from tests.made.figures import make_built_study
from tests.made.processes import ROOT

PAGES = sorted(
    path.relative_to(ROOT).as_posix()
    for path in (
        *(ROOT / "docs").rglob("*.md"),
        *(ROOT / name for name in ("README.md", "CONTRIBUTING.md", "config/README.md")),
    )
)

#: A path below sim/ or tests/, or a test file named alone, after another of its folder.
NAMED = re.compile(r"(?<![\w/.-])(?:\.\./)?((?:sim|tests)/[\w./*-]*|test_\w+\.py)")


@pytest.mark.parametrize("page", PAGES)
def test_files_that_a_page_names_are_there(page):
    missing = []
    for line in (ROOT / page).read_text(encoding="utf-8").splitlines():
        folder = ROOT / "tests"
        for path in NAMED.findall(line):
            base = ROOT if "/" in path else folder
            found = list(base.glob(path.rstrip("./")))
            if not found:
                missing.append(path)
            elif path.endswith(".py"):
                folder = found[0].parent
    assert missing == []


@pytest.mark.parametrize("system", [paper.system for paper in papers().values()])
def test_each_open_place_of_a_paper_has_a_row_among_the_readings(system):
    """Its first cell names the parameter, the second has words of the paper."""
    text = (ROOT / "docs" / "physics.md").read_text(encoding="utf-8")
    section = text.split(f"### Readings of the {system}\n")[1].split("\n###")[0]
    rows = [line.split(" | ") for line in section.splitlines() if line.startswith("| `")]
    named = {name for row in rows for name in re.findall(r"`(\w+)`", row[0])}
    assert set(readings_of(system).open) <= named
    assert all('"' in row[1] or "Eq" in row[1] for row in rows)


FENCE = re.compile(r"^```(\w*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)

#: Programs that are not ours; what they are told is not looked at.
OTHERS = {".", "apptainer", "cp", "echo", "export", "git", "pip", "pytest", "sed"}

#: What fragments of studies are put into: points that vary whatever they name.
FRAME = {
    "study": "fragment",
    "series": [
        {
            "name": "friction",
            "system": "chute",
            "grid": {"friction": [0.3, 0.4], "angle": [16, 17], "depth": [1.5, 2]},
        },
    ],
}


class Snippet(NamedTuple):
    kind: str
    text: str


def snippets(page: str) -> list[Snippet]:
    """Return what stands in the fences of a page, in order."""
    return [Snippet(*found) for found in FENCE.findall((ROOT / page).read_text(encoding="utf-8"))]


def of_kind(page: str, kind: str) -> list[str]:
    return [one.text for one in snippets(page) if one.kind == kind]


@pytest.mark.parametrize("page", PAGES)
def test_fences_say_what_they_hold(page):
    kinds = {one.kind for one in snippets(page)} - {""}
    assert kinds <= {"python", "sh", "text", "yaml"}
    # Pictures in letters alone go without.
    assert all(one.kind or "│" in one.text for one in snippets(page))


@pytest.mark.parametrize("page", PAGES)
def test_commands_are_understood(page):
    targets = set(re.findall(r"^([a-z]+):", (ROOT / "Makefile").read_text(), re.MULTILINE))
    targets |= {"paper-walton", "paper-gallas"}
    for text in of_kind(page, "sh"):
        for words in commands(text):
            if words[:3] == ["python", "-m", "sim"] or words[0] == "talus":
                understood(words[1 if words[0] == "talus" else 3 :])
            elif words[:2] == ["python", "-m"]:
                assert find_spec(words[2]), words
            elif words[0] == "make":
                assert {word for word in words[1:] if "=" not in word} <= targets, words
            elif words[0] == "snakemake":
                named = [words[words.index(option) + 1] for option in words if option in FILES]
                missing = [name for name in named if not (ROOT / name).exists()]
                assert set(missing) <= {"my-study.yaml"}
            else:
                assert words[0] in OTHERS, words


#: Options of Snakemake that name a file or folder of the repository.
FILES = ("--configfile", "--profile")


def commands(text: str) -> list[list[str]]:
    """Return the simple commands of a piece of shell, as words, without redirections."""
    found: list[list[str]] = []
    for line in text.replace("\\\n", " ").splitlines():
        words = shlex.shlex(line, posix=True, punctuation_chars="|&;<>")
        words.whitespace_split = True
        current: list[str] = []
        for word in words:
            if set(word) <= set("|&;"):
                found.append(current)
                current = []
            else:
                current.append(word)
        found.append(current)
    # Values of variables stand before a command.
    plain = (list(dropwhile(re.compile(r"\w+=.*").fullmatch, words)) for words in found)
    return [cut(words) for words in plain if words]


def cut(words: list[str]) -> list[str]:
    """Return a command without what it is redirected to."""
    places = [place for place, word in enumerate(words) if set(word) <= set("<>")]
    return words[: places[0]] if places else words


def understood(words: list[str]) -> None:
    """Fail where the command line does not take a command."""
    try:
        parse(words)
    except SystemExit as ended:
        assert not ended.code, words


@pytest.mark.parametrize("page", PAGES)
def test_studies_and_points_are_valid(page, tmp_path):
    write_tables(page, tmp_path)
    for text in of_kind(page, "yaml"):
        given = yaml.safe_load(text)
        if "plugins" in given or given.keys() & {"author", "figures", "claims"}:
            # tests/test_extending.py runs those, tests/workflow/test_plugins.py files of a paper.
            continue
        if "system" in given:
            assert parse_point(given, page).system == given["system"]
        elif "study" in given:
            (tmp_path / "study.yaml").write_text(text)
            assert load_study(tmp_path / "study.yaml", tmp_path).points
        else:
            key = {"defaults"} if given.keys() <= {"chute", "belt"} else set(given)
            fragment = {"defaults": given} if key == {"defaults"} else given
            assert parse_study(FRAME | fragment, tmp_path / "study.yaml", tmp_path)


def write_tables(page: str, folder: Path) -> None:
    """Write the CSV files that the studies of a page name, with the table that it shows."""
    named = re.findall(r"(?:file|data): ([\w-]+\.csv)", "\n".join(of_kind(page, "yaml")))
    tables = [text for text in of_kind(page, "text") if re.match(r".+, .+\n\d", text)]
    for name, table in zip(dict.fromkeys(named), tables, strict=False):
        (folder / name).write_text(table)


@pytest.mark.parametrize("page", PAGES)
def test_python_is_python(page):
    for text in of_kind(page, "python"):
        compile(text, page, "exec")


def run(pieces: list[Snippet], folder: Path) -> dict:
    """Run shell and Python of a page in turn in a folder; return the names of Python."""
    talus = f'set -e; talus() {{ "{sys.executable}" -m sim "$@"; }}\n'
    names: dict = {"__name__": "snippets"}
    for kind, text in pieces:
        if kind == "sh":
            subprocess.run(["bash", "-c", talus + text], check=True, cwd=folder)
        elif kind == "python":
            exec(compile(text, "snippet", "exec"), names)
    return names


@pytest.fixture
def folder(tmp_path, monkeypatch) -> Path:
    """Work in an empty folder, where commands find the package, too."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PYTHONPATH", str(ROOT))
    return tmp_path


@pytest.fixture
def results(folder, tmp_path_factory) -> Path:
    """Results of made-up studies, under the names that pages give theirs."""
    _, made = make_built_study(tmp_path_factory.mktemp("made"))
    for name in ("made", "my-study", "roughness"):
        (folder / "results" / name).mkdir(parents=True)
        shutil.copy(made / "made" / "dataset.nc", folder / "results" / name)
    return folder


def test_what_the_page_on_python_shows_runs(monkeypatch):
    monkeypatch.chdir(ROOT)
    names = run(snippets("docs/api.md"), ROOT)
    assert names["velocity"].units == "m s-1"


def test_what_the_page_on_particles_shows_runs(folder):
    names = run(snippets("docs/particles.md"), folder)
    ran, way = names["run"], names["way"]
    gone = float(way.mean("particle").sum("trajectory_time"))
    # The flow as its velocity tells it, from the first frame to the last.
    seen = ran.time > ran.trajectory_time[0]
    span = ran.trajectory_time[-1] - ran.trajectory_time[0]
    moved = ran.mean_velocity[0].where(seen, drop=True).mean() * span
    assert gone == pytest.approx(float(moved), rel=1e-3)
    assert {"flow.xyz", "flow.dump", "flow.ncdf"} < {path.name for path in folder.iterdir()}
    assert len(list(folder.glob("pictures/flow/0*.vtu"))) == ran.sizes["trajectory_time"] == 100


def test_what_the_pages_on_growth_and_data_show_runs(results):
    """The run that grows on one page is looked at on the other."""
    _, grow, _ = of_kind("docs/continue.md", "sh")
    run([Snippet("sh", grow)], results)
    (sweeps,) = of_kind("docs/continue.md", "yaml")
    study = parse_study({"study": "s"} | yaml.safe_load(sweeps), "s", None)
    starts = [bool(point.parameters.start_from) for point in study.points.values()]
    assert starts == 2 * [False, True, True] and list(study.plots) == ["hysteresis"]
    onward = {"frequency": 35, "transient": 1, "average": 2, "start_from": "belt.nc"}
    point = {"system": "belt", "beads": 20, "width": 6} | onward
    (results / "other.yaml").write_text(yaml.safe_dump(point))
    run([Snippet("sh", "talus run other.yaml -o other.nc")], results)
    names = run(snippets("docs/data.md"), results)
    assert names["run"].average == 4
    assert names["velocities"].shape[1] == len(names["heights"])
    assert set(names["belts"].system.values) == {"belt"}
    own = [each[np.isfinite(each)] for each in names["each"].values]
    wanted = [float(student_half_width(each)) for each in own]
    np.testing.assert_allclose(names["half_width"].values, wanted)
    assert {len(each) for each in own} > {0, 2}


@pytest.mark.parametrize("page", ["README.md", "docs/tutorial.md"])
def test_python_of_a_page_runs_on_the_results_of_a_study(page, results):
    run([one for one in snippets(page) if one.kind == "python"], results)


@pytest.mark.long
def test_the_tutorial_runs_from_its_first_command_to_its_figure(folder):
    """All of it but the installation, in the order of the page."""
    study = ""
    for kind, text in snippets("docs/tutorial.md"):
        if kind == "yaml" and "study:" in text:
            study = text
        elif kind == "yaml":
            study = re.sub(r"^  belt: .*\n", text, study, flags=re.MULTILINE)
        elif "pip install" not in text:
            run([Snippet(kind, text)], folder)
        (folder / "my-study.yaml").write_text(study)
    figure = folder / "results" / "my-study" / "figures" / "transport.csv"
    assert len(figure.read_text().splitlines()) == 1 + 8


@pytest.mark.long
def test_the_notebook_runs(monkeypatch):
    monkeypatch.chdir(ROOT)
    monkeypatch.setattr("matplotlib.pyplot.show", lambda: None)
    notebook = nbformat.read(ROOT / "docs" / "first-flow.ipynb", as_version=4)
    nbformat.validate(notebook)
    cells = [cell.source for cell in notebook.cells if cell.cell_type == "code"]
    names = run([Snippet("python", cell) for cell in cells], ROOT)
    assert len(names["velocities"]) == 3 and all(map(np.isfinite, names["velocities"]))
