"""``python -m tests.drills.extreme NUMBER SEED``: runs of extreme points, a line of JSON for each.

Several parameters at once lie up to a thousand times above or below their defaults.
"""

import json
import logging
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

import netCDF4
import numpy as np
from annotated_types import Ge, Gt, Le, Lt

from sim.base.errors import InputError
from sim.engine.run import run_point
from sim.engine.systems.belt import SETTLING_LIMIT
from sim.parameters import SYSTEMS, Parameters, canonical_values, parse_point, point_id
from sim.study.cost import estimate

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


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
