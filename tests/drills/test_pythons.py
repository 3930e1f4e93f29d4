"""The whole suite under each other Python that is supported and found here.

`TALUS_PYTHONS` may name their programs, with colons between them; else those on the path are taken.
"""

import os
import shutil
import subprocess
import sys

import pytest

from tests.made.processes import ROOT

SUPPORTED = ("3.11", "3.12", "3.13")
HERE = f"{sys.version_info.major}.{sys.version_info.minor}"


def found() -> list[str]:
    """Programs of other Pythons, the path of each."""
    named = os.environ.get("TALUS_PYTHONS", "")
    if named:
        return named.split(os.pathsep)
    programs = [shutil.which(f"python{one}") for one in SUPPORTED if one != HERE]
    return [path for path in programs if path and not subprocess.run([path, "-V"]).returncode]


@pytest.mark.long
def test_the_suite_passes_under_other_pythons(tmp_path, capsys):
    if not found():
        pytest.skip("no other supported Python here")
    for python in found():
        tree = tmp_path / "tree"
        subprocess.run(["git", "clone", "--quiet", str(ROOT), str(tree)], check=True)
        done = subprocess.run(
            ["make", "test", f"PYTHON={python}"], cwd=tree, capture_output=True, text=True
        )
        told = f"{python}: {done.stdout.strip().splitlines()[-1:]}"
        assert done.returncode == 0, told + done.stdout[-5000:]
        with capsys.disabled():
            print(f"\n{told}")
        shutil.rmtree(tree)
