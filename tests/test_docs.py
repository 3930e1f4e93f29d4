"""What the pages name is there: files and folders of the package and of its tests."""

import re

import pytest

from sim.claims.readings import readings_of
from sim.study.papers import papers
from tests.made.processes import ROOT

PAGES = sorted([*(ROOT / "docs").glob("*.md"), ROOT / "README.md", ROOT / "CONTRIBUTING.md"])

#: A path below sim/ or tests/, or a test file named alone, after another of its folder.
NAMED = re.compile(r"(?<![\w/.-])(?:\.\./)?((?:sim|tests)/[\w./*-]*|test_\w+\.py)")


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_files_that_a_page_names_are_there(page):
    missing = []
    for line in page.read_text(encoding="utf-8").splitlines():
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
