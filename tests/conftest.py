"""Profiles of hypothesis, and the order of the tests.

``pytest --hypothesis-profile=long tests/properties`` searches instead of repeating the same
examples in every run.
"""

import gc
import os
import sys
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

from tests.made.once import SharedFolder

SLOW = [HealthCheck.too_slow, HealthCheck.filter_too_much, HealthCheck.large_base_example]

settings.register_profile(
    "fixed",
    max_examples=50,
    derandomize=True,
    deadline=None,
    suppress_health_check=[HealthCheck.too_slow],
)
settings.register_profile("long", max_examples=1000, deadline=None, suppress_health_check=SLOW)
settings.load_profile("fixed")

# Some machines prevent Python from writing bytecode. Each of the many processes in tests would then
# compile its libraries anew, which takes longer than most of their work.
if os.environ.pop("PYTHONDONTWRITEBYTECODE", None):
    bytecode = Path(__file__).parents[1] / ".pytest_cache" / "bytecode"
    os.environ["PYTHONPYCACHEPREFIX"] = sys.pycache_prefix = str(bytecode)
    sys.dont_write_bytecode = False

# The objects of tests and libraries live long: garbage collection at Python's default rate took a
# fifth of the time.
gc.set_threshold(100_000, 50, 100)

#: Files that run first: two that compile the loops of all others, one for each worker.
FIRST = (
    "engine/dynamics/test_chute_reference.py",
    "engine/dynamics/test_belt_reference.py",
)

#: Slow files that need those loops. At once they would compile them too; at the end the other
#: worker would wait for the last one.
SECOND = (
    "workflow/test_workflow.py",
    "workflow/test_refinement.py",
    "workflow/test_drill.py",
    "workflow/test_repairs.py",
)
FIGURES = "figures"


@pytest.fixture(scope="session", autouse=True)
def _shared_folder(tmp_path_factory) -> None:
    """Set the folder that many tests share."""
    base = tmp_path_factory.getbasetemp()
    SharedFolder.folder = (base.parent if "PYTEST_XDIST_WORKER" in os.environ else base) / "made"
    SharedFolder.folder.mkdir(exist_ok=True)


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Put the files of FIRST before the others, and those of SECOND behind the figures."""
    tests = Path(__file__).parent

    def place(item: pytest.Item) -> int:
        name = item.path.relative_to(tests).as_posix() if item.path.is_relative_to(tests) else ""
        if name in FIRST:
            return FIRST.index(name)
        if name.startswith(FIGURES):
            return len(FIRST)
        if name in SECOND:
            return len(FIRST) + 1 + SECOND.index(name)
        return len(FIRST) + 1 + len(SECOND)

    items.sort(key=place)
