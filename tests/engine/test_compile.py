"""Compiled code: what it is compiled with, cheap calls, vector instructions."""

import os
import platform
import shutil
import stat
import subprocess
import sys
from itertools import product
from pathlib import Path
from time import process_time
from typing import NamedTuple
from unittest.mock import Mock

import numpy as np
import pytest
from numba.core.caching import IndexDataCacheFile

from sim.base.errors import InputError
from sim.engine import compile as engine
from sim.engine import identity
from sim.engine.compile import address_of, call, call_directly, exact, kernel, kind_of, numba
from sim.engine.identity import COMPILED_PARTS, ENGINE_PARTS, PACKAGE, source_files, source_hash
from sim.engine.systems import build
from tests.engine_motion.helpers import appended, gathered_sums
from tests.engine_motion.points import belt_point, chute_point
from tests.made.processes import ROOT, SHORTER_VECTORS

#: Compiles one kernel of the engine and one of its own, twice each; prints how many were compiled.
TOTAL = """
import logging
from time import process_time
import numpy as np
from sim.engine.compile import numba, working_time
from sim.engine.observe.profiles import REAL, total
logging.basicConfig(format="%(message)s", level=logging.INFO)
began, worked = process_time(), working_time()
for _ in range(2):
    numba.njit(lambda values: np.sin(values).sum())(np.ones(3))
spent = process_time() - began
assert working_time() - worked < 0.1 * spent, spent
total(np.ones(9), REAL)
print(sum(total.stats.cache_misses.values()), sum(total.stats.cache_hits.values()))
"""

#: Numbers of negative gaps are appended without the widest vectors, too.
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


def run(code: str, **settings: str) -> subprocess.CompletedProcess:
    """Run code in a process of its own, which must not fail."""
    command, environment = [sys.executable, "-c", code], os.environ | settings
    done = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done


def test_compiled_code_lies_in_a_folder_of_its_sources_and_a_later_process_finds_it(tmp_path):
    """That code is compiled is told once, and it is no working time."""
    first, second = (run(TOTAL, TALUS_CACHE_DIR=str(tmp_path)) for _ in range(2))
    assert first.stdout.split() == ["1", "0"] and second.stdout.split() == ["0", "1"]
    assert first.stderr.count("compiling the engine;") == 1
    assert [path.name for path in tmp_path.iterdir()] == [source_hash(COMPILED_PARTS)]


@pytest.mark.parametrize("given", [chute_point(depth=1, cell=4), belt_point(beads=5, width=5)])
def test_the_time_of_the_loop_is_without_what_is_compiled_in_it(given, monkeypatch):
    system = build(given, 0)
    advance, spent = system._advance, []

    def advance_and_compile(steps):
        began = process_time()
        numba.njit(lambda values: np.sin(values).sum())(np.ones(3))
        spent.append(process_time() - began)
        monkeypatch.undo()
        return advance(steps)

    system.settle()
    before = system.loop_time
    monkeypatch.setattr(system, "_advance", advance_and_compile)
    # For a belt, the path after the run; its samples are timed by the loop itself.
    system.trace()
    assert spent and system.loop_time - before < sum(spent)


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


def test_a_direct_call_and_one_at_an_address_are_the_same_machine_code():
    """To the bit, though the sum may be taken in any order where it is compiled once more."""
    for size in range(1, 200, 7):
        pair = Pair(np.random.default_rng(size).random(size), 0.3)
        sum_of = address_of(_sum_of, "test", pair, 0)
        scale = address_of(_scale, "test", pair)
        again = Pair(pair.values.copy(), 0.3)
        _scale(again)
        assert _scaled_sum(sum_of, scale, pair, 0) == _sum_of(again, 0)
        assert call_directly(_sum_of, kind_of(again), again, 3) == _sum_of(again, 3)
        assert np.array_equal(pair.values, again.values)


SPECIAL = np.array([np.nan, -np.nan, 0.0, -0.0, np.inf, -np.inf, 5e-324, -5e-324, 1.0, -1.0])


def test_numbers_of_negative_gaps_are_appended_in_their_order():
    """Neither zeros nor what is not a number is negative; what lies before the list stays."""
    rng = np.random.default_rng(1)
    for length, share in product(range(44), (0.0, 0.1, 0.5, 0.9, 1.0)):
        gap = rng.exponential(size=length + 3) * np.where(rng.random(length + 3) < share, -1, 1)
        for values in (gap, rng.choice(SPECIAL, length)):
            for first, free in ((0, 0), (1000, 3), (2**32 - 64, 17)):
                out = np.arange(900, 900 + free + length + 24).astype(np.uint32)
                before = out.copy()
                count = appended(values, length, first, out, free)
                expected = first + np.flatnonzero(values[:length] < 0.0)
                assert np.array_equal(out[free : free + count], expected)
                assert np.array_equal(out[:free], before[:free])
                assert np.array_equal(out[free + count + 8 :], before[free + count + 8 :])


@pytest.mark.long
@pytest.mark.skipif(platform.machine() != "x86_64", reason="names a processor of another kind")
def test_so_they_are_appended_where_vectors_are_shorter():
    run(APPEND, **SHORTER_VECTORS)


def test_a_kernel_that_promises_arrays_apart_computes_the_same():
    rng = np.random.default_rng(2)
    source, index, out = rng.random(100), rng.integers(0, 100, 37), rng.random(37)
    expected = out + source[index]
    gathered_sums(source, index, out)
    assert np.array_equal(out, expected)


NAME = source_hash(COMPILED_PARTS)


@pytest.fixture(autouse=True)
def temporary(tmp_path_factory, monkeypatch) -> Path:
    """The system's folder of temporary files; nothing is named and there is no home."""
    folder = tmp_path_factory.mktemp("temporary")
    monkeypatch.setattr("tempfile.tempdir", str(folder))
    for name in ("TALUS_CACHE_DIR", "XDG_CACHE_HOME"):
        monkeypatch.delenv(name, raising=False)

    def unknown():
        raise RuntimeError("Could not determine home directory.")

    monkeypatch.setattr(Path, "home", unknown)
    identity._temporary_folder.cache_clear()
    yield folder
    identity._temporary_folder.cache_clear()


def test_it_follows_the_environment(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "shared"))
    assert identity.cache_directory() == tmp_path / "shared" / "talus" / NAME
    monkeypatch.setenv("TALUS_CACHE_DIR", str(tmp_path / "mine"))
    folder = identity.cache_directory()
    assert folder == tmp_path / "mine" / NAME
    assert stat.S_IMODE(folder.stat().st_mode) == 0o700


@pytest.mark.parametrize("home", ["unknown", "empty", "not writable"])
def test_without_a_home_it_is_a_temporary_one_of_the_user_and_said_once(
    home, tmp_path, temporary, monkeypatch, caplog
):
    if home == "empty":
        monkeypatch.setattr(Path, "home", lambda: Path("/"))
        monkeypatch.setenv("HOME", "")
    elif home == "not writable":
        (tmp_path / "file").write_text("in the way")
        monkeypatch.setenv("TALUS_CACHE_DIR", str(tmp_path / "file"))
    folders = {identity.cache_directory() for _ in range(3)}
    assert folders == {temporary / f"talus-{os.geteuid()}" / NAME}
    assert len(caplog.messages) == 1 and str(*folders) in caplog.text


def plant(folder: Path, how: str, monkeypatch) -> None:
    """Make a folder as somebody else would, before it is looked for."""
    if how == "link":
        (folder.parent / "elsewhere").mkdir()
        folder.symlink_to(folder.parent / "elsewhere")
    elif how == "file":
        folder.write_text("in the way")
    else:
        folder.mkdir()
        folder.chmod(0o777 if how == "open" else 0o700)
    if how == "other":
        owner = os.geteuid()
        monkeypatch.setattr(os, "geteuid", lambda: owner + 1)


@pytest.mark.parametrize("how", ["link", "file", "open", "other"])
def test_a_folder_that_others_have_planted_is_not_used(how, temporary, monkeypatch):
    owner = os.geteuid() + (how == "other")
    predictable = temporary / f"talus-{owner}"
    plant(predictable, how, monkeypatch)
    folder = identity.cache_directory()
    assert folder.parent == temporary and folder != predictable
    assert stat.S_IMODE(folder.stat().st_mode) == 0o700


@pytest.mark.parametrize(
    ("how", "message"),
    [("link", "is a link"), ("open", "others can write"), ("other", "belongs to user")],
)
def test_a_folder_that_is_named_and_not_ones_own_is_refused(how, message, tmp_path, monkeypatch):
    plant(tmp_path / NAME, how, monkeypatch)
    monkeypatch.setenv("TALUS_CACHE_DIR", str(tmp_path))
    with pytest.raises(InputError, match=rf"environment: TALUS_CACHE_DIR: .*{message}.*allowed: "):
        identity.cache_directory()


def test_a_folder_that_others_could_replace_is_refused(tmp_path, monkeypatch):
    shared = tmp_path / "shared"
    shared.mkdir()
    shared.chmod(0o777)
    monkeypatch.setenv("TALUS_CACHE_DIR", str(shared))
    with pytest.raises(InputError, match=f"others can write {shared}; allowed: "):
        identity.cache_directory()
    # Where only the owner may rename, as in the system's temporary folder, nobody can.
    shared.chmod(0o1777)
    assert identity.cache_directory() == shared / NAME


def test_a_full_disk_keeps_no_code_and_stops_no_run(caplog, monkeypatch):
    full = Mock(side_effect=OSError(28, "No space left on device"))
    monkeypatch.setattr(engine, "_save_code", full)
    IndexDataCacheFile.save(Mock(), "spheres", "code of spheres")
    IndexDataCacheFile.save(Mock(), "disks", "code of disks")
    assert caplog.messages == ["compiled code is not kept: No space left on device"]


def test_code_that_two_processes_store_at_once_is_never_loaded_as_the_others(tmp_path):
    first, second, third = (IndexDataCacheFile(str(tmp_path), "kernel", "stamp") for _ in range(3))
    # Both have read the index before either writes, and the first writes its code last.
    second._load_index = dict
    save_data = first._save_data

    def save_data_last(*arguments):
        second.save("disks", "code of disks")
        save_data(*arguments)

    first._save_data = save_data_last
    first.save("spheres", "code of spheres")
    assert third.load("disks") == "code of disks"
    assert third.load("spheres") in ("code of spheres", None)
