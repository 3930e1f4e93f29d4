"""Whatever is given as a point or as a study is read or refused in one line: ten thousand times."""

import re
import subprocess
import sys

import pytest

from tests.made.processes import ROOT

FILES = ("tests/properties/test_parameters.py", "tests/properties/test_study_files.py")
PASSED = re.compile(r"(\d+) passing")


@pytest.mark.long
def test_points_and_studies_of_all_kinds(capsys):
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", *FILES]
    command += ["--hypothesis-profile=long", "--hypothesis-show-statistics"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout[-5000:]
    number = sum(map(int, PASSED.findall(done.stdout)))
    assert number >= 10_000
    with capsys.disabled():
        print(f"\n{number} points and studies made up: each read, or refused in one line")
