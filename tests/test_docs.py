"""What the pages name is there: files and folders of the package and of its tests."""

import re

import pytest

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
