"""Studies run with the lowest versions of packages that pyproject.toml allows, and the newest."""

import os
import re
import subprocess
import tomllib
import venv
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from tests.made.processes import ROOT

PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
EXTRAS = PROJECT["optional-dependencies"]

#: What studies need, and what users may install besides.
NEEDED = PROJECT["dependencies"] + [
    one for name in ("crate", "dask", "export") for one in EXTRAS[name]
]

#: What the tests below need besides.
TOOLS = ("hypothesis", "pytest")

#: Tests that use each of the packages and take seconds.
TESTED = (
    "tests/base",
    "tests/parameters",
    "tests/dataset/test_build.py",
    "tests/surrogates/test_surrogate.py",
    "tests/surrogates/test_posterior.py::test_a_posterior_is_what_arviz_reads",
    "tests/figures/test_plots.py",
    "tests/report/test_results.py",
    "tests/report/test_crate.py",
    "tests/test_api.py",
)

STUDY = """\
study: small
defaults: {belt: {beads: 4, width: 5, transient: 1, average: 2, replicates: 2}}
series:
  - {name: s, system: belt, grid: {frequency: [20, 30]}}
plots:
  - {name: v, x: frequency}
"""


def test_every_package_has_a_lower_bound_that_the_lock_meets():
    pins = "\n".join(path.read_text() for path in ROOT.glob("requirements*.lock")).split()
    locked = {canonicalize_name(name): version for name, version in (p.split("==") for p in pins)}
    for needed in map(Requirement, NEEDED):
        assert [one.operator for one in needed.specifier] == [">="], needed
        assert locked[canonicalize_name(needed.name)] in needed.specifier


@pytest.mark.long
@pytest.mark.parametrize("pin", ["==", ">="], ids=["lowest", "newest"])
def test_a_study_and_tests_run_with_lowest_and_newest_versions(pin, tmp_path):
    venv.create(tmp_path / "venv", with_pip=True)
    python = tmp_path / "venv" / "bin" / "python"
    packages = [re.sub(">=", pin, one) for one in NEEDED]
    pip = [python, "-m", "pip", "install", "--quiet", "--no-compile"]
    subprocess.run([*pip, *packages, *TOOLS], check=True)
    (tmp_path / "study.yaml").write_text(STUDY)
    run(tmp_path, python, "-m", "talus", "study", "study.yaml", "--cores", "1")
    assert (tmp_path / "results" / "small" / "figures" / "v.svg").is_file()
    run(tmp_path, python, "-m", "pytest", "-q", "-p", "no:cacheprovider", *TESTED, folder=ROOT)


def run(home: Path, *command: object, folder: Path | None = None) -> None:
    """Run a command of an environment with an empty cache; its output is shown where it fails."""
    settings = os.environ | {
        "PATH": f"{home / 'venv' / 'bin'}{os.pathsep}{os.environ['PATH']}",
        "PYTHONPATH": str(ROOT),
        "TALUS_CACHE_DIR": str(home / "cache"),
    }
    # Else tests of two versions would share what they make.
    settings.pop("PYTEST_XDIST_WORKER", None)
    done = subprocess.run(
        list(map(str, command)), cwd=folder or home, env=settings, capture_output=True, text=True
    )
    assert done.returncode == 0, (done.stdout + done.stderr)[-5000:]
