"""The report as a browser sees it: everything inside, nothing loaded, nothing hidden."""

import base64
import re
from html.parser import HTMLParser
from pathlib import Path

import pytest

from sim.dataset import build as build_dataset
from sim.errors import InputError
from sim.figures import draw
from sim.report import build
from sim.study import load_study
from tests.factories import FAILURE, make_regimes, make_study

FIGURES = ("walton_2", "gallas_1a", "gallas_1b", "gallas_1c")


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
    study_path, results = make_study(tmp_path_factory.mktemp("made"))
    dataset = build_dataset(study_path, results)
    for name in FIGURES:
        draw(name, dataset, results / "made" / "figures")
    return study_path, results


@pytest.fixture(scope="module")
def page(made) -> Page:
    page = Page(build(*made).read_text(encoding="utf-8"))
    assert page.open == []
    return page


def test_nothing_is_loaded_from_elsewhere(page):
    assert not page.all("script") and not page.all("link")
    targets = [a.get("href") or a.get("src") for tag in ("a", "img") for a in page.all(tag)]
    assert targets
    assert all(target.startswith(("data:", "#")) for target in targets)


def test_every_figure_is_inside_with_alternative_text_and_downloads(page, made):
    images = page.all("img")
    assert len(images) == len(FIGURES)
    assert all(len(image["alt"]) > 30 for image in images)
    downloads = {a["download"]: a["href"] for a in page.all("a") if "download" in a}
    assert set(downloads) == {f"{name}{suffix}" for name in FIGURES for suffix in (".svg", ".csv")}
    figures = made[1] / "made" / "figures"
    for name, uri in downloads.items():
        assert base64.b64decode(uri.partition("base64,")[2]) == (figures / name).read_bytes()
    for name in FIGURES:
        assert (figures / f"{name}.caption.txt").read_text().strip() in page.text


def test_every_run_is_listed_with_what_became_of_it(page, made):
    points = load_study(*made).points
    assert all(point in page.text for point in points)
    assert FAILURE in page.text
    assert f"1 of {len(points)} points failed" in " ".join(page.text.split())


def test_verdict_and_provenance_are_shown(page):
    assert "Verdict: reproduced" in " ".join(page.text.split())
    assert "0123456789ab" in page.text
    assert "snakemake --cores 2 --configfile" in page.text


def test_it_reads_on_a_phone_and_in_the_dark(made):
    text = (made[1] / "made" / "report.html").read_text(encoding="utf-8")
    assert 'name="viewport"' in text
    assert "prefers-color-scheme: dark" in text


def test_boundaries_have_a_table_of_their_own(page, tmp_path):
    assert "Boundaries between regimes" not in page.text
    study_path, results = make_regimes(tmp_path)
    dataset = build_dataset(study_path, results)
    study = load_study(study_path, results)
    for name in study.figures:
        draw(name, dataset, results / "regimes" / "figures")
    text = build(study_path, results).read_text(encoding="utf-8")
    assert "Boundaries between regimes" in Page(text).text
    row = re.search(r"<tr><td>onset</td>.*?</tr>", text, re.DOTALL).group()
    assert re.findall(r"<td[^>]*>(.*?)</td>", row) == [
        *("onset", "A_z = 0.5 ⟨d⟩", "frequency", "22.5", "22.75", "Hz", "0.25"),
        *("no transport", "transport", "found", "11"),
    ]


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
    assert "Force balance" not in page.text


def test_a_missing_figure_is_named_and_the_old_report_stays(made, tmp_path):
    study_path, results = make_study(tmp_path)
    with pytest.raises(InputError, match=r"dataset\.nc"):
        build(study_path, results)
    build_dataset(study_path, results)
    (results / "made" / "report.html").write_text("old")
    with pytest.raises(InputError, match=r"walton_2\.csv"):
        build(study_path, results)
    assert (results / "made" / "report.html").read_text() == "old"
