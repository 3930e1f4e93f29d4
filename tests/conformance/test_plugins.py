"""What plug-ins register is tested as what ships: in a process that has loaded them."""

import os
import re
import subprocess
import sys

import pytest

from tests.made.processes import ROOT

EXAMPLES = ROOT / "docs" / "examples"

#: Plug-ins, each with the suite of what it registers and which of its tests are run.
PLUGINS = {
    EXAMPLES / "base_slip.py": ("test_observables.py", "base_slip"),
    EXAMPLES / "boxes.py": ("test_plots.py", "boxes and all"),
}

#: Loops under a motion and a second law take a minute to compile, and neither knows of the other.
COMPILED = {
    EXAMPLES / "hertz_mindlin.py": ("test_laws.py", "hertz_mindlin"),
    EXAMPLES / "ellipse.py": ("test_motions.py", "ellipse and (moves or lags)"),
    ROOT / "tests" / "data" / "motions.py": (
        "test_motions.py",
        "(saw and not changes1) or of_a_plugin",
    ),
}


@pytest.mark.parametrize(
    ("plugins", "registered"),
    [
        (PLUGINS, ("base_slip", "boxes")),
        pytest.param(COMPILED, ("hertz_mindlin", "ellipse", "saw"), marks=pytest.mark.long),
    ],
    ids=["drawn", "compiled"],
)
def test_the_suites_hold_for_plugins(plugins, registered):
    suites = dict.fromkeys(f"tests/conformance/{suite}" for suite, _ in plugins.values())
    names = " or ".join(f"({names})" for _, names in plugins.values())
    environment = os.environ | {
        "TALUS_PLUGINS": os.pathsep.join(map(str, plugins)),
        "PYTHONPATH": str(ROOT),
    }
    environment.pop("PYTEST_XDIST_WORKER", None)
    command = [sys.executable, "-m", "pytest", *suites, "-k", names, "-v", "-p", "no:cacheprovider"]
    done = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout[-3000:]
    for name in registered:
        assert re.search(rf"\[.*{name}.*\] PASSED", done.stdout), done.stdout[-3000:]
