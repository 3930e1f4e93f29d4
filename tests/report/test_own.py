"""The report of a study of one's own: its state and its plots first, claims folded if at all."""

import re
from pathlib import Path

import numpy as np
import pytest

from sim.claims.verdict_files import write
from sim.dataset.build import build as build_dataset
from sim.figures.render import draw_figures
from sim.parameters import ChuteParameters, amounts
from sim.report.page import build
from sim.report.publish import publish
from sim.report.runs import state_of
from sim.study.load import load_study
from sim.surrogates import inquiries
from tests.made.report import write_claims
from tests.made.runs import write_run
from tests.report.test_page import Page

STUDY = """\
study: own
title: How friction slows a flow
series:
  - name: flows
    system: chute
    grid: {friction: [0.3, 0.4], depth: [1, 2]}
    figures: [FIGURES]
plots:
  - {name: velocity, x: friction, curves: depth}
  - {name: map, kind: map, x: friction, y: depth, title: <Where> it flows}
"""


#: Questions that too few steady points leave without an answer.
QUESTIONS = """\
surrogate:
  - {name: speed, series: flows, observable: velocity}
sensitivity:
  - {name: matters, surrogate: speed}
"""


def made(
    folder: Path, figures: str = "", judged: bool = True, questions: str = ""
) -> tuple[Path, Path]:
    """Make a study of one's own with a run that failed and one that slows, up to its claims."""
    study_path = folder / "own.yaml"
    text = STUDY.replace("[1, 2]", "[1, 2, 3]") if questions else STUDY
    study_path.write_text(text.replace("FIGURES", figures) + questions)
    study, results = load_study(study_path, folder), folder
    for number, point in enumerate(study.points.values()):
        slows = {"acceleration": ("replicate", [-2.0])} if number == 1 else {}
        write_run(
            results / "own" / "runs",
            point.parameters,
            regime="undetermined" if slows else "steady",
            failed=(0,) * (number == 0),
            arrays=slows,
        )
    dataset = build_dataset(study_path, results)
    inquiries.build(study_path, results)
    draw_figures(
        list(study.figures), dataset, dataset.parent / "figures", code="x", study_path=study_path
    )
    if not judged:
        write([], "own", dataset.parent)
    else:
        points = [*study.points, "depth5-friction0.4", "frequency50-amplitude1-angle30"]
        write_claims(dataset.parent / "claims.json", points)
    return study_path, results


@pytest.fixture(scope="module")
def study(tmp_path_factory) -> tuple[Path, Path]:
    return made(tmp_path_factory.mktemp("own"))


@pytest.fixture(scope="module")
def page(study) -> Page:
    return Page(build(*study).read_text(encoding="utf-8"))


def sections(page: Page) -> list[str]:
    return [one.get("id", "") for one in page.all("section")]


def test_the_state_and_the_plots_come_first(page):
    assert page.open == []
    text = " ".join(page.text.split())
    assert "3 of 4 points completed; 1 undetermined; 1 failed" in text
    assert "Raise replicates, or raise average; what has been run is kept. 1 of them drifts" in text
    assert sections(page)[:4] == ["summary", "plots", "facts", "runs"]
    assert {one["id"] for one in page.all("figure")} == {"figure-velocity", "figure-map"}
    assert "<Where> it flows" in page.text and not page.all("where")


def test_a_question_without_an_answer_is_one_line_and_has_no_picture(tmp_path):
    study_path, results = made(tmp_path, questions=QUESTIONS)
    page = Page(build(study_path, results).read_text(encoding="utf-8"))
    assert page.text.count("no mean, as 4 of 6 points of series flows count") == 1
    pictures = [one["id"] for one in page.all("figure")]
    assert pictures == ["figure-velocity", "figure-map"]
    links = {one["href"] for one in page.all("a") if one.get("href", "").startswith("#figure-")}
    assert links == {f"#{name}" for name in pictures}


def test_a_surrogate_with_a_large_error_is_named_first(tmp_path):
    study_path = tmp_path / "own.yaml"
    study_path.write_text(
        "study: own\nseries: [{name: flows, system: chute, base: {replicates: 2},\n"
        "  grid: {friction: [0.3, 0.35, 0.4, 0.45, 0.5, 0.55, 0.6, 0.65]}}]\n"
        "surrogate: [{name: speed, series: flows, observable: velocity}]\n"
    )
    study = load_study(study_path, tmp_path)
    for number, point in enumerate(study.points.values()):
        velocity = (0.1 if number % 2 else 10.0) * np.array([0.99, 1.01])
        write_run(tmp_path / "own" / "runs", point.parameters, velocity, regime="steady")
    dataset = build_dataset(study_path, tmp_path)
    inquiries.build(study_path, tmp_path)
    figures = dataset.parent / "figures"
    draw_figures(list(study.entries), dataset, figures, code="x", study_path=study_path)
    write([], "own", dataset.parent)
    text = " ".join(Page(build(study_path, tmp_path).read_text(encoding="utf-8")).text.split())
    named = re.search(r"Surrogate speed: Caveat: its error of \d+ % is too large", text)
    assert named and named.start() < text.index("Mean of 8 of 8 points")


def test_claims_are_not_shown_where_no_figure_of_the_papers_is(page):
    text = " ".join(page.text.split())
    assert "claims" not in sections(page) and "tested claims" not in text
    assert "1 of 1 engine check holds" in text
    targets = {one["href"] for one in page.all("a") if one.get("href", "").startswith("#")}
    ids = {attrs["id"] for _, attrs in page.elements if "id" in attrs}
    assert {target[1:] for target in targets} <= ids


def test_the_command_for_a_plot_names_the_study(page, study):
    assert f"a plot of this study with --study {study[0]}." in " ".join(page.text.split())


def test_what_ended_runs_and_what_a_steady_mean_may_lack_is_explained(page):
    text = " ".join(page.text.split())
    assert "A steady flow may be short" in text and "Limit: the longest run allowed" in text


def test_plots_and_points_are_linked(page, study):
    points = load_study(*study).points
    shown = [one for one in page.all("tr") if "data-plot" in one]
    assert [one["data-plot"] for one in shown] == ["velocity|map"] * len(points)
    filters = [one["data-filter"] for one in page.all("a") if "data-filter" in one]
    assert {"plot=velocity", "plot=map", "regime=failed"} <= set(filters)
    links = [one["href"] for one in page.all("a") if one.get("href") == "#figure-velocity"]
    assert len(links) == len(points)


def test_the_table_of_points_has_a_column_of_each_parameter_that_varies(study):
    html = build(*study).read_text(encoding="utf-8")
    table = html[html.index('<table id="runs-table"') :]
    table = table[: table.index("</table>")]
    heads = re.findall(r"<button[^>]*>([^<]*)</button>", table)
    assert heads[:5] == ["No.", "Point", "n", "μ", "Velocity (m/s)"]
    rows = re.findall(r'<tr id="run-.*?</tr>', table, re.DOTALL)
    shown = [re.findall(r'<td class="number">([^<]*)</td>', row)[:2] for row in rows]
    points = load_study(*study).points.values()
    wanted = [(point.parameters.depth, point.parameters.friction) for point in points]
    assert shown == [[f"{depth:g}", f"{friction:g}"] for depth, friction in wanted]


def test_claims_follow_folded_where_figures_of_the_papers_are_fed(tmp_path):
    found = Page(build(*made(tmp_path, "walton_2")).read_text(encoding="utf-8"))
    assert sections(found)[:6] == ["summary", "plots", "facts", "runs", "figures", "claims"]
    assert "folded" in [one.get("class") for one in found.all("details")]


def test_a_study_of_ones_own_is_published_with_its_plots(tmp_path):
    target = tmp_path / "published"
    target.mkdir()
    folder = publish(*made(tmp_path, judged=False), target)
    files = {path.name for path in (folder / "figures").iterdir()}
    ends = (".svg", ".csv", ".caption.txt")
    assert files == {f"{name}{end}" for name in ("velocity", "map") for end in ends}


def test_what_is_unsound_is_told_with_what_to_do():
    usual = {"regime": "steady", "missing_energy": 1e-4, "system": "chute"}
    nothing = usual | {"missing_energy": float("nan"), "regime": "failed"}
    leaky = usual | {"missing_energy": 380.0, "system": "belt"}
    found = state_of([usual, nothing, usual | {"missing_energy": 0.02}, leaky])
    assert (found["points"], found["completed"], found["unsound"]) == (4, 3, 2)
    assert found["worst"] is leaky and found["advice"] == "steps_per_cycle"
    assert state_of([usual])["worst"] is None


@pytest.mark.parametrize(
    "protocol, stopped, longer",
    [
        ("published", "length", "average"),
        ("converged", "target, limit", "limit"),
        ("converged", "target, accelerating", "target"),
    ],
)
def test_advice_on_undetermined_points_keeps_what_has_been_run(protocol, stopped, longer):
    usual = {"missing_energy": 1e-4, "system": "chute", "protocol": protocol, "stopped": stopped}
    open_one = usual | {"regime": "undetermined", "quality": "short"}
    found = state_of([open_one, open_one | {"regime": "mixed"}, usual | {"regime": "steady"}])
    assert (found["undetermined"], found["longer"], found["drifting"]) == (2, [longer], 0)
    assert longer in amounts(ChuteParameters(protocol=protocol))
    assert state_of([open_one | {"quality": "drifting"}])["drifting"] == 1
