"""Compiled code is found again by a later process, and by no other version of the sources."""

import shutil
import subprocess
import sys
from time import process_time

import numpy as np
import pytest

from sim.engine.compile import numba
from sim.engine.identity import COMPILED_PARTS, ENGINE_PARTS, PACKAGE, source_files, source_hash
from sim.engine.systems import build
from tests.engine_motion.points import belt_point, chute_point
from tests.made.processes import ROOT

FLOW = """
from sim.parameters import parse_point
from sim.engine.systems import build
system = build(parse_point({"system": "chute", "depth": 0.2, "cell": 5}, "test"), 0)
system.sample(1, profiles=True)
"""

CONTACT = """
import numpy as np
from sim.claims.contacts import contact_path
from sim.engine.contact.walton_braun import walton_braun
contact_path(walton_braun(100.0, 0.8, 0.4), np.ones(1), np.ones((1, 3)), np.ones((1, 3)))
"""

TOLD = """
import logging
from time import process_time
import numpy as np
from sim.engine.compile import numba, working_time
logging.basicConfig(format="%(message)s", level=logging.INFO)
began, worked = process_time(), working_time()
for _ in range(2):
    numba.njit(lambda values: np.sin(values).sum())(np.ones(3))
spent = process_time() - began
assert working_time() - worked < 0.1 * spent, spent
"""

COUNT = """
import sys
import numba
kernels = {
    id(value): value
    for name, module in list(sys.modules.items()) if name.startswith("sim.")
    for value in vars(module).values() if isinstance(value, numba.core.dispatcher.Dispatcher)
}
hits = sum(sum(kernel.stats.cache_hits.values()) for kernel in kernels.values())
misses = sum(sum(kernel.stats.cache_misses.values()) for kernel in kernels.values())
print(hits, misses)
"""


def hits_and_misses(code: str) -> list[int]:
    """Return how many kernels a new process finds compiled, and how many it does not."""
    command = [sys.executable, "-c", code + COUNT]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return [int(word) for word in done.stdout.split()]


def test_compiled_code_lies_in_a_folder_of_its_sources(tmp_path, monkeypatch):
    monkeypatch.setenv("TALUS_CACHE_DIR", str(tmp_path))
    _, misses = hits_and_misses(CONTACT)
    assert misses >= 1
    assert [path.name for path in tmp_path.iterdir()] == [source_hash(COMPILED_PARTS)]
    hits, misses = hits_and_misses(CONTACT)
    assert misses == 0
    assert hits >= 1


def test_a_later_process_compiles_nothing():
    hits_and_misses(FLOW)
    hits, misses = hits_and_misses(FLOW)
    assert misses == 0
    assert hits >= 3


@pytest.mark.parametrize("parts", [ENGINE_PARTS, COMPILED_PARTS])
def test_hash_changes_with_any_file_of_its_parts_and_with_no_other(parts, tmp_path, monkeypatch):
    package = tmp_path / "sim"
    shutil.copytree(PACKAGE, package, ignore=shutil.ignore_patterns("__pycache__"))
    monkeypatch.setattr("sim.engine.identity.PACKAGE", package)
    before = source_hash(parts)
    (package / "figures" / "style.py").write_text("# changed\n")
    (package / "__main__.py").write_text("# changed\n")
    assert source_hash(parts) == before
    for path in source_files(parts):
        text = path.read_text()
        path.write_text(text + "\n# changed\n")
        assert source_hash(parts) != before, path
        path.write_text(text)
    assert source_hash(parts) == before


def test_compiling_is_told_once_and_is_no_work():
    command = [sys.executable, "-c", TOLD]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0 and done.stderr.count("compiling the engine;") == 1, done.stderr


@pytest.mark.parametrize("given", [chute_point(depth=1, cell=4), belt_point(beads=5, width=5)])
def test_the_time_of_the_loop_is_without_what_is_compiled_in_it(given, monkeypatch):
    system = build(given, 0)
    advance = system._advance

    def advance_and_compile(steps):
        if not spent:
            began = process_time()
            numba.njit(lambda values: np.sin(values).sum())(np.ones(3))
            spent.append(process_time() - began)
        return advance(steps)

    system.settle()
    system.sample()
    before, spent = system.loop_time, []
    monkeypatch.setattr(system, "_advance", advance_and_compile)
    # For a belt, the path after the run; its samples are timed by the loop itself.
    system.trace()
    assert spent and system.loop_time - before < sum(spent)
