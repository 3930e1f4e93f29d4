"""An engine of a plug-in: one call, and points, runs and refusals know it."""

import subprocess
import sys

from tests.made.processes import ROOT

PLUGIN = """\
import sim


def make(p, replicate, substeps):
    from sim.engine.systems import build_own

    return build_own(p, replicate, substeps)


def refuses(p):
    if p.bumps:
        yield "bumps", "0"


sim.flow_engine(
    "mine", description="one of mine", make=make, refuses=refuses, lacks=["stored_energy"]
)
"""

SCRIPT = """\
import sim

sim.load_plugins("mine.py")
values = {"depth": 1, "cell": 5, "transient": 1, "average": 1, "progress": False}
run = sim.simulate("chute", engine="mine", **values)
print(str(run.engine.values)[:5], "mean_velocity" in run)
try:
    sim.simulate("chute", engine="mine", bumps=1, **values)
except sim.InputError as error:
    print(error)
"""


def test_a_plug_in_adds_an_engine(tmp_path):
    (tmp_path / "mine.py").write_text(PLUGIN)
    code = f"import sys; sys.path.append({str(ROOT)!r})\n{SCRIPT}"
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    first, second = done.stdout.splitlines()
    assert first == "mine. True"
    assert second.endswith("bumps: got 1; allowed: 0 with engine: mine")
