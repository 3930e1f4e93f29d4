"""``python -m tests.slurm COMMAND ...``: run a command beside a Slurm of one node."""

import argparse
import signal
import subprocess
import sys
import tempfile
from pathlib import Path

from tests.slurm.cluster import ACCOUNT, PARTITION, Cluster, install, lacking


def main() -> int:
    """Run the command and return its exit code; 2 where the machine cannot have a Slurm."""
    parser = argparse.ArgumentParser(
        prog="python -m tests.slurm",
        description=f"Run a command, a shell for instance, beside a Slurm of one node: "
        f"account {ACCOUNT}, partition {PARTITION}.",
    )
    parser.add_argument("command", nargs=argparse.REMAINDER, metavar="COMMAND")
    words = parser.parse_args().command or parser.error("no command")
    if reason := lacking():
        print(f"error: {reason}", file=sys.stderr)
        return 2
    install()
    # Otherwise the daemons would outlive it.
    signal.signal(signal.SIGTERM, lambda number, _: sys.exit(128 + number))
    with tempfile.TemporaryDirectory() as folder, Cluster(Path(folder)) as cluster:
        return subprocess.run(words, env=cluster.environment).returncode


if __name__ == "__main__":
    raise SystemExit(main())
