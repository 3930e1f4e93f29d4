"""The package in Python: runs without files, and flows on their way."""

import subprocess
import sys
import tempfile

import numpy as np
import pytest

import sim
from tests.made.processes import ROOT

BELT = {"system": "belt", "beads": 10, "width": 5, "progress": False}
CHUTE = {"system": "chute", "depth": 1.5, "cell": 4, "progress": False}
SHORT = {"transient": 1, "average": 2}


@pytest.fixture(scope="module", params=[BELT, CHUTE], ids=["belt", "chute"])
def given(request):
    return request.param


@pytest.fixture(scope="module")
def run(given):
    return sim.simulate(**given, **SHORT)


@pytest.fixture(scope="module")
def flow(given):
    silent = {name: value for name, value in given.items() if name != "progress"}
    return sim.Flow(**silent).run(1, progress=False).run(2, progress=False)


def test_a_run_is_told_in_full_with_units(run):
    assert run.attrs["status"] == "completed"
    assert run.velocity.units == "m s-1" and run.time.units == "s"
    assert run.sizes["replicate"] == 1 and run.sizes["particle"] == int(run.particles)
    assert run.attrs["command"].startswith(f"talus.simulate('{run.attrs['system']}', ")
    for name in run.data_vars:
        assert "long_name" in run[name].attrs, name


def test_a_run_leaves_nothing_on_the_disk(given, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    sim.simulate(**given, **SHORT)
    assert list(tmp_path.iterdir()) == []


def test_a_flow_moves_as_the_run_does(flow, run):
    assert np.array_equal(flow.series.mean_velocity, run.mean_velocity[0])
    assert flow.time == pytest.approx(float(run.time[-1]))
    # Paths are kept in single precision.
    assert np.array_equal(np.float32(flow.positions), np.float32(run.path[0, 0]))


def test_a_flow_tells_its_particles(flow, run):
    number, axes = run.sizes["particle"], run.sizes["axis"]
    assert flow.positions.shape == flow.velocities.shape == (number, axes)
    assert flow.spins.shape == (number, 3 if axes == 3 else 0)
    assert np.array_equal(flow.radii, run.radius[0])
    held = flow.particles
    assert held.position.units == "m" and held.particle_velocity.units == "m s-1"
    assert held.time == flow.time and list(held.axis) == list(run.axis)
    assert repr(flow).startswith(f"<Flow {flow.parameters.system}-")


def test_a_flow_that_blows_up_says_why():
    with pytest.raises(sim.BlowUp, match=r"overlap .* while the bed settles"):
        sim.Flow("belt", beads=10, width=5, frequency=80, overlap_limit=1e-6)
    flow = sim.Flow(depth=1.5, cell=4, overlap_limit=1e-4)
    with pytest.raises(sim.BlowUp, match="overlap"):
        flow.run(5, progress=False)


SIX = {"depth": 1.5, "cell": 4, "transient": 1, "average": 2, "replicates": 6, "progress": False}


def test_a_run_without_a_replicate_that_completed_is_no_number():
    with pytest.raises(sim.BlowUp, match=r"6 of 6 replicates .*; at depth 1\.5, .* mass 1\.49"):
        sim.simulate(**SIX, overlap_limit=1e-4)
    with pytest.warns(UserWarning, match="6 of 6 replicates failed"):
        run = sim.simulate(**SIX, overlap_limit=1e-4, keep=True)
    assert run.attrs["status"] == "failed" and run.position.notnull().all()


def test_what_a_failed_replicate_measured_is_in_no_mean(caplog):
    limit = float(sim.simulate(**SIX).max_overlap.median())
    with pytest.warns(UserWarning, match="[1-5] of 6 replicates failed"):
        run = sim.simulate(**SIX, overlap_limit=limit)
    assert "run.nc" not in caplog.text
    is_failed = run.status == "failed"
    failed, whole = run.where(is_failed, drop=True), run.where(~is_failed, drop=True)
    for name in ("mean_velocity", "mass_flux", "velocity_profile", "base_normal", "velocity"):
        assert failed[name].isnull().all() and whole[name].notnull().any(), name
    assert (failed.steps > 0).all() and failed.max_overlap.notnull().all()
    assert run.mass_flux.units == "kg m-1 s-1"
    with pytest.warns(UserWarning, match="[1-5] of 6 replicates failed"):
        kept = sim.simulate(**SIX, overlap_limit=limit, keep=True)
    assert kept.mass_flux.where(is_failed).count() > 0


def test_many_short_calls_go_on_for_their_sum():
    flow = sim.Flow("belt", beads=3, width=5)
    interval = flow.parameters.sample_steps * flow.parameters.time_step
    asked = 0.0
    for part in (0.3, 0.7, 1.4, 0.2) * 10:
        flow.run(part * interval / flow.parameters.time_unit, progress=False)
        asked += part * interval
        assert abs(flow.time - asked) <= 0.51 * interval
    assert flow.series.sizes["time"] == 26


def motionless(duration):
    sim.Flow("belt", beads=3).run(duration)


def test_numbers_of_numpy_are_numbers():
    flow = sim.Flow("belt", beads=np.int64(3), replicate=np.int64(1), frequency=np.float32(20))
    assert flow.parameters == sim.Flow("belt", beads=3, frequency=20).parameters
    assert flow.run(np.float64(1), progress=False).time > 0


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: sim.simulate(friction=-1), "simulate: friction: got -1; allowed: a number >= 0"),
        (lambda: sim.simulate("bolt"), "simulate: system: got 'bolt'; did you mean belt?"),
        (
            lambda: sim.simulate("belt", friction=0.3),
            "simulate: friction: unknown key, got 0.3; friction is a parameter of the chute and",
        ),
        (
            lambda: sim.simulate("belt", mu=0.3),
            "simulate: mu: unknown key, got 0.3; did you mean friction? friction is a parameter of",
        ),
        (
            lambda: sim.simulate(μ=0.3),
            "simulate: μ: unknown key, got 0.3; did you mean friction? allowed: ",
        ),
        (
            lambda: sim.simulate("belt", frequency="30 kg"),
            "simulate: frequency: got '30 kg'; allowed: a number > 0, in Hz, or with a unit of its",
        ),
        (
            lambda: sim.simulate(friction="0.3 "),
            "simulate: friction: got '0.3 '; allowed: a number >= 0, without quotes",
        ),
        (lambda: sim.Flow("belt", beats=9), "Flow: beats: unknown key, got 9; did you mean"),
        (lambda: sim.Flow(replicate=-1), "Flow: replicate: got -1; allowed: an integer >= 0"),
        (lambda: sim.Flow(replicate="1"), "Flow: replicate: got '1'; allowed: an integer >= 0"),
        (lambda: sim.Flow(replicate=True), "Flow: replicate: got true; allowed: an integer >= 0"),
        (lambda: motionless(0), "run: duration: got 0; allowed: a number > 0"),
        (lambda: motionless("1"), "run: duration: got '1'; allowed: a number > 0"),
        (lambda: motionless(True), "run: duration: got true; allowed: a number > 0"),
        (lambda: motionless(1e300), "run: duration: got 1e+300; allowed: a number > 0 and <= "),
        (lambda: sim.points(None), "points: study: got nothing; allowed: the path of a study"),
        (lambda: sim.load(None), "load: results: got nothing; allowed: the path of a study's"),
        (lambda: sim.points({"study": "x"}), "points: series: got nothing; allowed: "),
        (lambda: sim.points("none.yaml"), "none.yaml: no such file"),
        (lambda: sim.load("nowhere"), "nowhere: no such dataset"),
    ],
)
def test_mistakes_are_one_line(call, message):
    with pytest.raises(sim.InputError) as raised:
        call()
    assert str(raised.value).startswith(message) and "\n" not in str(raised.value)


def test_points_of_a_study_are_a_table():
    points = sim.points(ROOT / "config" / "first.yaml")
    assert len(points) == 9 and points.index.name == "point"
    assert set(points.friction) == {0.4, 0.5, 0.6} and (points.core_seconds > 0).all()
    assert all(series == ("friction",) for series in points.series)


def test_importing_the_package_loads_no_library():
    code = "import sys, sim; print(*sys.modules)"
    loaded = subprocess.check_output([sys.executable, "-c", code], cwd=ROOT, text=True).split()
    assert not {"numpy", "pydantic", "yaml", "numba", "xarray"} & set(loaded)
    assert set(dir(sim)) == set(sim.__all__)
    with pytest.raises(AttributeError, match="no attribute 'simulation'"):
        sim.simulation  # noqa: B018
