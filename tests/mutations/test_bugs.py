"""Each deliberate bug can still be planted, and its tests are there."""

import pytest
import yaml

from tests.made.processes import ROOT
from tests.mutations.__main__ import BUGS


@pytest.mark.parametrize(
    "bug", yaml.safe_load(BUGS.read_text(encoding="utf-8")), ids=lambda bug: bug["new"]
)
def test_the_text_of_a_bug_occurs_once(bug):
    source = (ROOT / "sim" / bug["file"]).read_text(encoding="utf-8")
    assert source.count(bug["old"]) == 1 and bug["new"] != bug["old"]
    assert all((ROOT / "tests" / target).exists() for target in bug["tests"].split())
