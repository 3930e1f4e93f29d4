"""Examples in docstrings give what they say.

pytest's own collection of them would look for some in every module, tests included.
"""

import doctest
from importlib import import_module

import pytest

from tests.made.processes import ROOT

MODULES = [
    ".".join(path.relative_to(ROOT).with_suffix("").parts)
    for path in sorted((ROOT / "sim").rglob("*.py"))
    if ">>> " in path.read_text(encoding="utf-8")
]


@pytest.mark.parametrize("module", MODULES)
def test_examples_give_what_they_say(module):
    failed, attempted = doctest.testmod(import_module(module))
    assert attempted and not failed
