"""Runs of extreme points end well or as recorded failures, without a number that is none."""

import json
import os
import subprocess
import sys

import pytest

from tests.made.processes import ROOT

#: Which runs, and with which settings of the compiler.
SETS = {"usual": (100, 1, {}), "bounds checked": (30, 2, {"NUMBA_BOUNDSCHECK": "1"})}


@pytest.mark.long
@pytest.mark.parametrize("name", SETS)
def test_extreme_points_complete_or_fail_as_they_say(name, tmp_path, capsys):
    number, seed, settings = SETS[name]
    # Code with other settings is not that of others.
    own = {"TALUS_CACHE_DIR": str(tmp_path / "cache")} if settings else {}
    done = subprocess.run(
        [sys.executable, "-m", "tests.drills.extreme", str(number), str(seed)],
        cwd=ROOT,
        env=os.environ | settings | own,
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr[-2000:]
    found = [json.loads(line) for line in done.stdout.splitlines()]
    assert len(found) == number
    for one in found:
        assert (one["code"], one["status"]) in ((0, "completed"), (3, "failed")), one
        assert one["finite"], one["point"]
    failed = sum(one["status"] == "failed" for one in found)
    with capsys.disabled():
        print(f"\n{number} extreme runs, {name}: {number - failed} completed, {failed} failed")
