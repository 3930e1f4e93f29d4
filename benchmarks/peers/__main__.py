"""Compare Talus with LAMMPS, from the repository's root with the project's Python.

    python -m benchmarks.peers                          # every flow, five pairs of stretches
    python -m benchmarks.peers compare --flows soft-500 belt --pairs 3
    python -m benchmarks.peers tune                     # find LAMMPS' best settings again
    python -m benchmarks.peers check                    # do both compute the same physics?
    python -m benchmarks.peers start                    # start-up, and a further run's set-up
    python -m benchmarks.peers sweep --cycles 3         # Gallas' Fig. 1a on two cores, short

LAMMPS is that of the extra ``lammps``; developed flows and what ``tune`` finds are kept in
``.cache``, which may be removed at any time.
"""

import argparse
import logging
import os

from benchmarks.peers import check, compare, start, sweep, tune
from benchmarks.peers.flows import FLOWS, Flow
from benchmarks.peers.machine import build_of_lammps, processor

COMMANDS = {
    "compare": lambda given: compare.main(_flows(given), given.pairs),
    "tune": lambda given: tune.main(_flows(given)),
    "check": lambda given: check.main(),
    "start": lambda given: start.main(),
    "sweep": lambda given: sweep.main(given.cycles),
}


def _flows(given: argparse.Namespace) -> list[Flow]:
    return [flow for flow in FLOWS if flow.name in given.flows]


def main() -> None:
    """Run one command, all but the sweep on a single core."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.peers",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("command", nargs="?", choices=list(COMMANDS), default="compare")
    names = [flow.name for flow in FLOWS]
    parser.add_argument("--flows", nargs="+", choices=names, default=names, metavar="FLOW")
    parser.add_argument("--pairs", type=int, default=5, help="stretches per engine")
    parser.add_argument("--core", type=int, help="core to compute on (default: the last)")
    parser.add_argument(
        "--cycles", type=float, default=45, help="cycles of the sweep, discarded and averaged each"
    )
    given = parser.parse_args()
    logging.basicConfig(level=logging.INFO, format="%(message)s")
    if given.command != "sweep":
        last = max(os.sched_getaffinity(0))
        os.sched_setaffinity(0, {last if given.core is None else given.core})
    print(f"{processor()}\n{build_of_lammps()}", flush=True)
    COMMANDS[given.command](given)


if __name__ == "__main__":
    main()
