"""``python -m tests.mutations [WORD ...]``: plant each bug of bugs.yaml in a copy, run its tests.

With words, only bugs whose file or tests name one of them. The exit code is the number of bugs that
no test has noticed.
"""

import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import yaml

from tests.made.processes import ROOT
from tests.made.project import copy_tree

BUGS = Path(__file__).with_name("bugs.yaml")


def main(words: list[str]) -> int:
    """Plant the bugs one after the other; print what became of each."""
    bugs = [
        bug
        for bug in yaml.safe_load(BUGS.read_text(encoding="utf-8"))
        if not words or any(word in bug["file"] + bug["tests"] for word in words)
    ]
    survivors, healthy = 0, set()
    with tempfile.TemporaryDirectory() as folder:
        tree = copy_tree(Path(folder) / "project")
        shutil.copytree(ROOT / "tests", tree / "tests")
        for part in ("benchmarks", "docs", "results", "Makefile", "README.md"):
            (tree / part).symlink_to(ROOT / part)
        for number, bug in enumerate(bugs, 1):
            path = (tree / "sim" / bug["file"]).resolve()
            original = path.read_text(encoding="utf-8")
            if original.count(bug["old"]) != 1:
                print(f"{number:3} NOT PLANTED  {bug['file']}: {bug['old']}", flush=True)
                survivors += 1
                continue
            if bug["tests"] not in healthy and _tests_fail(tree, bug["tests"]):
                raise SystemExit(f"tests fail without any bug: {bug['tests']}")
            healthy.add(bug["tests"])
            path.write_text(original.replace(bug["old"], bug["new"]), encoding="utf-8")
            noticed = _tests_fail(tree, bug["tests"])
            path.write_text(original, encoding="utf-8")
            survivors += not noticed
            state = "noticed" if noticed else "SURVIVED"
            print(f"{number:3} {state:12} {bug['file']}: {bug['new']}", flush=True)
    print(f"{len(bugs) - survivors} of {len(bugs)} bugs noticed")
    return survivors


def _tests_fail(tree: Path, targets: str) -> bool:
    """Return whether a test of some folders or files fails in a tree; an error is no failure."""
    command = [sys.executable, "-B", "-m", "pytest", "-qx", "-p", "no:cacheprovider"]
    command += [f"tests/{target}" for target in targets.split()]
    environment = os.environ | {"PYTHONPATH": str(tree), "PYTHONDONTWRITEBYTECODE": "1"}
    done = subprocess.run(command, cwd=tree, env=environment, capture_output=True, text=True)
    if done.returncode not in (0, 1):
        raise SystemExit(f"pytest could not run {targets}:\n{done.stdout[-2000:]}")
    return done.returncode == 1


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
