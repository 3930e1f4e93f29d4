"""Motions of plug-ins on the conveyor: their parameters, and what is refused."""

import re
import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest

from sim.base.additions import additions, plugin_code_error
from sim.base.errors import InputError
from sim.base.plugins import load_plugins
from sim.parameters import (
    BeltParameters,
    ChuteParameters,
    ConveyorParameters,
    canonical_values,
    parse_point,
    point_id,
)
from tests.made.processes import ROOT, in_process, restore_plugins

#: Motions of plug-ins, each of which is refused for its reason.
REFUSED = """
import pytest, sim
from sim.base.errors import InputError
from sim.parameters import parse_point
names = [f"wrong{number}" for number in range(len(REASONS))]
sim.load_plugins(*(f"{name}.py" for name in names))
from sim.engine.boundary.motion import motion_of
for name, said in zip(names, REASONS):
    point = parse_point({"system": "conveyor", "motion": name}, "p")
    told = f"plug-in {name}.py .*motion {name}: .*{said}"
    with pytest.raises(InputError, match=told) as caught:
        motion_of(point)
    assert "\\n" not in str(caught.value)
"""


@pytest.fixture(autouse=True)
def _forget() -> Iterator[None]:
    with restore_plugins():
        yield


@pytest.fixture
def folder(tmp_path, monkeypatch) -> Path:
    """Return a folder with the plug-ins, in which everything happens."""
    shutil.copy(ROOT / "tests" / "data" / "motions.py", tmp_path)
    for name in ("ellipse.py", "hertz_mindlin.py"):
        shutil.copy(ROOT / "docs" / "examples" / name, tmp_path)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_a_conveyor_has_a_law_and_a_motion_of_plugins(folder):
    usual = ConveyorParameters()
    load_plugins("hertz_mindlin.py", "ellipse.py")
    for one in (BeltParameters(), ChuteParameters(), usual):
        same = parse_point({"system": one.system}, "p")
        assert point_id(same) == point_id(one) and canonical_values(same) == canonical_values(one)
        declared = type(same).model_fields
        for name, field in type(one).model_fields.items():
            assert name in ("law", "motion") or repr(declared[name]) == repr(field)
    given = {"law": "hertz_mindlin", "grain_modulus": 2e6, "motion": "ellipse", "belt_lag": 30}
    name = point_id(both := parse_point({"system": "conveyor"} | given, "p"))
    assert re.search(r"-law-hertz_mindlin\.\w{8}-.*-motion-ellipse\.\w{8}-", name)
    assert both.belt_lag == 30 and point_id(both.model_copy(update={"belt_lag": 31})) != name
    assert both.collision_time != usual.collision_time and not both.caveat


@pytest.mark.parametrize(
    ("motion", "name", "value"),
    [("ellipse", "belt_lag", -90), ("saw", "running", -0.5), ("sunk", "below", -2.5)],
)
def test_a_parameter_of_a_plugin_may_be_negative(folder, motion, name, value):
    (folder / "sunk.py").write_text(
        "import sim\n\nsim.motion('sunk', make=lambda p: (), state=lambda motion, angle: (0, 0, 0),"
        " parameters={'below': sim.parameter(-2, unit='1', description='depth', gt=-3, lt=0)})\n"
    )
    load_plugins("motions.py", "ellipse.py", "sunk.py")
    point = parse_point({"system": "conveyor", "motion": motion, name: value}, "p")
    assert getattr(point, name) == value
    with pytest.raises(InputError, match=f"{name}: got -1e\\+99; allowed: "):
        parse_point({"system": "conveyor", "motion": motion, name: -1e99}, "p")


#: What a motion returns at an angle, and why it is none.
NO_MOTIONS = [
    ("nan * sin(angle), 1.0, 0.0", r"what state returns at the angle 0.00.* is not finite: \[nan"),
    ("0, 0, 1 / (angle - 9) if angle > 9 else inf", "is not finite"),
    ("sin(angle / 2), 0.0, cos(angle / 2) / 2", "state has not the period 2π: at the angles"),
    ("sin(angle), 0.0, 0.9 * cos(angle)", "from 0 to the angle 1.5.* by 0.9"),
    ("angle % (2 * pi), 0.0, 1.0", "from 0 to the angle 6.283 the height that state returns"),
]


def test_a_motion_that_is_none_is_refused_before_it_moves_anything(folder):
    for number, (given, _) in enumerate(NO_MOTIONS):
        (folder / f"wrong{number}.py").write_text(
            "from math import cos, inf, nan, pi, sin\nfrom typing import NamedTuple\nimport sim\n\n"
            "class Wrong(NamedTuple):\n    pass\n\ndef state(motion, angle):\n    return "
            f"{given}\n\nsim.motion('wrong{number}', make=lambda p: Wrong(), state=state)\n"
        )
    in_process(folder, f"REASONS = {[said for _, said in NO_MOTIONS]!r}\n{REFUSED}")


def test_what_a_motion_raises_on_its_way_is_one_line(tmp_path):
    """Compiled code raises what its Python does, with no other frame of the plug-in's file."""
    (tmp_path / "raises.py").write_text(
        "import sim\n\ndef state(motion, angle):\n    raise ValueError('never')\n\n"
        "sim.motion('raises', make=lambda p: (), state=state)\n"
    )
    load_plugins(str(tmp_path / "raises.py"))
    with pytest.raises(ValueError) as caught:
        additions("motion")["raises"].value.state(0, 0)
    told = str(plugin_code_error(caught.value))
    assert told.startswith("plug-in raises.py (") and told.endswith("line 4: ValueError: never")
    with pytest.raises(ValueError) as other:
        int("of Talus")
    assert plugin_code_error(other.value) is None
