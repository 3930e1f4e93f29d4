"""What starts fast stays fast: no heavy library is imported where none is needed."""

import subprocess
import sys
from pathlib import Path

HEAVY = {"numba", "xarray", "pandas", "matplotlib", "scipy", "dask", "snakemake"}


def imported(code: str) -> set[str]:
    """Return the modules that a few lines of Python import."""
    lines = f"import sys\n{code}\nprint(*sys.modules)"
    root = Path(__file__).parents[1]
    command = [sys.executable, "-c", lines]
    return set(subprocess.check_output(command, cwd=root, text=True).split())


def test_help_imports_no_library_at_all():
    code = "from sim.__main__ import parser; parser('talus').format_help()"
    assert not imported(code) & (HEAVY | {"pydantic", "yaml", "numpy"})


def test_parameters_and_tables_of_points_import_nothing_heavy():
    code = "import sim.__main__, sim.parameters, sim.study.load, sim.report.points"
    assert not imported(code) & HEAVY
