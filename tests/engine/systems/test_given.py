"""Flows from a given state, against closed forms and against the state that they came from."""

from math import cos, radians, sqrt

import pytest

from sim import Flow, InputError, simulate
from sim.engine.run import run_point
from sim.engine.stored_run import read_parameters
from sim.parameters import ChuteParameters, given, parse_point

ONE = {"cell": 4, "sample_interval": 0.05, "angle": 0}


def quiet(flow: Flow, duration: float) -> Flow:
    return flow.run(duration, progress=False)


@pytest.mark.parametrize("engine", ["chute", "conveyor", "belt"])
def test_a_free_fall_is_exact_from_its_first_step_on(engine):
    state = {"x (d)": [1.5], "z (d)": [6.0], "vx (m/s)": [0.02], "vz (m/s)": [0.05]}
    size = {"width": 5} if engine == "belt" else {"cell": 4, "friction": 0}
    flow = quiet(Flow(engine, state=state, **size), 0.3)
    p, t = flow.parameters, flow.time
    slope = radians(getattr(p, "angle", 0))
    height = 6 * p.diameter + 0.05 * t - p.gravity * cos(slope) * t**2 / 2
    mean = float(flow.series.height_of_mass[-1])
    # The plane's own path is a sum of steps in the frame of the conveyor.
    assert mean == pytest.approx(height, rel=1e-8 if engine == "conveyor" else 1e-11)


def test_release_from_a_height_is_a_free_fall():
    p = {"depth": 1 / 16, "initial_velocity": 0, "initial_agitation": 0, **ONE}
    flow = Flow("chute", initial_height=20, initial_normal_velocity=3, **p)
    d, g = flow.parameters.diameter, flow.parameters.gravity
    t = quiet(flow, 4).time
    expected = 20.5 * d + 3 * sqrt(g * d) * t - g * t**2 / 2
    assert flow.positions[0, 2] == pytest.approx(expected, rel=1e-11)
    packing = Flow("chute", depth=2, cell=4, initial_height=1.5)
    assert (packing.positions[:, 2] - packing.radii).min() == pytest.approx(1.5 * d, abs=1e-5 * d)


@pytest.mark.parametrize("system", ["chute", "belt"])
def test_the_last_state_of_a_run_is_a_start(system):
    size = {"beads": 8, "width": 5} if system == "belt" else {"depth": 1, "cell": 4, "bumps": 0.5}
    flow = quiet(Flow(system, **size, diameter_spread=0.2), 1)
    size = {"width": 5} if system == "belt" else {"cell": 4, "bumps": 0.5}
    again = Flow(system, state=flow.particles, **size)
    mobile = again.parameters.particles
    assert (again.positions == flow.positions).all() and (again.radii == flow.radii).all()
    step = 1e3 * again.parameters.gravity * again.parameters.time_step
    assert abs(again.velocities - flow.velocities)[:mobile].max() < step
    run = simulate(system, **size, state=flow.particles, transient=0, average=1, progress=False)
    other = Flow(system, state=run, **size)
    assert (other.positions == run.position[0, -1]).all()


def test_what_is_shown_of_particles_cannot_be_assigned_to():
    flow = Flow("chute", depth=1, cell=4)
    for name in ("positions", "velocities", "spins", "radii"):
        with pytest.raises(ValueError, match="read-only"):
            getattr(flow, name)[0] = 0.5


def test_lighter_and_smaller_particles_shorten_the_time_step(monkeypatch):
    state = {"x (d)": [1, 3], "z (d)": [2, 2], "diameter (d)": [1, 0.5]}
    usual, light = (
        Flow("chute", state={**state, "diameter (d)": [1, size]}, **ONE).parameters
        for size in (1.0, 0.5)
    )
    assert light.time_step == pytest.approx(usual.time_step * 0.5**1.5)
    option = ChuteParameters.option
    own = ChuteParameters.options("law")["drag"].model_copy(update={"one_mass": True})
    of_one_mass = lambda p, choice: own if choice == "law" else option(p, choice)  # noqa: E731
    monkeypatch.setattr(ChuteParameters, "option", of_one_mass)
    with pytest.raises(InputError, match=r"line 3, column diameter.*kg each with"):
        Flow("chute", state=state, law="drag", **ONE)


def test_a_run_file_or_a_folder_brings_the_state_to_another_process(tmp_path, monkeypatch):
    text = "x (d), z (d), wx\n1, 2, 3\n3, 2, 0\n"
    point = parse_point({"system": "chute", "initial_state": text, "average": 1} | ONE, "p")
    point = point.model_copy(update={"transient": 0.0})
    particles = given.given_particles(point)
    given.write_states(tmp_path, [point])
    run_point(point, tmp_path / "run.nc", quiet=True)
    for bring in (read_parameters, lambda path: given.read_states(path.parent, [point])):
        monkeypatch.setattr(given, "_known", {})
        with pytest.raises(InputError, match="the content of this one is not at hand"):
            given.given_particles(point)
        bring(tmp_path / "run.nc")
        for before, after in zip(particles, given.given_particles(point), strict=True):
            assert (before == after).all()


def test_a_run_of_a_conveyor_is_no_state_as_its_velocities_are_those_to_the_plane():
    flow = Flow("conveyor", depth=1, cell=4)
    with pytest.raises(InputError, match=r"state: got .*; allowed: a data frame of velocities in"):
        Flow("conveyor", state=flow.particles, cell=4)
