"""What a law may do besides: roll, reach beyond contact, and remember vectors that turn with it.

Motions and flows need the law of ``tests/made/able.py`` in their process, which one test starts.
"""

import os
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

import sim
from sim.base.errors import InputError
from sim.engine.compile import kernel
from sim.engine.contact import Partners, law_of
from sim.engine.contact.friction import contact_force, memory_size
from sim.engine.contact.functions import PartnerLaw, RollingLaw
from sim.engine.dynamics.spheres import stored_in_spheres
from sim.engine.replicate import Replicate
from sim.engine.states import pack, unpack
from sim.engine.systems import build, leap_frog
from sim.parameters import parse_point
from sim.parameters.laws import LAW
from tests.conformance import names_of
from tests.engine.reference.chute import Chute, Spheres, run
from tests.engine.reference.laws import Contact, FunctionLaw
from tests.engine_motion.helpers import GRAVITY, MASS, RADIUS
from tests.engine_motion.motion import SphereMotion
from tests.engine_motion.points import energy_residual, series_of
from tests.made.processes import HANG, ROOT, in_process, restore_plugins

FILE, HERTZ = ROOT / "tests" / "made" / "able.py", "docs/examples/hertz_mindlin.py"

#: Everything that the law can do, at once.
ALL = {"side_damping": 50, "rolling_arm": 0.05, "bridge_pull": 3, "bridge_length": 0.05}

IS_HERE = "able" in names_of(LAW)


def moving(test):
    """Mark a test of motions or flows."""
    return pytest.mark.long(pytest.mark.skipif(not IS_HERE, reason="started by another test")(test))


def point_of(**values):
    """Return a point of the law."""
    given = {"system": "chute", "law": "able", "steps_per_collision": 400}
    return parse_point(given | values, "test")


def law_for(point, friction=0.5, **changes) -> NamedTuple:
    """Return the numbers of the law, some of them changed."""
    return law_of(point, Partners(friction, 0.5 * MASS, point.time_step))._replace(**changes)


@kernel
def one_step(law, overlap, approach, normal, slip, memory):
    """Advance a single contact."""
    return contact_force(law, overlap, approach, normal, slip, memory)


def check_contact(name: str) -> None:
    """Compare a contact that turns, slips and rolls with the reference and with its mirror image.

    Then its partners go round each other as one body.
    """
    rng, point = np.random.default_rng(4), point_of(law=name, **ALL if name == "able" else {})
    numbers, option = law_for(point), point.option("law")
    reference, contact, stuck = FunctionLaw.of(point, numbers), Contact(), 0
    first = 6 if option.rolls else 0
    turning = 3 + first + 3 * option.turns

    def bundle(turn) -> NamedTuple:
        given = numbers, 2e-4, 1e-6
        return RollingLaw(*given, tuple(turn)) if option.rolls else PartnerLaw(*given)

    memory = mirrored = (0.0,) * memory_size(type(numbers))
    normal, before = np.array([0.0, 0.0, 1.0]), 0.0
    for k in range(400):
        is_rigid = k >= 300
        normal = normal + 0.02 * rng.normal(size=3)
        normal /= np.linalg.norm(normal)
        overlap = 3e-5 * (1 + 0.9 * np.sin(0.05 * min(k, 300)))
        approach, before = overlap - before, overlap
        slip, turn = (not is_rigid) * rng.normal(size=(2, 3)) * [[1e-6], [1e-4]]
        slip += (not is_rigid) * 3e-6 * np.sin(0.2 * k) * np.array([0.6, 0.8, 0.0])
        slip -= (slip @ normal) * normal
        old = memory
        force, along, memory, _ = one_step(
            bundle(turn),
            *(overlap, approach, tuple(normal), tuple(slip), memory),
        )
        mirror_force, _, mirrored, _ = one_step(
            bundle(-turn),
            *(overlap, approach, tuple(-normal), tuple(-slip), mirrored),
        )
        assert mirror_force == force
        assert mirrored == (*(-one for one in memory[:turning]), *memory[turning:])
        moved = slip - approach * normal
        expected, shear, contact = reference.update(
            contact, overlap, normal, moved, turn, 2e-4, 1e-6
        )
        assert force == pytest.approx(expected, rel=1e-9)
        assert along == pytest.approx(tuple(shear), rel=1e-8, abs=1e-12)
        if option.rolls:
            assert memory[3:6] == pytest.approx(tuple(contact.torque), rel=1e-8, abs=1e-16)
        if k > 300:
            for part in (0, *range(first or 3, turning, 3)):
                kept, size = (np.linalg.norm(one[part : part + 3]) for one in (old, memory))
                assert size == pytest.approx(kept) and size > 0
        stuck += np.linalg.norm(along) < 0.97 * numbers.friction * abs(force)
    assert 20 < stuck < 380


@pytest.mark.skipif(IS_HERE, reason="it starts a process with the law")
@pytest.mark.parametrize(
    ("file", "changes"),
    [
        ("tests/made/able.py", {}),
        pytest.param("docs/examples/rolling.py", {}, marks=pytest.mark.long),
        (HERTZ, {"    remembers=1,\n": "", "(drag,), lost": "(drag, 0.0, 2.0, drag), lost"}),
        (HERTZ, {"remembers=1": "remembers=0", "(drag,), lost": "(), lost", "memory[0]": "drag"}),
    ],
)
def test_a_compiled_law_is_the_function_of_its_file(file, changes, tmp_path):
    """Whatever it remembers: vectors, four numbers as it does not say how many, or nothing."""
    path = tmp_path / Path(file).name
    text = (ROOT / file).read_text()
    for right, other in changes.items():
        assert right in text
        text = text.replace(right, other)
    path.write_text(text)
    lines = f"import sim; sim.load_plugins({path.name!r})\n"
    lines += "from tests.conformance.test_abilities import check_contact\n"
    in_process(tmp_path, f"{lines}check_contact({path.stem!r})")


@pytest.mark.skipif(IS_HERE, reason="it loads the law anew")
def test_a_cell_is_as_wide_as_the_law_reaches(tmp_path):
    wrong = tmp_path / "wrong.py"
    wrong.write_text(FILE.read_text().replace("return 1.2 *", "return -1 *"))
    given = {"bridge_length": 0.501, "cell": 3.2}
    for file, message in (
        (
            FILE,
            "cell: got 3.2; allowed: at least twice the .* \\+ twice the reach of the law = 3.2",
        ),
        (wrong, "law able: ValueError: it reaches -0.000501 m beyond contact"),
    ):
        with restore_plugins():
            sim.load_plugins(file)
            with pytest.raises(InputError, match=message):
                point_of(**given)
    with restore_plugins():
        sim.load_plugins(FILE)
        assert point_of(**given | {"bridge_length": 0.49}).law_reach == pytest.approx(0.588e-3)


def on_plane(law, point, slides=0.0, spins=0.0, slope=0.0) -> SphereMotion:
    """Return a sphere that rolls along x and spins about z, and presses the plane as it rests."""
    weight = GRAVITY / np.hypot(1, slope)
    return SphereMotion(
        [[0.0, 0.0, RADIUS - MASS * weight / law.stiffness]],
        [[slides, 0.0, 0.0]],
        [[0.0, slides / RADIUS, spins]],
        law=law,
        time_step=point.time_step,
        gravity=(float(slope * weight), 0.0, -float(weight)),
        reach=point.law_reach,
    )


def apart(law, point, partner, speed) -> SphereMotion:
    """Return spheres out of reach of each other, or one of the plane, which approach."""
    heights = [RADIUS] if partner == "plane" else [60 * RADIUS, 62 * RADIUS]
    speeds = [0.0] if partner == "plane" else [0.5 * speed, 0.5 * speed]
    heights[-1] += 1.3 * law.length
    speeds[-1] -= speed
    place, moves = np.zeros((2, len(heights), 3))
    place[:, 2], moves[:, 2] = heights, speeds
    options = {"law": law, "time_step": point.time_step, "reach": point.law_reach}
    return SphereMotion(place, moves, **options)


def gap_of(motion, partner) -> float:
    """Return the gap of the partners (m), negative where they overlap."""
    heights = motion.position[:, 2]
    return heights[0] - RADIUS if partner == "plane" else heights[1] - heights[0] - 2 * RADIUS


def cluster(law, point, height=60 * RADIUS, **options) -> SphereMotion:
    """Return seven spheres of unlike sizes, one amid those it touches, which move and spin."""
    rng = np.random.default_rng(8)
    size = RADIUS * rng.uniform(0.8, 1.0, 7)
    ways = np.vstack([np.zeros(3), np.eye(3), -np.eye(3)])
    place = 0.999 * (size + size[0])[:, None] * ways
    return SphereMotion(
        place + np.array([0.0, 0.0, height + 2 * RADIUS]),
        0.1 * rng.normal(size=(7, 3)),
        200 * rng.normal(size=(7, 3)),
        law=law,
        radius=size,
        mass=MASS * (size / RADIUS) ** 3,
        time_step=point.time_step,
        reach=point.law_reach,
        **options,
    )


@moving
def test_a_sphere_that_resists_rolling_stops_as_a_constant_torque_stops_it():
    """With the torque b m g and the inertia 7/5 m r² the deceleration is 5/7 g b/r."""
    point, share, speed = point_of(), 0.1, 0.1
    one = on_plane(law_for(point, arm=share * RADIUS), point, slides=speed)
    slows = 5 / 7 * GRAVITY * share
    time = one.run(round(0.5 * speed / slows / point.time_step)).flow.step[0] * point.time_step
    assert one.velocity[0, 0] == pytest.approx(speed - slows * time, rel=3e-3)
    assert one.spin[0, 1] * RADIUS == pytest.approx(one.velocity[0, 0], rel=1e-2)
    one.run(3 * round(time / point.time_step))
    assert one.position[0, 0] == pytest.approx(0.5 * speed**2 / slows, rel=0.02)
    assert abs(one.velocity[0, 0]) < 0.02 * speed


@pytest.mark.parametrize("share", [0.45, 2.0])
@moving
def test_a_sphere_on_a_slope_stays_where_its_arm_is_longer_than_the_slope_is_steep(share):
    point, slope, steps = point_of(), 0.1, 100_000
    one = on_plane(law_for(point, arm=slope / share * RADIUS), point, slope=slope).run(steps)
    time, weight = steps * point.time_step, GRAVITY / np.hypot(1, slope)
    rolls = 5 / 7 * weight * (slope - slope / share)
    if share > 1:
        assert one.velocity[0, 0] == pytest.approx(rolls * time, rel=1e-2)
    else:
        assert abs(one.position[0, 0]) < 0.02 * abs(rolls) * time**2


@moving
def test_a_sphere_that_spins_about_the_vertical_is_stopped_by_its_twisting():
    point, arm, spin = point_of(), 0.1 * RADIUS, 50.0
    one = on_plane(law_for(point, arm=arm), point, spins=spin)
    slows = arm * GRAVITY / (0.4 * RADIUS**2)
    steps = round(0.5 * spin / slows / point.time_step)
    assert one.run(steps).spin[0] == pytest.approx(
        [0, 0, spin - slows * steps * point.time_step], rel=1e-2, abs=1e-9
    )
    assert np.abs(one.run(3 * steps).spin).max() < 0.05 * spin


@pytest.mark.parametrize("partner", ["sphere", "plane"])
@moving
def test_a_bridge_pulls_with_its_force_to_its_length_and_takes_their_product(partner):
    """It begins with the contact; spheres that are too slow stay together."""
    point = point_of(**ALL)
    mass = MASS if partner == "plane" else 0.5 * MASS
    law = law_for(point, damping=0.0)
    least = (2 * law.pull * law.length / mass) ** 0.5
    for speed in (0.9 * least, 1.5 * least):
        motion, gaps, forces, counts = apart(law, point, partner, speed), [], [], []
        for _ in range(9000):
            motion.run(1)
            gaps.append(gap_of(motion, partner))
            forces.append(motion.force[-1, 2])
            counts.append(motion.flow.sums[leap_frog.CONTACTS])
        # The force is that of the step before it moves.
        gaps, forces = np.array(gaps[:-1]), np.array(forces[1:])
        met = np.argmax(gaps < 0)
        assert not forces[: met - 1].any() and counts[met - 1] == 0
        near = (gaps > 0) & (np.arange(gaps.size) > met)
        bridged = near & (gaps < 0.999 * law.length)
        assert bridged.sum() > 50 and np.allclose(forces[bridged], -law.pull, rtol=1e-12)
        assert not forces[near & (gaps > law.length)].any()
        if speed < least:
            assert gaps[met:].max() < law.length and (np.diff(np.sign(gaps)) != 0).sum() > 2
        else:
            away = motion.velocity[-1, 2] - (motion.velocity[0, 2] if partner != "plane" else 0)
            assert away == pytest.approx((speed**2 - least**2) ** 0.5, rel=2e-3)
            lost = motion.flow.sums[leap_frog.NORMAL_LOSS]
            assert lost == pytest.approx(law.pull * law.length, rel=3e-3)


@pytest.mark.parametrize("threads", [1, 2])
@moving
def test_momenta_are_kept_and_energy_is_lost_as_the_law_says(threads):
    """Angular momentum without tangential forces, whose arms are radii, not branches."""
    point = point_of(**ALL)
    for changes in ({"tangential": 1e-9, "shear": 0.0}, {}):
        law = law_for(point, **changes)
        one = cluster(law, point, threads=threads)
        start, turning, energy = one.momentum(), one.angular_momentum(), one.energy()
        scale = np.abs(one.mass[:, None] * one.velocity).max()
        for _ in range(20):
            one.run(200)
            assert np.abs(one.momentum() - start).max() < 1e-12 * scale
            if changes:
                assert one.angular_momentum() == pytest.approx(turning, abs=1e-9 * scale * RADIUS)
        memory = one.memory[one.flow.step[0] % 2]
        stored, _ = stored_in_spheres(law, one.spheres, one.pairs, memory, one.time_step)
        losses = one.flow.sums[[leap_frog.NORMAL_LOSS, leap_frog.FRICTION_WORK]].sum() + stored
        assert energy - one.energy() == pytest.approx(losses, abs=0.02 * energy)
        assert energy - one.energy() > 0.1 * energy


@moving
def test_a_few_spheres_move_as_those_of_the_reference():
    point = point_of(**ALL)
    law = law_for(point)
    given = {"gravity": (2.0, 0.0, -9.0), "height": 1.5 * RADIUS}
    one, other = cluster(law, point, **given), cluster(law, point, **given)
    spheres = Spheres(*map(np.array, (other.position, other.velocity, other.spin)), None, MASS)
    spheres.radius, spheres.mass = other.spheres.radius.copy(), np.array(other.mass)
    reference = FunctionLaw.of(point, law)
    chute = Chute(reference, reference, None, given["gravity"])
    spheres = run(spheres, chute, point.time_step, 600)
    one.run(600)
    assert len(spheres.contacts) > 5
    for found, expected in (
        (one.position, spheres.position),
        (one.velocity, spheres.velocity),
        (one.spin, spheres.spin),
    ):
        assert found == pytest.approx(expected, abs=1e-8 * np.abs(expected).max())


@pytest.mark.parametrize(
    "values",
    [
        {"bumps": 0.6, "bump_coverage": 0.3, "stress_profiles": True, "diameter_spread": 0.2},
        {"threads": 2},
        {"system": "conveyor", "shape": "disc", "bumps": 1},
    ],
)
@moving
def test_flows_keep_their_energy_and_go_on_from_their_state(values):
    few = {"depth": 3, "cell": 5, "transient": 3, "average": 7, "steps_per_collision": 40}
    point = point_of(**ALL | few | values)
    series, replicate = series_of(point), Replicate(point, 0)
    assert abs(energy_residual(series, build(point, 0).ledger)) < 2e-2
    system = replicate.system
    for number in range(6):
        sample = system.sample(1, profiles=True)
        assert all(sample.first()[name] == series[name][number] for name in system.series)
        if number == 2:
            replicate.recorder.take(sample)
            system = Replicate.from_state(point, 0, unpack(pack(replicate.state()))).system
    contacts = system.current_contacts(2000)
    forces = contacts.force[: int(contacts.number[0])]
    assert len(forces) > 2 and (np.linalg.norm(forces, axis=1) > 0).all()


@pytest.mark.long
@pytest.mark.skipif(IS_HERE, reason="this is that process")
def test_a_law_with_all_abilities_moves_particles_as_it_says():
    """In a process with the plug-in, with what holds for every law."""
    files = [__file__, str(ROOT / "tests" / "conformance" / "test_laws.py")]
    every = [sys.executable, "-m", "pytest", "-q", "-m", "", "-k", "able or abilities", *files]
    done = subprocess.run(
        every, cwd=ROOT, env=os.environ | {"TALUS_PLUGINS": str(FILE)}, timeout=HANG
    )
    assert done.returncode == 0
