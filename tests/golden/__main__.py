"""``python -m tests.golden [--record] [NAME ...]``: compare golden points, or write their numbers.

Without names, all points.
"""

import argparse
import json
import tempfile
from pathlib import Path

from tests.golden import BITS, FAILING, VALUES, computed, digest, early, machine, points, stored


def main() -> int:
    """Print a line per point; return 1 if any point differs from what is stored."""
    parser = argparse.ArgumentParser(prog="python -m tests.golden", description=__doc__)
    parser.add_argument("--record", action="store_true", help="write bits.json and values.json")
    parser.add_argument("names", nargs="*", metavar="NAME", help="points of points.yaml")
    asked = parser.parse_args()
    bits, values = {}, {}
    with tempfile.TemporaryDirectory() as folder:
        for name, parameters in points().items():
            if asked.names and name not in asked.names:
                continue
            (own := Path(folder) / name).mkdir()
            path = computed(parameters, own)
            bits[name] = digest(path)
            if name not in FAILING:
                values[name] = early(parameters)
    known = stored(BITS) if BITS.exists() else {}
    before = known.get(machine(), {})
    for name, found in bits.items():
        same = "same bits" if before.get(name) == found else "OTHER BITS"
        print(f"{name:32}{found[:16]}  {same if name in before else 'not recorded'}")
    if asked.record:
        bits = before | bits if asked.names else bits
        values = stored(VALUES) | values if asked.names else values
        BITS.write_text(json.dumps(known | {machine(): bits}, indent=1) + "\n", encoding="utf-8")
        VALUES.write_text(json.dumps(values, indent=1) + "\n", encoding="utf-8")
        return 0
    known_bits = {name: before.get(name) for name in bits} if asked.names else before
    return int(known_bits != bits)


if __name__ == "__main__":
    raise SystemExit(main())
