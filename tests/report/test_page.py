"""The page of a report: outlines as snapshots, and what it warns of or refuses.

``python -m tests.report.test_page`` draws the outlines anew.
"""

import re
import tempfile
from html.parser import HTMLParser
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr

from sim.base.errors import InputError
from sim.base.seals import parse_sealed_json, to_sealed_json
from sim.claims.verdict_files import write
from sim.dataset.build import build as build_dataset
from sim.figures.render import draw_figures
from sim.parameters import ChuteParameters, amounts
from sim.report.page import (
    _page_order,
    build,
    data_uri,
    figure_entry,
)
from sim.report.publish import publish
from sim.report.runs import state_of
from sim.study.figure_spec import FIGURES
from sim.study.load import load_study
from sim.surrogates import inquiries
from tests.made.figures import make_figures
from tests.made.netcdf import store
from tests.made.once import SharedFolder
from tests.made.report import make_page, register_animation, write_claims
from tests.made.runs import make_study, write_run


class Page(HTMLParser):
    """The elements of a page and its visible text; tags must be balanced."""

    VOID = frozenset({"meta", "img", "br", "link", "input", "hr"})
    BLOCKS = re.compile("section|h[1-3]|p|summary|figure|caption|tr|d[dt]|li|form|pre")

    def __init__(self, text: str):
        super().__init__()
        self.elements: list[tuple[str, dict[str, str]]] = []
        self.open: list[str] = []
        self.lines, self.text = [""], ""
        self.feed(text)
        assert self.open == []
        self.text = " ".join(self.text.split())

    def handle_starttag(self, tag, attrs):
        self.elements.append((tag, dict(attrs)))
        if tag not in self.VOID:
            self.open.append(tag)
        if self.BLOCKS.fullmatch(tag):
            name = dict(attrs).get("id", "")
            self.lines.append(f"[{tag} {name}] " if name else f"[{tag}] ")

    def handle_endtag(self, tag):
        assert self.open.pop() == tag
        if self.BLOCKS.fullmatch(tag):
            self.lines.append("")

    def handle_data(self, data):
        if not {"script", "style"} & set(self.open):
            self.lines[-1] += f" {data}"
            self.text += data

    def all(self, tag: str) -> list[dict[str, str]]:
        return [attrs for name, attrs in self.elements if name == tag]

    def sections(self) -> list[str]:
        return [one.get("id", "") for one in self.all("section")]

    def outline(self) -> str:
        """Return a line for each heading and paragraph, and for the first rows of each table."""
        lines, rows = [], 0
        for line in (" ".join(line.split()) for line in self.lines):
            is_row = line.startswith("[tr")
            rows = rows + is_row if not line.startswith("[caption") else 0
            is_empty = not re.search(r"\w", re.sub(r"^\[.*?\]", "", line))
            if line.startswith("[section") or not (is_empty or (is_row and rows > 4)):
                # Paths, dates and versions differ from one time to another.
                for own in (r"(?<![\w.])/\w\S+", r"\d{4}-\d\d-\d\d", r"\d+\.\d+\.\d+(\.\w+)*"):
                    line = re.sub(own, "*", line)
                lines.append(line if len(line) < 300 else f"{line[:300]} ...")
        return "\n".join(lines) + "\n"


def read(made: tuple[Path, Path]) -> Page:
    return Page(build(*made).read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def made(tmp_path_factory) -> tuple[Path, Path]:
    """A study with its figures and verdicts."""
    study_path, results = make_figures(tmp_path_factory.mktemp("made"))
    points = list(load_study(study_path, results).points)
    write_claims(results / "made" / "claims.json", points)
    return study_path, results


@pytest.fixture(scope="module")
def page(made) -> Page:
    return read(made)


def test_a_study_that_is_not_judged_or_tests_no_claim_says_so(made, page):
    path = made[1] / "made" / "claims.json"
    content = path.read_text(encoding="utf-8")
    path.unlink()
    assert "have not been judged on this study" in read(made).text
    document = parse_sealed_json(content)
    kept = [one for one in document["claims"] if one["id"] in ("W1", "G31")]
    path.write_text(to_sealed_json(document | {"claims": kept}), encoding="utf-8")
    found = read(made)
    path.write_text(content, encoding="utf-8")
    assert "test none of the papers' claims. 1 of 1 check of the model holds" in found.text
    assert "flows reproduced" not in found.text and "flows reproduced" in page.text
    sections, usual = found.sections(), page.sections()
    assert sections.index("figures") < sections.index("claims")
    assert usual.index("claims") < usual.index("figures")


def test_points_with_a_caveat_are_marked_and_the_ledger_is_not_said_to_be_good(tmp_path, page):
    study_path, results = make_figures(tmp_path)
    points = load_study(study_path, results).points.values()
    belts = [point.id for point in points if point.parameters.system == "belt"]
    for key, share in zip(belts[:2], (0.05, 340.0), strict=True):
        path = results / "made" / "runs" / f"{key}.nc"
        with xr.open_dataset(path) as opened:
            run = opened.load()
        run["energy_residual"][0] = share
        store(run, path)
    build_dataset(study_path, results)
    doubtful = read((study_path, results))
    marks = [one for one in doubtful.all("a") if "caveat-1" in one.get("aria-describedby", "")]
    assert len(marks) == 2 and doubtful.text.count("⚠ caveat") == 2
    assert [one.get("data-caveat") for one in doubtful.all("tr")].count("with") == 2
    assert re.search(r"Caveat for 2 of \d+ points: energy does not add up", doubtful.text)
    assert "but for 2 points with a caveat" in doubtful.text and "⚠" not in page.text

    def tone(one: Page) -> str:
        return next(tag["class"] for tag in one.all("dd") if "class" in tag)

    assert (tone(doubtful), tone(page)) == ("open", "good")


def test_the_command_that_repeats_a_study_is_quoted_for_the_shell(made, tmp_path):
    study_path, results = made
    odd = tmp_path / "$(touch PWN) {a} b.yaml"
    odd.write_text(study_path.read_text())
    assert f"talus study '{odd}' --cores" in read((odd, results)).text


def test_a_missing_figure_is_named_and_the_old_report_stays(tmp_path):
    study_path, results = make_study(tmp_path)
    with pytest.raises(InputError, match=r"dataset\.nc"):
        build(study_path, results)
    build_dataset(study_path, results)
    (results / "made" / "report.html").write_text("old")
    with pytest.raises(InputError, match=r"walton_2\.png"):
        build(study_path, results)
    assert (results / "made" / "report.html").read_text() == "old"
    with register_animation(tmp_path) as name:
        (tmp_path / f"{name}.gif").unlink()
        with pytest.raises(InputError, match=rf"{name}\.gif: no such animation"):
            figure_entry(FIGURES[name], tmp_path, data_uri)


OWN = """\
study: own
title: <b>1 < 2</b>
series:
  - name: flows
    system: chute
    grid: {friction: [0.3, 0.4], depth: [1, 2]}
    figures: [FIGURES]
plots:
  - {name: velocity, x: friction, curves: depth, series: [flows]}
  - {name: map, kind: map, x: friction, y: depth, title: <Where> it flows, series: [flows]}
"""

#: Questions, of which too few steady points leave the first two without an answer, and scattered
#: points the last one with a large error.
ASKING = (
    OWN.replace("[1, 2]", "[1, 2, 3]")
    .replace("FIGURES", "walton_2")
    .replace(
        "plots:",
        """\
  - name: wild
    system: chute
    base: {replicates: 2, depth: 5}
    grid: {friction: [0.3, 0.35, 0.4, 0.45, 0.5, 0.55, 0.6, 0.65]}
plots:""",
    )
    + """\
surrogate:
  - {name: speed, series: flows, observable: velocity}
  - {name: odd, series: wild, observable: velocity}
sensitivity:
  - {name: matters, surrogate: speed}
"""
)


def make_own(folder: Path, text: str) -> tuple[Path, Path]:
    """Make a study of one's own with a run that failed and one that slows, up to its claims."""
    study_path = folder / "own.yaml"
    study_path.write_text(text.replace("FIGURES", ""))
    study = load_study(study_path, folder)
    for number, point in enumerate(study.points.values()):
        slows = {"acceleration": ("replicate", [-2.0])} if number == 1 else {}
        odd = (0.1 if number % 2 else 10.0) * np.array([0.99, 1.01])
        write_run(
            folder / "own" / "runs",
            point.parameters,
            odd if "wild" in point.series else 0.5,
            regime="undetermined" if slows else "steady",
            failed=(0,) * (number == 0),
            arrays=slows,
        )
    dataset = build_dataset(study_path, folder)
    inquiries.build(study_path, folder)
    figures = dataset.parent / "figures"
    draw_figures(list(study.entries), dataset, figures, code="x", study_path=study_path)
    points = [*study.points, "depth5-friction0.4", "frequency50-amplitude1-angle30"]
    write_claims(dataset.parent / "claims.json", points)
    return study_path, folder


def make_asking(folder: Path) -> tuple[Path, Path]:
    """Make the study with questions and its report; return its file and the report."""
    study_path, results = make_own(folder, ASKING)
    return study_path, build(study_path, results)


@pytest.mark.parametrize(("name", "make"), [("outline", make_page), ("own", make_asking)])
def test_the_outline_is_as_it_was(name, make, tmp_path):
    """Of the report with all that there can be, and of one's own study, whose plots come first."""
    page = Page(make(tmp_path)[1].read_text(encoding="utf-8"))
    before = outline_file(name).read_text("utf-8").splitlines()
    assert page.outline().splitlines() == before, "python -m tests.report.test_page writes it anew"
    targets = {one["href"] for one in page.all("a") if one.get("href", "").startswith("#")}
    assert {target[1:] for target in targets} <= {
        attrs["id"] for _, attrs in page.elements if "id" in attrs
    }


def outline_file(name: str) -> Path:
    return Path(__file__).with_name(f"{name}.txt")


def test_a_study_of_ones_own_names_its_plots_and_is_published_with_them(tmp_path):
    study = make_own(tmp_path, OWN)
    own = read(study)
    # No figure of a paper is fed.
    assert own.sections()[:4] == ["summary", "plots", "facts", "runs"]
    assert "claims" not in own.sections() and "statements on flows" not in own.text
    shown = [one["data-plot"] for one in own.all("tr") if "data-plot" in one]
    assert shown == ["velocity|map"] * len(load_study(*study).points)
    filters = [one["data-filter"] for one in own.all("a") if "data-filter" in one]
    assert {"plot=velocity", "plot=map", "regime=failed"} <= set(filters)
    write([], "own", tmp_path / "own")
    folder = publish(tmp_path / "own.yaml", tmp_path, tmp_path / "published")
    files = {path.name for path in (folder / "figures").iterdir()}
    ends = (".svg", ".csv", ".caption.txt")
    assert files == {f"{name}{end}" for name in ("velocity", "map") for end in ends}


@pytest.mark.parametrize(
    ("paper", "plots", "fed", "is_own"),
    [("", 1, 1, True), ("", 0, 1, False), ("gallas", 1, 1, False), ("gallas", 1, 0, True)],
)
def test_the_report_of_a_study_that_names_its_paper_begins_as_one_of_it(paper, plots, fed, is_own):
    """Its figures then come before the study's plots."""
    figures, own = dict.fromkeys("f" * fed), dict.fromkeys("p" * plots)
    study = SimpleNamespace(paper=paper, plots=own, figures=figures | own, entries=figures | own)
    order = _page_order(study, [{"own": True}, {"own": False}], [])
    assert order["own"] is is_own and len(order["gallery"]) == (1 if is_own else 2)


@pytest.mark.parametrize(
    "protocol, stopped, longer",
    [
        ("published", "length", "average"),
        ("converged", "target, limit", "limit"),
        ("converged", "target, accelerating", "target"),
    ],
)
def test_advice_keeps_what_has_been_run(protocol, stopped, longer):
    usual = {"missing_energy": 1e-4, "system": "chute", "protocol": protocol, "stopped": stopped}
    open_one = usual | {"regime": "undetermined", "quality": "short"}
    leaky = usual | {"regime": "steady", "missing_energy": 380.0, "system": "belt"}
    nothing = usual | {"missing_energy": float("nan"), "regime": "failed"}
    found = state_of([open_one, open_one | {"regime": "mixed"}, leaky, nothing])
    assert (found["undetermined"], found["mixed"], found["drifting"]) == (1, 1, 0)
    assert found["longer"] == [longer]
    assert longer in amounts(ChuteParameters(protocol=protocol))
    assert state_of([open_one | {"quality": "drifting"}])["drifting"] == 1
    assert (found["points"], found["completed"], found["unsound"]) == (4, 3, 1)
    assert found["worst"] is leaky and found["advice"] == "steps_per_cycle"


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as place:
        SharedFolder.folder = Path(place) / "made"
        SharedFolder.folder.mkdir()
        for name, make in (("outline", make_page), ("own", make_asking)):
            (folder := Path(place) / name).mkdir()
            drawn = Page(make(folder)[1].read_text(encoding="utf-8"))
            outline_file(name).write_text(drawn.outline(), encoding="utf-8")
