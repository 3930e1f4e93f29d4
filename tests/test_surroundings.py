"""What other programs have set, in the environment and in files, changes neither runs nor pictures.

The settings of a user are those of notebooks, debuggers and styles, which people leave in place.
"""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from tests.made.processes import HANG, ROOT

STUDY = """\
study: here
defaults: {belt: {transient: 1, average: 1, beads: 20, width: 6}}
series: [{name: one, system: belt, grid: {frequency: [20, 30]}}]
plots: [{name: speed, x: frequency}]
"""

#: All commands of a study but Snakemake's, in one process.
CODE = """
GIVEN = ["system", "transient", "average", "beads", "width", "frequency"]
import sys
from pathlib import Path
import sim
from sim.__main__ import main
def talus(*words):
    if code := main(words):
        sys.exit(code)
for point, values in sim.points("study.yaml").iterrows():
    given = {name: values[name] for name in GIVEN}
    Path(f"{point}.yaml").write_text(str(given))
    talus("run", "-q", f"{point}.yaml", "-o", f"results/here/runs/{point}.nc")
talus("job", "dataset", "study.yaml")
talus("figure", "speed", "results/here/dataset.nc", "-o", "figures", "--study", "study.yaml")
"""

#: A style that changes every picture.
STYLE = "font.weight: bold\nfont.family: serif\naxes.spines.left: False\nlines.linestyle: --\n"
STYLE += "backend: nonsense\nfigure.dpi: 30\nsvg.fonttype: none\nimage.cmap: hot\n"

#: A library in place of a file system without locks.
NO_LOCKS = "#include <errno.h>\nint flock(int a, int b) { errno = ENOLCK; return -1; }\n"

SETTINGS = {
    **{"MPLBACKEND": "nonsense", "MPLCONFIGDIR": "home"},
    **{"NUMBA_DISABLE_JIT": "1", "NUMBA_OPT": "0", "NUMBA_BOUNDSCHECK": "1"},
    **{"NUMBA_DEBUG_CACHE": "1", "NUMBA_NUM_THREADS": "0", "NUMBA_DEBUGINFO": "1"},
    **{"PYTHONWARNINGS": "error", "PYTHONOPTIMIZE": "2", "PYTHONUTF8": "0", "LC_ALL": "C"},
    **{"DASK_SCHEDULER": "nonsense", "HDF5_PLUGIN_PATH": "/nowhere"},
}


def study(folder: Path, **settings: str) -> tuple[dict[str, bytes], str]:
    """Compute a small study in a folder; return the files of its figure, and what was said."""
    (folder / "results/here/runs").mkdir(parents=True)
    (folder / "study.yaml").write_text(STUDY)
    done = subprocess.run(
        [sys.executable, "-c", CODE],
        cwd=folder,
        env=os.environ | {"PYTHONPATH": str(ROOT)} | settings,
        capture_output=True,
        text=True,
        timeout=HANG,
    )
    assert done.returncode == 0, done.stderr[-3000:]
    return {path.name: path.read_bytes() for path in (folder / "figures").iterdir()}, done.stdout


def test_the_settings_of_other_programs_change_neither_runs_nor_pictures(tmp_path):
    plain, foreign = tmp_path / "plain", tmp_path / "foreign"
    (foreign / "home").mkdir(parents=True)
    for place in (foreign, foreign / "home"):
        (place / "matplotlibrc").write_text(STYLE)
    (foreign / ".numba_config.yaml").write_text("disable_jit: 1\nopt: '0'\n")
    settings = dict(SETTINGS)
    if compiler := shutil.which("cc"):
        (tmp_path / "no_locks.c").write_text(NO_LOCKS)
        library = tmp_path / "no_locks.so"
        subprocess.run(
            [compiler, "-shared", "-fPIC", "-o", library, library.with_suffix(".c")], check=True
        )
        settings["LD_PRELOAD"] = str(library)
    expected = study(plain)
    assert len(expected[0]) == 4
    assert study(foreign, **settings) == expected


@pytest.mark.parametrize(
    ("given", "left"),
    [("svg", "svg"), ("module://json", "module://json"), ("module://of.no", None)],
)
def test_a_notebook_keeps_its_backend_where_it_can_be_imported(given, left):
    code = "import sim, matplotlib as m, os; print(os.environ.get('MPLBACKEND'))"
    done = subprocess.run(
        [sys.executable, "-c", code],
        cwd=ROOT,
        env=os.environ | {"MPLBACKEND": given},
        capture_output=True,
        text=True,
    )
    assert not done.returncode, done.stderr
    assert done.stdout.strip() == str(left)
