"""What plug-ins register is tested as what ships: in a process that has loaded them."""

import os
import subprocess
import sys

import pytest

from tests.made.processes import ROOT

EXAMPLES = ROOT / "docs" / "examples"


@pytest.mark.parametrize(
    ("suite", "plugin", "names"),
    [
        ("test_laws.py", EXAMPLES / "hertz_mindlin.py", "hertz_mindlin"),
        ("test_motions.py", EXAMPLES / "ellipse.py", "ellipse and (moves or lags)"),
        ("test_motions.py", ROOT / "tests" / "data" / "motions.py", "saw or of_a_plugin"),
        ("test_observables.py", EXAMPLES / "base_slip.py", "base_slip"),
        ("test_plots.py", EXAMPLES / "boxes.py", "boxes"),
    ],
)
def test_the_suite_holds_for_a_plugin(suite, plugin, names):
    options = [f"tests/conformance/{suite}", "-k", names, "-q", "-p", "no:cacheprovider"]
    environment = os.environ | {"TALUS_PLUGINS": str(plugin), "PYTHONPATH": str(ROOT)}
    environment.pop("PYTEST_XDIST_WORKER", None)
    command = [sys.executable, "-m", "pytest", *options]
    done = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True)
    assert done.returncode == 0 and " passed" in done.stdout, done.stdout[-3000:]
