"""What holds for every observable: one is tested by being registered."""

import os
import re
import subprocess
import sys

import numpy as np
import pytest

from sim.dataset.gather import measure
from sim.figures.caption import unit_of
from sim.parameters import SYSTEMS, complete_values, parse_point
from sim.parameters.variables import observables, variables_of
from sim.study.plottable import numbers
from sim.study.reference import reference_text
from tests import conformance  # noqa: F401  (loads the plug-ins)
from tests.made.processes import ROOT

OBSERVABLES = [(system, name) for system in SYSTEMS for name in observables(system)]

#: A product of powers of units, as UDUNITS reads it.
UNITS = re.compile(r"1|[A-Za-z]+(-?[1-9])?( [A-Za-z]+(-?[1-9])?)*")

#: What raises an error of its own on a replicate without arrays.
LACKING = {"base_slip": "all runs of chutes have what it needs"}

#: What parameters alone say.
OF_PARAMETERS = {"shaking_strength", "throw_number"}


def point_of(system: str):
    return parse_point({"system": system}, "test")


@pytest.mark.parametrize(("system", "name"), OBSERVABLES)
def test_an_observable_has_a_unit_a_meaning_and_a_place_in_plots_and_reference(system, name):
    variable = observables(system)[name].variable
    assert UNITS.fullmatch(variable.unit) and variable.meaning.strip()
    assert variable.name == name and system in variable.systems
    shown = numbers(system)[name]
    assert (shown.unit, shown.meaning) == (variable.unit, variable.meaning)
    assert not variable.asked_by or variable.asked_by in SYSTEMS[system].model_fields
    assert f"- `{name}`" in reference_text()
    assert unit_of(variable.unit, "natural", system) != "1"


@pytest.mark.parametrize("system", SYSTEMS)
def test_a_replicate_without_arrays_has_no_value_and_no_error(system):
    declared = {name: one for name, one in observables(system).items() if name not in LACKING}
    point = point_of(system)
    known = dict.fromkeys(variables_of("scalar", system=system), np.nan) | complete_values(point)
    known |= {name: value for name, (value, _) in point.limits.items()}
    values = measure(known | {"particles": point.particles}, declared, "p")
    assert values.keys() == declared.keys()
    assert {name for name, value in values.items() if not np.isnan(value)} <= OF_PARAMETERS


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
