"""Says to any pip at once which Python is needed; `pyproject.toml` has everything else."""

import sys

if sys.version_info < (3, 11):  # noqa: UP036  (what is refused here runs this)
    sys.exit("Talus needs Python 3.11 or newer, and this is Python " + sys.version.split()[0])

import setuptools

setuptools.setup()
