"""Compiled code: what it is compiled with, cheap calls, vector instructions."""

import os
import platform
import shutil
import subprocess
import sys
from time import process_time
from typing import NamedTuple

import numpy as np
import pytest

from sim.engine.compile import address_of, call, call_directly, exact, kernel, kind_of, numba
from sim.engine.identity import COMPILED_PARTS, ENGINE_PARTS, PACKAGE, source_files, source_hash
from sim.engine.systems import build
from tests.engine_motion.helpers import appended, gathered_sums
from tests.engine_motion.points import belt_point, chute_point
from tests.made.processes import ROOT, SHORTER_VECTORS

FLOW = """
from sim.parameters import parse_point
from sim.engine.systems import build
system = build(parse_point({"system": "chute", "depth": 0.2, "cell": 5}, "test"), 0)
system.sample(1, profiles=True)
"""

CONTACT = """
import numpy as np
from sim.claims.experiments import contact_path
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

APPEND = """
import numpy as np
from sim.engine.compile import append_negative, numba

@numba.njit
def appended(gap, size, out):
    return append_negative(gap, size, 100, out, np.uint64(1))

for size in range(17):
    for bits in range(256):
        signs = np.resize([-1.0 if bits >> lane & 1 else 1.0 for lane in range(8)], size)
        out = np.zeros(32, np.uint32)
        count = appended(signs, size, out)
        assert (out[1 : 1 + count] == 100 + np.flatnonzero(signs < 0.0)).all(), (size, bits)
assert "%zmm" not in "".join(appended.inspect_asm().values())
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


class Pair(NamedTuple):
    """Numbers and what they are multiplied with."""

    values: np.ndarray
    factor: float


@kernel
def _sum_of(pair, first):
    total = 0.0
    for k in range(first, pair.values.size):
        total += pair.factor * pair.values[k]
    return total


@kernel
def _scale(pair):
    for k in range(pair.values.size):
        pair.values[k] *= pair.factor


@exact
def _scaled_sum(sum_of, scale, pair, first):
    call(scale, None, pair)
    return call(sum_of, 0.0, pair, first)


def test_a_direct_call_does_what_the_kernel_does():
    pair = Pair(np.random.default_rng(1).random(1000), 0.3)
    kind = kind_of(pair)
    for _ in range(2):
        assert call_directly(_sum_of, kind, pair, 3) == _sum_of(pair, 3)
    other = Pair(np.ones(5), 2.0)
    assert call_directly(_sum_of, kind_of(other), other, 1) == 8.0


def test_a_call_at_an_address_is_the_same_machine_code():
    """To the bit, though the sum may be taken in any order where it is compiled once more."""
    for size in range(1, 200, 7):
        pair = Pair(np.random.default_rng(size).random(size), 0.3)
        sum_of = address_of(_sum_of, "test", pair, 0)
        scale = address_of(_scale, "test", pair)
        again = Pair(pair.values.copy(), 0.3)
        _scale(again)
        assert _scaled_sum(sum_of, scale, pair, 0) == _sum_of(again, 0)
        assert np.array_equal(pair.values, again.values)


SPECIAL = np.array([np.nan, -np.nan, 0.0, -0.0, np.inf, -np.inf, 5e-324, -5e-324, 1.0, -1.0])


def appended_numbers(gap, size: int, first: int, free: int) -> np.ndarray:
    """What is appended to a list of which ``free`` entries are taken, which must stay."""
    out = np.arange(900, 900 + free + size + 8).astype(np.uint32)
    count = appended(gap, size, first, out, free)
    assert np.array_equal(out[:free], np.arange(900, 900 + free))
    return out[free : free + count]


@pytest.mark.parametrize("size", range(41))
def test_numbers_of_negative_gaps_are_appended_in_their_order(size):
    rng = np.random.default_rng(size)
    for share in (0.0, 0.1, 0.5, 0.9, 1.0):
        gap = rng.exponential(size=size + 3) * np.where(rng.random(size + 3) < share, -1.0, 1.0)
        for first, free in ((0, 0), (1000, 3), (2**32 - 64, 17)):
            expected = first + np.flatnonzero(gap[:size] < 0.0)
            assert np.array_equal(appended_numbers(gap, size, first, free), expected)


@pytest.mark.parametrize("size", range(1, 41))
def test_neither_zeros_nor_what_is_not_a_number_is_negative(size):
    rng = np.random.default_rng(size)
    for _ in range(20):
        gap = rng.choice(SPECIAL, size)
        assert np.array_equal(appended_numbers(gap, size, 5, 2), 5 + np.flatnonzero(gap < 0.0))


def test_no_more_than_eight_entries_behind_the_last_are_overwritten():
    rng = np.random.default_rng(1)
    for size in range(41):
        gap = rng.normal(size=size)
        out = np.full(64, 7, np.uint32)
        count = appended(gap, size, 100, out, 0)
        assert (out[count + 8 :] == 7).all()


@pytest.mark.skipif(platform.machine() != "x86_64", reason="names a processor of another kind")
def test_so_they_are_appended_where_vectors_are_shorter():
    command = [sys.executable, "-c", APPEND]
    done = subprocess.run(
        command, cwd=ROOT, env=os.environ | SHORTER_VECTORS, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr


def test_a_kernel_that_promises_arrays_apart_computes_the_same():
    rng = np.random.default_rng(2)
    source, index, out = rng.random(100), rng.integers(0, 100, 37), rng.random(37)
    expected = out + source[index]
    gathered_sums(source, index, out)
    assert np.array_equal(out, expected)
