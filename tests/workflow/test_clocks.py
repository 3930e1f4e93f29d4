"""Clocks that go back or are a day ahead: nothing is run again, and results stay as they are."""

import os
import random
import time
from pathlib import Path

import pytest

from tests.made.project import bare_folder, jobs, snakemake

SEED = int(os.environ.get("TALUS_DRILL_SEED", "1"))

DAY = 86400.0

pytestmark = pytest.mark.long


@pytest.fixture(scope="module")
def tree(tmp_path_factory) -> Path:
    """Return a folder with a finished study."""
    tree = bare_folder(tmp_path_factory.mktemp("clocks"))
    process = snakemake(tree)
    assert process.returncode == 0, process.stderr
    return tree


def contents(tree: Path) -> dict[Path, bytes]:
    """Return the content of all results but logs, benchmarks and notes."""
    paths = (tree / "results").rglob("*")
    kinds = (".nc", ".csv", ".svg", ".json", ".html")
    return {path: path.read_bytes() for path in paths if path.suffix in kinds and path.is_file()}


def ahead(chance: random.Random, path: Path) -> float:
    """A clock that was a day ahead until some files were made, and was then put right."""
    return chance.choice((0.0, DAY))


def behind(chance: random.Random, path: Path) -> float:
    """A clock that went back a day before some files were made."""
    return chance.choice((0.0, -DAY))


def jumping(chance: random.Random, path: Path) -> float:
    return chance.uniform(-2 * DAY, 2 * DAY)


@pytest.mark.parametrize("clock", [ahead, behind, jumping])
def test_times_of_files_run_nothing_again(clock, tree):
    chance, now, before = random.Random(SEED), time.time(), contents(tree)
    for path in sorted((tree / "results").rglob("*")):
        if path.is_file():
            shifted = now + clock(chance, path)
            os.utime(path, (shifted, shifted))
    times = {path: path.stat().st_ino for path in before if path.parent.name == "runs"}
    process = snakemake(tree)
    assert process.returncode == 0, process.stderr
    assert "batch" not in jobs(process.stderr) and "run" not in jobs(process.stderr)
    assert {path: path.stat().st_ino for path in times} == times
    after = contents(tree)
    # A report says when it was made.
    same = [path for path in before if path.suffix != ".html"]
    assert [path for path in same if after[path] != before[path]] == []
    assert jobs(snakemake(tree).stderr) == {}
