"""What starts fast stays fast: no heavy library is imported where none is needed."""

import subprocess
import sys
from pathlib import Path


def test_parameters_and_command_line_import_nothing_heavy():
    code = (
        "import sys, sim.cli, sim.parameters, sim.study.load, sim.report.points\n"
        "heavy = {'numba', 'xarray', 'pandas', 'matplotlib', 'scipy', 'dask', 'snakemake'}\n"
        "sys.exit(' '.join(heavy & set(sys.modules)) or 0)"
    )
    root = Path(__file__).parents[1]
    done = subprocess.run([sys.executable, "-c", code], cwd=root, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
