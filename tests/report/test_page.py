"""The report as a browser sees it: everything inside, nothing loaded, nothing hidden."""

import base64
import re
from html.parser import HTMLParser
from pathlib import Path

import pandas as pd
import pytest
import xarray as xr

from sim.base.errors import InputError
from sim.base.seals import DamagedError, parse_sealed_json, to_sealed_json
from sim.dataset.build import build as build_dataset
from sim.dataset.results import load_results
from sim.figures.caption import parted
from sim.figures.render import draw_figures
from sim.report.claims import read_claims
from sim.report.page import (
    build,
    data_uri,
    describe_ranges,
    figure_entry,
    headline_figures,
    relative_link,
    render,
)
from sim.study.catalogue import FIGURES
from sim.study.load import load_study
from tests.made.figures import make_built_regimes, make_figures
from tests.made.netcdf import store
from tests.made.report import register_animation, write_claims
from tests.made.runs import FAILURE, make_study

DRAWN = ("walton_2", "gallas_1a", "gallas_1b", "gallas_1c")


class Page(HTMLParser):
    """Collect the elements of a page and its visible text; check that tags are balanced."""

    VOID = frozenset({"meta", "img", "br", "link", "input", "hr"})

    def __init__(self, text: str):
        super().__init__()
        self.elements: list[tuple[str, dict[str, str]]] = []
        self.open: list[str] = []
        self.text = ""
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        self.elements.append((tag, dict(attrs)))
        if tag not in self.VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.text += data

    def all(self, tag: str) -> list[dict[str, str]]:
        return [attrs for name, attrs in self.elements if name == tag]


@pytest.fixture(scope="module")
def made(tmp_path_factory) -> tuple[Path, Path]:
    return make_figures(tmp_path_factory.mktemp("made"))


@pytest.fixture(scope="module")
def unjudged(made) -> Page:
    return read(made)


@pytest.fixture(scope="module")
def page(made, unjudged) -> Page:
    """Return the report with verdicts, written after that without."""
    study = load_study(*made)
    write_claims(made[1] / "made" / "claims.json", list(study.points))
    return read(made)


def read(made: tuple[Path, Path]) -> Page:
    page = Page(build(*made).read_text(encoding="utf-8"))
    assert page.open == []
    return page


def test_nothing_is_loaded_from_elsewhere(page):
    assert not any("src" in script for script in page.all("script"))
    targets = [a.get("href") or a.get("src") for tag in ("a", "img", "link") for a in page.all(tag)]
    # What has none shows by script what is embedded elsewhere.
    targets = [target for target in targets if target is not None]
    assert len(targets) > 2 * len(DRAWN)
    assert all(target.startswith(("data:", "#")) for target in targets)


def test_every_figure_is_inside_once_with_alternative_text_and_data(page, made):
    images = {image["id"]: image for image in page.all("img") if "src" in image}
    assert set(images) == {f"picture-{name}" for name in DRAWN}
    assert all(len(image["alt"]) > 30 for image in images.values())
    data = {a["download"]: a["href"] for a in page.all("a") if "download" in a and "href" in a}
    assert set(data) == {f"{name}.csv" for name in DRAWN}
    folder = made[1] / "made" / "figures"
    for name in DRAWN:
        assert content(images[f"picture-{name}"]["src"]) == (folder / f"{name}.svg").read_bytes()
        assert content(data[f"{name}.csv"]) == (folder / f"{name}.csv").read_bytes()
        caption, details = parted((folder / f"{name}.caption.txt").read_text())
        assert caption in page.text and details and all(line in page.text for line in details)


def content(uri: str) -> bytes:
    return base64.b64decode(uri.partition("base64,")[2])


def test_every_run_is_listed_with_what_became_of_it(page, made):
    points = load_study(*made).points
    assert {f"run-{point}" for point in points} <= {row.get("id") for row in page.all("tr")}
    assert FAILURE in page.text
    assert f"1 of {len(points)} points failed" in " ".join(page.text.split())


def test_provenance_is_shown(page):
    assert "0123456789ab" in page.text
    assert "talus study" in page.text
    assert "2026-01-01" in page.text


def test_a_number_with_which_no_runs_decide_is_shown_as_untestable(made, page):
    folder = made[1] / "made"
    claims = read_claims(folder / "claims.json")
    (claim,) = [one for one in claims if one["by_number"]]
    claim["by_number"].append({"value": 0.77, "verdict": "untestable", "checks": []})
    found = load_results(folder / "dataset.nc")
    shown = Page(render(load_study(*made), found, folder / "figures", claims, data_uri))
    assert "0.77untestable no runs decide it" in " ".join(shown.text.split())


def test_the_study_file_is_shown_with_its_parts(tmp_path, page):
    assert "grid: {depth: [0.5, 2.5, 5, 10], restitution: [0.7, 0.85]}" in page.text
    (tmp_path / "one.yaml").write_text("study: one\nseries: [{name: one, system: belt}]\n")
    (tmp_path / "both.yaml").write_text("study: both\nparts: [one.yaml]\n")
    study = load_study(tmp_path / "both.yaml", tmp_path)
    assert [file.name for file in study.files] == ["both.yaml", "one.yaml"]


def test_a_study_not_judged_says_so(unjudged):
    text = " ".join(unjudged.text.split())
    assert "have not been judged on this study" in text
    assert "tested claims" not in text


def test_verdicts_are_counted(page):
    text = " ".join(page.text.split())
    assert "1 of 7 tested claims reproduced, 1 in part; 1 not tested by this study" in text
    assert "1 depends on the protocol, 1 on how the paper is read" in text
    assert "1 of the claims is on the contact law alone and needs no runs" in text


def test_a_study_that_tests_no_claim_says_so_once_and_shows_its_figures_first(made, page):
    path = made[1] / "made" / "claims.json"
    content = path.read_text(encoding="utf-8")
    document = parse_sealed_json(content)
    kept = [one for one in document["claims"] if one["id"] in ("W1", "G31")]
    path.write_text(to_sealed_json(document | {"claims": kept}), encoding="utf-8")
    found = read(made)
    path.write_text(content, encoding="utf-8")
    text = " ".join(found.text.split())
    assert "test none of the papers' claims. 1 of 1 engine check holds" in text
    assert "tested claims" not in text
    sections = [one.get("id") for one in found.all("section")]
    assert sections.index("figures") < sections.index("claims")
    links = [one["href"] for one in found.all("a") if one.get("href") in ("#figures", "#claims")]
    assert links[:2] == ["#figures", "#claims"]
    usual = [one.get("id") for one in page.all("section")]
    assert usual.index("claims") < usual.index("figures")


@pytest.fixture(scope="module")
def doubtful(tmp_path_factory) -> Page:
    """Return a report with two runs that leak energy."""
    study_path, results = make_figures(tmp_path_factory.mktemp("doubtful"))
    belts = [
        point.id
        for point in load_study(study_path, results).points.values()
        if point.parameters.system == "belt"
    ]
    for key, share in zip(belts[:2], (0.05, 340.0), strict=True):
        path = results / "made" / "runs" / f"{key}.nc"
        with xr.open_dataset(path) as opened:
            run = opened.load()
        run["energy_residual"][0] = share
        store(run, path)
    build_dataset(study_path, results)
    return read((study_path, results))


def test_points_with_a_caveat_are_marked_with_its_text(doubtful, page):
    marks = [one for one in doubtful.all("a") if "caveat-1" in one.get("aria-describedby", "")]
    assert len(marks) == 2
    assert [one.get("data-caveat") for one in doubtful.all("tr")].count("with") == 2
    assert doubtful.text.count("⚠ caveat") == 2
    text = " ".join(doubtful.text.split())
    assert re.search(r"Caveat for 2 of \d+ points: energy does not add up", text), text[-600:]
    assert "⚠" not in page.text


def test_the_ledger_is_not_said_to_be_good_when_points_have_a_caveat(doubtful, page):
    text = " ".join(doubtful.text.split())
    assert "but for 2 points with a caveat" in text

    def tone(one: Page) -> str:
        return next(tag["class"] for tag in one.all("dd") if "class" in tag)

    assert tone(doubtful) == "open"
    assert tone(page) == "good"


def test_a_claim_shows_its_evidence(page):
    text = " ".join(page.text.split())
    for shown in ("15 to 17", "16.90 ± 0.40", "no boundary at α = 30°", "belt_ghost false", "–"):
        assert shown in text
    assert "the criterion & its <limits>" in text


def test_damaged_verdicts_are_named_and_set_aside(made, page):
    path = made[1] / "made" / "claims.json"
    content = path.read_bytes()
    path.write_bytes(content[:100])
    with pytest.raises(DamagedError, match=r"claims\.json.*rerun the study"):
        build(*made)
    assert not path.exists()
    path.write_bytes(content)


def test_boundaries_have_a_table_of_their_own(page, tmp_path):
    assert "Boundaries between regimes" not in page.text
    study_path, results = make_built_regimes(tmp_path)
    dataset = results / "regimes" / "dataset.nc"
    study = load_study(study_path, results)
    draw_figures(list(study.figures), dataset, results / "regimes" / "figures", code="made")
    text = build(study_path, results).read_text(encoding="utf-8")
    assert "Boundaries between regimes" in Page(text).text
    row = re.search(r"<tr><th scope=.row.>onset</th>.*?</tr>", text, re.DOTALL).group()
    assert re.findall(r"<td[^>]*>(.*?)</td>", row) == [
        *("A_z = 0.5 ⟨d⟩", "frequency", "22.5", "22.75", "Hz", "0.25"),
        *("no transport", "transport", "found", "11"),
    ]


def test_parameters_have_their_units(page):
    text = " ".join(page.text.split())
    assert "N m-1 normal stiffness" in text
    assert "0.4, 0.5 friction coefficient" in text
    assert "false also average the profiles" in text


def test_markup_in_a_title_is_text(tmp_path):
    study_path = tmp_path / "odd.yaml"
    study_path.write_text(
        "study: odd\ntitle: <b>1 < 2</b>\n"
        "series: [{name: one, system: belt, base: {replicates: 3}}]\n"
    )
    _, results = make_study(tmp_path)
    (results / "made").rename(results / "odd")
    build_dataset(study_path, results)
    page = Page(build(study_path, results).read_text(encoding="utf-8"))
    assert not page.all("b")
    assert "<b>1 < 2</b>" in page.text


def test_the_command_that_repeats_a_study_is_quoted_for_the_shell(made, tmp_path):
    study_path, results = made
    odd = tmp_path / "$(touch PWN) {a} b.yaml"
    odd.write_text(study_path.read_text())
    page = Page(build(odd, results).read_text(encoding="utf-8"))
    assert f"talus study '{odd}' --cores" in page.text


def test_a_missing_figure_is_named_and_the_old_report_stays(made, tmp_path):
    study_path, results = make_study(tmp_path)
    with pytest.raises(InputError, match=r"dataset\.nc"):
        build(study_path, results)
    build_dataset(study_path, results)
    (results / "made" / "report.html").write_text("old")
    with pytest.raises(InputError, match=r"walton_2\.png"):
        build(study_path, results)
    assert (results / "made" / "report.html").read_text() == "old"


def test_an_animation_has_its_first_picture_and_no_figure(tmp_path):
    with register_animation(tmp_path) as name:
        entry = figure_entry(FIGURES[name], tmp_path, data_uri)
        assert entry["group"] == "Animations"
        assert entry["picture"].startswith("data:image/png;base64,")
        assert entry["animation"].startswith("data:image/gif;base64,")
        (tmp_path / f"{name}.gif").unlink()
        with pytest.raises(InputError, match=rf"{name}\.gif: no such animation"):
            figure_entry(FIGURES[name], tmp_path, data_uri)


@pytest.mark.parametrize(("box", "broad"), [("0 0 460 320", False), ("0 0 900 320", True)])
def test_broad_pictures_are_told_from_others(tmp_path, box, broad):
    for suffix, text in ((".csv", "a\n1\n"), (".caption.txt", "Words."), (".svg", svg(box))):
        (tmp_path / f"walton_2{suffix}").write_text(text)
    assert figure_entry(FIGURES["walton_2"], tmp_path, relative_link)["broad"] is broad


def svg(box: str) -> str:
    return f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="{box}"/>'


def test_words_for_a_table_tell_what_was_measured():
    table = pd.DataFrame({name: [1.0, 2.5] for name in ("a [σ]", "b", "c", "d")})
    table["constant"] = 3.0
    table["mean velocity [m s-1]"] = [0.1, float("nan")]
    assert (
        describe_ranges(table)
        == "2 rows of data, a [σ] from 1 to 2.5, b from 1 to 2.5, c from 1 to 2.5"
    )
    table["mean velocity [m s-1]"] = [0.1, 0.4]
    assert describe_ranges(table).endswith("mean velocity [m s-1] from 0.1 to 0.4")
    assert describe_ranges(table.head(0)) == "0 rows of data"


def test_the_first_screen_has_the_main_figures_or_the_first():
    entries = [{"name": name} for name in ("belt_onset", "gallas_1a", "walton_2")]
    assert [entry["name"] for entry in headline_figures(entries)] == ["gallas_1a", "walton_2"]
    assert headline_figures(entries[:1]) == entries[:1]
    assert headline_figures([]) == []
