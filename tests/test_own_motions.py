"""Motions of plug-ins on the conveyor: place, velocity and work of the plane; what is checked."""

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
from tests.made.plugins import restore_plugins, without_plugins
from tests.made.processes import ROOT, in_process

#: The harmonic motion as a plug-in has it, and a sawtooth: to and fro in shares q and 1 - q of a
#: cycle along x, up and down in equal ones, each way half a wave of a cosine. And a base that also
#: goes along at a constant velocity.
MOTIONS = """
from math import cos, pi, sin
from typing import NamedTuple

import sim


class Sine(NamedTuple):
    pass


class Saw(NamedTuple):
    share: float
    running: float


def sine(motion, angle):
    return sin(angle), cos(angle), cos(angle)


def saw(motion, angle):
    way, whole = angle % (2 * pi), 2 * pi * motion.share
    if way < whole:
        along = pi / whole * sin(pi * way / whole)
    else:
        rest = 2 * pi - whole
        along = -pi / rest * sin(pi * (way - whole) / rest)
    return -cos(way), along + motion.running, sin(way)


sim.motion("sine", make=lambda p: Sine(), state=sine)
sim.motion(
    "saw",
    make=lambda p: Saw(p.share, p.running),
    state=saw,
    parameters={
        "share": sim.parameter(0.7, unit="1", description="share of the way forth", gt=0, lt=1),
        "running": sim.parameter(0, unit="1", description="constant velocity"),
    },
)
"""

BEGIN = """
import numpy as np, sim
sim.load_plugins("motions.py")
from sim.engine.systems import build
from sim.parameters import parse_point

def point(**given):
    usual = {"system": "conveyor", "shape": "disc", "depth": 2, "cell": 8, "frequency": 30}
    return parse_point(usual | {"transient": 1, "average": 1} | given, "p")

def series(system, cycles):
    samples = [system.advance() for _ in range(round(cycles * system.parameters.samples_per_cycle))]
    return {name: np.array([one[name] for one in samples]) for name in system.series}
"""


@pytest.fixture(autouse=True)
def _forget() -> Iterator[None]:
    with restore_plugins():
        yield


@pytest.fixture
def folder(tmp_path, monkeypatch) -> Path:
    """Return a folder with the plug-ins, in which everything happens."""
    (tmp_path / "motions.py").write_text(MOTIONS)
    for name in ("ellipse.py", "hertz_mindlin.py"):
        shutil.copy(ROOT / "docs" / "examples" / name, tmp_path)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_the_harmonic_motion_of_a_plugin_is_that_of_talus(folder):
    """Collisions make any difference of rounding grow, so no longer than for the first of them."""
    lines = """
for given in ({}, {"angle": 10, "amplitude_along": 0.5}):
    one, other = (series(build(point(**given, **more), 0), 1) for more in ({}, {"motion": "sine"}))
    for name in one:
        size = np.abs(one[name]).max()
        assert np.abs(one[name] - other[name]).max() <= 1e-9 * size, name
    assert one["plane_work"][-1] != 0 and one["largest_overlap"].max() > 0
"""
    in_process(folder, BEGIN + lines)


def test_energy_adds_up_on_a_plane_that_moves_like_a_saw(folder):
    """And friction carries along what lies on it, in the direction of the slow way."""
    lines = """
for given in ({"amplitude": 0.3}, {"angle": 10, "running": 0.5}, {"law": "hertz", "share": 0.3}):
    system = build(point(motion="saw", **given), 0)
    found = series(system, 30)
    gain = {name: found[name][-1] - found[name][0] for name in system.ledger.terms}
    missing = sum(sign * gain[name] for name, sign in system.ledger.terms.items())
    assert gain["plane_work"] > 0 and abs(missing) < 5e-3 * gain["plane_work"], given
    weight = np.mean(found["base_normal_force"][-400:])
    assert abs(weight / system.weight[1] - 1) < 0.1
    if "amplitude" in given:
        assert found["mean_velocity"][-400:].mean() > 0.02 * 0.3e-3 * system.drive.rate
"""
    in_process(folder, BEGIN + lines)


def test_place_and_velocity_of_the_plane_follow_the_motion(folder):
    lines = """
from math import pi
from sim.engine.boundary.drive import plane_position, plane_velocity, vibration
p = point(motion="saw", amplitude=0.5, amplitude_along=0.8, running=0.2)
drive, rate = vibration(p, (0.0, 0.0, -9.8)), 2 * pi * 30
time, step = np.linspace(0.001, 2.4 / 30, 50), 1e-7
for axis in (0, 1):
    moved = plane_position(drive, axis, time + step) - plane_position(drive, axis, time - step)
    assert np.allclose(moved / (2 * step), plane_velocity(drive, axis, time), atol=1e-6)
cycles = plane_position(drive, 0, np.array([0.0, 0.7, 1.0, 3.0]) / 30) / 0.8e-3
assert np.allclose(cycles, [0, 2 + 0.7 * 0.4 * pi, 0.4 * pi, 1.2 * pi], atol=1e-5)
heights = plane_position(drive, 1, np.array([0.0, 0.25, 0.5]) / 30)
assert np.allclose(heights, [-0.5e-3, 0, 0.5e-3], atol=1e-12)
"""
    in_process(folder, BEGIN + lines)


def test_a_flow_goes_on_under_a_motion_of_a_plugin_and_from_its_states(folder):
    lines = """
from sim.engine.boundary.drive import plane_velocity
from sim.engine.replicate import Replicate
from sim.engine.states import pack, unpack
from sim.parameters import require_compatible_source

def laboratory(system, time):
    velocity = system.spheres.velocity[:, np.argsort(system.spheres.label[0])].copy()
    velocity[0] += plane_velocity(system.drive, 0, time)
    velocity[2] += plane_velocity(system.drive, 1, time)
    return velocity

saw = {"motion": "saw"}
for first, second in (({}, saw), (saw, saw | {"share": 0.2})):
    before, after = point(**first), point(**second)
    require_compatible_source(after, before, "p")
    one, other = build(before, 0), build(after, 0)
    series(one, 2)
    ended = laboratory(one, (one.flow.step[0] - 0.5) * one.time_step)
    other.take_over(one)
    assert np.allclose(laboratory(other, -0.5 * other.time_step), ended, atol=1e-12)

replicate = Replicate(point(motion="saw"), 0)
replicate.recorder.take_snapshot()
replicate.recorder.take(replicate.system.sample())
again = Replicate.from_state(replicate.parameters, 0, unpack(pack(replicate.state())))
assert replicate.system.advance() == again.system.advance()
"""
    in_process(folder, BEGIN + lines)


def test_a_conveyor_has_a_law_and_a_motion_of_plugins(folder):
    usual = ConveyorParameters()
    load_plugins("hertz_mindlin.py", "ellipse.py")
    for one in (BeltParameters(), ChuteParameters(), usual):
        same = parse_point({"system": one.system}, "p")
        assert point_id(same) == point_id(one) and canonical_values(same) == canonical_values(one)
        declared = type(same).model_fields
        for name, field in type(one).model_fields.items():
            assert name in ("law", "motion") or repr(declared[name]) == repr(field)
    given = {"law": "hertz_mindlin", "youngs_modulus": 2e6, "motion": "ellipse", "belt_lag": 30}
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


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"motion": "ellips"}, "motion: got 'ellips'; allowed: "),
        ({"belt_lag": 30}, "belt_lag: got 30; .* unless motion is ellipse"),
        ({"youngs_modulus": 2e6, "motion": "ellipse"}, "youngs_modulus: .* unless law is hertz"),
        ({"motion": "ellipse", "overtone": 3}, "overtone: got 3; .*2 unless motion is harmonic"),
        *(
            ({"motion": "ellipse", name: 0.5}, f"{name}: got 0.5; .*0 unless motion is harmonic")
            for name in ("phase_along", "overtone_amplitude", "overtone_along", "overtone_phase")
        ),
    ],
)
def test_conveyors_of_a_motion_are_checked(folder, values, message):
    load_plugins("hertz_mindlin.py", "ellipse.py")
    with pytest.raises(InputError, match=message):
        parse_point({"system": "conveyor"} | values, "point")


@pytest.mark.parametrize(
    ("given", "said"),
    [
        (
            "nan * sin(angle), 1.0, 0.0",
            "what state returns at the angle 0.00.* is not finite: [nan",
        ),
        ("0, 0, 1 / (angle - 9) if angle > 9 else inf", "is not finite"),
        ("sin(angle / 2), 0.0, cos(angle / 2) / 2", "state has not the period 2π: at the angles"),
        ("sin(angle), 0.0, 0.9 * cos(angle)", "from 0 to the angle 1.5.* by 0.9"),
        ("angle % (2 * pi), 0.0, 1.0", "from 0 to the angle 6.283 the height that state returns"),
    ],
)
def test_a_motion_that_is_none_is_refused_before_it_moves_anything(folder, given, said):
    lines = f"""
import re, pytest
from sim.base.errors import InputError
from sim.engine.boundary.own_motion import own_motion
with pytest.raises(InputError, match="plug-in wrong.py .*motion wrong: .*") as caught:
    own_motion(point(motion="wrong"))
assert re.search({said.replace("[nan", "[[]nan")!r}, str(caught.value)), caught.value
assert "\\n" not in str(caught.value)
"""
    (folder / "wrong.py").write_text(
        "from math import cos, inf, nan, pi, sin\nfrom typing import NamedTuple\nimport sim\n\n"
        "class Wrong(NamedTuple):\n    pass\n\ndef state(motion, angle):\n"
        f"    return {given}\n\nsim.motion('wrong', make=lambda p: Wrong(), state=state)\n"
    )
    in_process(folder, BEGIN.replace("motions.py", "wrong.py") + lines)


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


def test_a_conveyor_knows_of_no_motion_without_plugins():
    with without_plugins(), pytest.raises(InputError, match="motion"):
        parse_point({"system": "conveyor", "motion": "harmonic"}, "point")
