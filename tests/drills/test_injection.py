"""Texts of a stranger stay texts in every page: no tag, no script, no address of theirs."""

import shutil
from collections import Counter
from html.parser import HTMLParser
from pathlib import Path

import pytest

from sim.figures.render import draw_figures
from sim.report import page
from sim.study.load import load_study
from tests.made.figures import make_figures
from tests.made.netcdf import edit_file
from tests.made.report import write_claims

#: Texts that would be a tag, end a script or an attribute, or run as a template.
HOSTILE = (
    "</script><script>alert(1)</script>",
    "<!--<script>",
    "<img src=x onerror=alert(1)>",
    "\"' onmouseover='alert(1)'",
    "javascript:alert(1)",
    "]]></svg><svg onload=alert(1)>",
    "{{ 7 * 7 }}{% raw %}",
    "$(touch x) `touch x`",
)


class Tags(HTMLParser):
    """Counts tags with the names of their attributes; collects addresses."""

    def __init__(self) -> None:
        super().__init__()
        self.tags: Counter[tuple[str, ...]] = Counter()
        self.addresses: set[str] = set()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags[(tag, *(name for name, _ in attrs if name.startswith("on")))] += 1
        self.addresses |= {str(value) for name, value in attrs if name in ("href", "src")}


def tags_of(path: Path) -> Tags:
    tags = Tags()
    tags.feed(path.read_text(encoding="utf-8"))
    return tags


def report_tags(folder: Path, text: str) -> Tags:
    """Make the report of a study with a text in all places; return its tags."""
    folder.mkdir()
    study_path, results = make_figures(folder)
    made, quoted = results / "made", text.replace("'", "''")
    plot = f"plots: [{{name: own, title: '{quoted}', kind: curves, x: depth, series: [depths]}}]"
    words = study_path.read_text().replace("A made-up study", f"'{quoted}'")
    study_path.write_text(f"{words}\n{plot}\n")
    with edit_file(made / "dataset.nc") as file:
        file.title = text
        for name in {"versions", "first_run", "machine"} & set(file.ncattrs()):
            file.setncattr(name, text)
    study = load_study(study_path, results)
    draw_figures(list(study.entries), made / "dataset.nc", made / "figures", 1, "made", study_path)
    write_claims(made / "claims.json", list(study.points))
    page.build(study_path, results)
    report = tags_of(made / "report.html")
    shutil.rmtree(folder)
    return report


@pytest.fixture(scope="module")
def plain(tmp_path_factory) -> Tags:
    """The tags of the report with harmless words."""
    return report_tags(tmp_path_factory.mktemp("pages") / "plain", "words")


@pytest.mark.long
@pytest.mark.parametrize("text", HOSTILE)
def test_what_a_stranger_writes_is_shown_as_text(text, plain, tmp_path):
    theirs = report_tags(tmp_path / "hostile", text)
    assert plain.tags == theirs.tags
    assert not any(address.startswith("javascript:") for address in theirs.addresses)
