"""What ``make setup`` says, with a Python that installs nothing."""

import shutil
import subprocess

import pytest

from tests.made.processes import ROOT

PYTHON = """\
#!/bin/sh
if [ "$1 $2" = "-m venv" ]; then mkdir -p "$3/bin" && cp "$0" "$3/bin/python"; fi
"""


@pytest.mark.skipif(shutil.which("make") is None, reason="no make installed")
def test_setup_says_how_to_enter_the_environment_once_it_is_made(tmp_path):
    python = tmp_path / "python"
    python.write_text(PYTHON)
    python.chmod(0o755)
    command = ["make", "-C", ROOT, "setup", f"PYTHON={python}", f"VENV={tmp_path / 'venv'}"]
    first, again = (
        subprocess.run(command, capture_output=True, text=True, check=True) for _ in range(2)
    )
    assert f"ready: . {tmp_path / 'venv'}/bin/activate\n" in first.stdout
    assert "ready" not in again.stdout
