"""``python -m benchmarks.scale``: print what a large study costs, as a table.

Of each command it tells the processor time of all its processes, the time on the clock, and the
most memory that its processes held together.
"""

import argparse
import tempfile
from pathlib import Path

from benchmarks.scale import copies, real
from benchmarks.scale.grid import ROW


def main() -> None:
    """Measure what the command line asks for."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.scale")
    parser.add_argument("--real", action="store_true", help="run all points, of four beads each")
    parser.add_argument("--rows", type=int, default=100, help=f"of {ROW} points each")
    parser.add_argument("--replicates", type=int, help="default: 5, and 1 if all points are run")
    parser.add_argument("-j", "--processes", type=int, default=2)
    parser.add_argument("--folder", type=Path, help="where to make it (default: a temporary one)")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory(dir=options.folder) as name:
        if options.real:
            real.measure(Path(name), options.rows, options.replicates or 1, options.processes)
        else:
            copies.measure(Path(name), options.rows, options.replicates or 5, options.processes)


if __name__ == "__main__":
    main()
