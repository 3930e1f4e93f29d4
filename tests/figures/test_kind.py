"""Kinds of plot: nothing is imported that a figure does not draw with."""

import subprocess
import sys
from pathlib import Path


def test_a_kind_is_imported_when_it_is_drawn():
    code = (
        "import sys, sim.figures.render\n"
        "from sim.figures.kind import KINDS, load_kind\n"
        "kinds = {f'sim.figures.{name}' for name in KINDS}\n"
        "before = kinds & set(sys.modules)\n"
        "load_kind('chute_map')\n"
        "print(sorted(before), sorted(kinds & set(sys.modules)))"
    )
    root = Path(__file__).parents[2]
    done = subprocess.run([sys.executable, "-c", code], cwd=root, capture_output=True, text=True)
    assert done.stdout == "[] ['sim.figures.chute_map']\n", done.stderr
