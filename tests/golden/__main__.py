"""``python -m tests.golden [--record]``: compare all golden points, or write their numbers anew."""

import argparse
import json
import tempfile
from pathlib import Path

from tests.golden import BITS, FAILING, VALUES, computed, digest, early, machine, points, stored


def main() -> int:
    """Print a line per point; return 1 if any point differs from what is stored."""
    parser = argparse.ArgumentParser(prog="python -m tests.golden", description=__doc__)
    parser.add_argument("--record", action="store_true", help="write bits.json and values.json")
    record = parser.parse_args().record
    bits, values = {}, {}
    with tempfile.TemporaryDirectory() as folder:
        for name, parameters in points().items():
            path = computed(parameters, Path(folder))
            bits[name] = digest(path)
            if name not in FAILING:
                values[name] = early(parameters)
    known = stored(BITS) if BITS.exists() else {}
    before = known.get(machine(), {})
    for name, found in bits.items():
        same = "same bits" if before.get(name) == found else "OTHER BITS"
        print(f"{name:32}{found[:16]}  {same if name in before else 'not recorded'}")
    if record:
        BITS.write_text(json.dumps(known | {machine(): bits}, indent=1) + "\n", encoding="utf-8")
        VALUES.write_text(json.dumps(values, indent=1) + "\n", encoding="utf-8")
        return 0
    return int(before != bits)


if __name__ == "__main__":
    raise SystemExit(main())
