"""Profiles of hypothesis, and the order of the tests.

``pytest --hypothesis-profile=long tests/properties`` searches instead of repeating the same
examples in every run.
"""

import gc
import os
import sys
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings
from xarray.backends.file_manager import FILE_CACHE

from tests.made.once import SharedFolder

SLOW = [HealthCheck.too_slow, HealthCheck.filter_too_much, HealthCheck.large_base_example]

settings.register_profile(
    "fixed",
    max_examples=50,
    derandomize=True,
    deadline=None,
    suppress_health_check=[HealthCheck.too_slow],
)
settings.register_profile("long", max_examples=2000, deadline=None, suppress_health_check=SLOW)
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

#: Files and folders that run first, in this order; the longer name counts. Each worker takes two
#: files, then one after the other: the first one those of spheres and all golden points, which
#: compile the loops of all others, the second one those of beads and figures. Slow files come
#: early: at the end a worker would wait.
ORDER = (
    "engine/dynamics/test_chute_reference.py",
    "engine/dynamics/test_belt_reference.py",
    "golden/",
    "figures/",
    "workflow/",
    "conformance/",
    "engine/systems/",
    "engine/contact/",
    "test_extending.py",
    "test_snippets.py",
    "test_published.py",
    "report/test_browser.py",
)


@pytest.fixture(scope="session", autouse=True)
def _shared_folder(tmp_path_factory) -> None:
    """Set the folder that many tests share."""
    base = tmp_path_factory.getbasetemp()
    SharedFolder.folder = (base.parent if "PYTEST_XDIST_WORKER" in os.environ else base) / "made"
    SharedFolder.folder.mkdir(exist_ok=True)


@pytest.fixture(autouse=True)
def _closed_files() -> Iterator[None]:
    """Let no test leave a file open.

    Garbage collection would close it in any thread, whatever another one does with HDF5.
    """
    yield
    assert not len(FILE_CACHE), "xarray holds open files"


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Put what `ORDER` names before the others."""
    tests = Path(__file__).parent

    def place(item: pytest.Item) -> int:
        name = item.path.relative_to(tests).as_posix() if item.path.is_relative_to(tests) else ""
        starts = [(len(start), n) for n, start in enumerate(ORDER) if name.startswith(start)]
        return max(starts, default=(0, len(ORDER)))[1]

    items.sort(key=place)


def pytest_unconfigure(config: pytest.Config) -> None:
    """Say at the very end which tests a program that is not installed has left out."""
    terminal = config.pluginmanager.get_plugin("terminalreporter")
    skipped = terminal.stats.get("skipped", []) if terminal else []
    reasons = [report.longrepr[2].removeprefix("Skipped: ") for report in skipped]
    lacking = [one for one in reasons if "installed" in one or one.startswith("could not import")]
    for reason, count in Counter(lacking).items():
        terminal.write_line(f"NOT TESTED, {count} tests: {reason}", red=True, bold=True)


def pytest_collection_finish() -> None:
    """Let no garbage collection look through what has been imported: pytest ends with ten."""
    gc.freeze()
