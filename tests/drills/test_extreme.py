"""Runs of extreme points end well or as recorded failures, without a number that is none.

Several parameters at once lie up to a thousand times above or below their defaults.
``python -m tests.drills.test_extreme NUMBER SEED`` runs them: a line of JSON for each.
"""

import json
import logging
import os
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

import netCDF4
import numpy as np
import pytest
from annotated_types import Ge, Gt, Le, Lt

from sim.base.errors import InputError
from sim.engine.run import run_point
from sim.engine.systems.belt import SETTLING_LIMIT
from sim.parameters import SYSTEMS, Parameters, canonical_values, parse_point, point_id
from sim.study.cost import estimate
from tests.made.processes import ROOT

#: A short run of each system, and the most seconds that a point may be estimated to take.
SHORT = {
    "chute": {"depth": 1.5, "cell": 4, "transient": 1, "average": 2},
    "belt": {"beads": 20, "width": 6, "transient": 1, "average": 2},
}
LONGEST = 2.0

#: Most particle-steps of a bed that never comes to rest.
MOST_SETTLING = 1e8

#: Parameters that say how much is computed and by whom, not what.
LEFT = ("seed", "threads", "replicates", "transient", "average", "limit", "target")


def extreme_point(rng: np.random.Generator) -> Parameters | None:
    """Return a point with some extreme values, none where they are refused or take too long."""
    system = str(rng.choice(list(SHORT)))
    values = {"system": system} | SHORT[system]
    usual = parse_point(values, "usual")
    fields = {
        name: field
        for name, field in SYSTEMS[system].model_fields.items()
        if field.annotation in (int, float) and name not in LEFT
    }
    for name in rng.choice(list(fields), rng.integers(1, 6), replace=False):
        field = fields[str(name)]
        value = float(getattr(usual, name) or 1.0) * 10 ** rng.uniform(-3, 3)
        for bound in field.metadata:
            match bound:
                case Ge(ge=low) | Gt(gt=low):
                    value = max(value, low if isinstance(bound, Ge) else low + 1e-9)
                case Le(le=high) | Lt(lt=high):
                    value = min(value, high if isinstance(bound, Le) else high - 1e-9)
        values[str(name)] = round(value) if field.annotation is int else value
    try:
        point = parse_point(values, "extreme")
    except InputError:
        return None
    if system == "belt" and point.beads * SETTLING_LIMIT / point.settling_step > MOST_SETTLING:
        return None
    return point if estimate(point).core_seconds < LONGEST else None


def outcome(point: Parameters, folder: Path) -> dict:
    """Run a point; return its exit code, status and whether all that completed is finite."""
    path = folder / f"{point_id(point)}.nc"
    code = run_point(point, path, quiet=True)
    with netCDF4.Dataset(path) as file:
        file.set_auto_mask(False)
        velocity = np.asarray(file["mean_velocity"][:])[file["status"][:] == "completed"]
        status = file.getncattr("status")
    return {
        "code": code,
        "status": status,
        "finite": bool(np.isfinite(velocity).all()),
        "point": canonical_values(point),
    }


def main(number: int, seed: int) -> None:
    """Run so many points and print what came of each."""
    logging.disable(logging.CRITICAL)
    rng, done = np.random.default_rng(seed), 0
    with TemporaryDirectory() as folder:
        while done < number:
            if point := extreme_point(rng):
                print(json.dumps(outcome(point, Path(folder))), flush=True)
                done += 1


#: Which runs, and with which settings of the compiler.
SETS = {"usual": (100, 1, {}), "bounds checked": (30, 2, {"NUMBA_BOUNDSCHECK": "1"})}


@pytest.mark.long
@pytest.mark.parametrize("name", SETS)
def test_extreme_points_complete_or_fail_as_they_say(name, tmp_path, capsys):
    number, seed, settings = SETS[name]
    # Code with other settings is not that of others.
    own = {"TALUS_CACHE_DIR": str(tmp_path / "cache")} if settings else {}
    done = subprocess.run(
        [sys.executable, "-m", "tests.drills.test_extreme", str(number), str(seed)],
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


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
