"""Flows on a plane whose angle changes in time: a block, a sudden change, energy, run files."""

import netCDF4
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sim.engine.boundary.drive import tilt_after, tilt_of
from sim.engine.run import run_point
from sim.engine.states import flatten, pack, refill, unpack
from sim.engine.systems import build
from sim.parameters import Parameters, canonical_values, parse_point, point_id
from tests.engine_motion.points import chute_point, energy_residual, series_of

#: A block on a plane that does not shake: a sphere that cannot roll.
BLOCK = {
    **{"system": "conveyor", "depth": 1 / 9, "cell": 3, "rotation": False},
    **{"amplitude": 0, "amplitude_along": 0, "law": "spring_dashpot", "restitution": 0.3},
    **{"stiffness": 1000, "initial_agitation": 0, "transient": 24, "average": 4},
}

#: Steps and ramps of the angle.
COURSES = st.lists(
    st.tuples(st.integers(0, 40), st.floats(0, 80)), min_size=2, max_size=6, unique_by=lambda x: x
).map(lambda pairs: [list(pair) for pair in sorted(pairs, key=lambda pair: pair[0])])


def flow(**values) -> Parameters:
    """A small flow of spheres on bumps that starts fast on a steep plane."""
    small = {"depth": 2, "cell": 4, "law": "spring_dashpot", "stiffness": 1000, "average": 4}
    return chute_point(**small | values)


@given(COURSES)
def test_an_angle_is_linear_between_times_and_the_later_one_of_two_at_one_time(course):
    times = [time for time, _ in course]
    if any(first == third for first, third in zip(times, times[2:], strict=False)):
        return
    p = chute_point(schedule={"angle": course})
    assert p.angle == pytest.approx(course[-1][1]) and parse_point(canonical_values(p), "") == p
    tilt, unit = tilt_of(p, p.sample_steps), p.sample_steps * p.samples_in(1)
    for time in (*times, *np.arange(0, 42, 2.5)):
        angle, along, upward = tilt_after(tilt, time * unit)
        later = time + 1e-9 if time in times else time
        assert angle == pytest.approx(np.interp(later, *zip(*course, strict=True)), abs=1e-5)
        slope = np.radians(angle)
        expected = p.gravity * np.sin(slope), -p.gravity * np.cos(slope)
        assert (along, upward) == pytest.approx(expected)


@pytest.mark.long  # whose loop is compiled for it alone
@pytest.mark.parametrize("friction", [0.3, 0.4])
def test_a_block_slides_from_where_the_tangent_is_the_friction_to_its_rest(friction):
    """Its velocity is that of a body under gravity and friction, tilted up and down again."""
    course = [[0, 10], [2, 10], [12, 25], [24, 0]]
    p = parse_point(BLOCK | {"friction": friction, "schedule": {"angle": course}}, "block")
    series = series_of(p)
    time, velocity = np.linspace(0, 28, 28001), [0.0]
    slope = np.radians(np.interp(time, *zip(*course, strict=True)))
    pull = p.gravity * (np.sin(slope) - friction * np.cos(slope)) * (time[1] * p.time_unit)
    for gain in pull:
        velocity.append(max(0.0, velocity[-1] + gain))
    found, ends = series["mean_velocity"], (np.arange(28 * 20) + 1) / 20
    on_plane = ends > 3
    expected = np.interp(ends - 0.025, time, velocity[1:])
    assert found[on_plane] == pytest.approx(expected[on_plane], abs=2e-3 * max(velocity))
    critical = np.degrees(np.arctan(friction))
    angles = series["angle_now"]
    first = np.argmax(on_plane & (found > 1e-3 * found.max()))
    assert angles[first] == pytest.approx(critical, abs=1.0) and angles[first] > critical
    assert angles[np.argmax(found)] == pytest.approx(critical, abs=0.1)
    assert np.abs(found[-40:]).max() < 1e-4 * found.max()


def test_a_sudden_change_is_a_flow_that_starts_from_the_end_of_another():
    """To the last bit: time counts from the start of the flow, and gravity is that of the angle."""
    one = build(flow(schedule={"angle": [[0, 27], [2, 27], [2, 21]]}, transient=2), 0)
    before, after = (build(flow(angle=angle, transient=2), 0) for angle in (27, 21))
    for _ in range(before.parameters.transient_samples):
        assert one.advance()["mean_velocity"] == before.advance()["mean_velocity"]
    after.take_over(before)
    assert after.loop.step[0] == 0
    for _ in range(8):
        first, second = one.advance(), after.advance()
        assert first["mean_velocity"] == second["mean_velocity"] and first["angle_now"] == 21
    for name, values in one.snapshot().items():
        assert np.array_equal(values, after.snapshot()[name]), name
    # Started in turn, it counts from 0 again.
    again = build(one.parameters, 0)
    again.take_over(after)
    assert again.advance()["angle_now"] == 27


ROCKED = {"angle": [[0, 20], [3, 60], [3, 5], [6, 40], [8, 10]]}


@pytest.mark.parametrize("system", ["chute", pytest.param("conveyor", marks=pytest.mark.long)])
def test_the_work_of_turning_gravity_closes_the_ledger(system):
    long = {"system": system, "schedule": ROCKED, "transient": 8, "steps_per_collision": 100}
    long |= {"initial_velocity": 0}
    values = flow().model_dump(include={"depth", "cell", "law", "stiffness"})
    point = parse_point(values | long | {"average": 4}, "rocked")
    system = build(point, 0)
    series = series_of(point)
    missing = abs(energy_residual(series, system.ledger))
    assert missing < 2e-3
    terms = {name: sign for name, sign in system.ledger.terms.items() if name != "tilt_work"}
    without = energy_residual(series, system.ledger._replace(terms=terms))
    assert abs(without) > 5 * missing


def test_a_flow_goes_on_from_a_state_amid_its_schedule():
    point = flow(schedule=ROCKED, transient=8)
    system, other = build(point, 0), build(point, 0)
    for _ in range(10):
        system.advance()
    state = flatten({name: getattr(system, name) for name in system.state_names})
    structure = {name: getattr(other, name) for name in other.state_names}
    for name, value in refill(structure, unpack(pack(state))).items():
        setattr(other, name, value)
    for _ in range(4):
        assert system.advance() == other.advance()


def test_a_run_file_has_the_angle_and_is_judged_after_the_last_change(tmp_path):
    point = flow(schedule={"angle": [[0, 24], [2, 0]]}, transient=3)
    assert "-schedule-angle-0-24-2-0-" in point_id(point)
    assert run_point(point, tmp_path / "run.nc", quiet=True) == 0
    with netCDF4.Dataset(tmp_path / "run.nc") as file:
        time = file["time"][:] / point.time_unit
        expected = np.interp(time, [0, 2], [24, 0])
        assert file["angle_now"].units == "degree"
        assert np.allclose(file["angle_now"][0], expected, atol=0.1)
        assert file["average_start"][0] / point.time_unit == pytest.approx(3, abs=0.1)
        assert "tilt_power" in file.variables and file["tilt_power"][0] == 0
