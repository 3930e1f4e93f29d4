"""Two parameters at the ends of their ranges: each is allowed, so together they make a sound flow.

Or they are refused, or the flow blows up and says so. `make long` searches; a few pairs of numbers
of the chute, for which nothing has to be compiled, are tried every time.
"""

import math
import os
import subprocess
import sys
import typing
from itertools import combinations

import numpy as np
import pytest
from annotated_types import Ge, Gt, Le, Lt
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

from sim.base.errors import InputError
from sim.engine.dynamics.cells import BlowUp
from sim.engine.systems import build
from sim.parameters import SYSTEMS, Parameters, parse_point
from sim.parameters.roles import declarations
from tests.engine_motion.points import energy_residual
from tests.made.processes import ROOT

#: Small flows in narrow cells.
SMALL = {
    "chute": {"depth": 1.5, "cell": 3.5, "transient": 0, "average": 2, "initial_velocity": 2},
    "belt": {"beads": 12, "width": 5, "transient": 0, "average": 1},
    "conveyor": {"depth": 1.5, "cell": 3.5, "transient": 0, "average": 1, "frequency": 60},
}

#: What sets how much is computed or stored, or takes another program or run.
LEFT_OUT = {
    *("system", "seed", "replicates", "protocol", "target", "average", "limit", "transient"),
    *("trajectory", "trajectory_contacts", "start_from", "engine", "ranks", "threads"),
    "initial_state",
    *("settle_velocity_squared", "prior_cycles", "slice_height", "overlap_limit"),
}

#: Particle-steps of a flow at most, and the share of the energy turned over that its ledger may
#: lack. A reading that pushes spheres apart once more, by what the paper rules out, makes energy.
MOST_WORK, MISSING = 3e5, 0.25
MAKES_ENERGY = {"overlap_memory": "reset"}


def ends(system: str, name: str) -> list[typing.Any]:
    """Return the ends of the range of a parameter, or values far away where it has none."""
    field = SYSTEMS[system].model_fields[name]
    if typing.get_origin(field.annotation) is typing.Literal:
        return list(typing.get_args(field.annotation))
    if field.annotation is bool:
        return [False, True]
    usual = getattr(parse_point({"system": system}, "p"), name) or 1
    low, high = 0.1 * usual, 10 * usual
    for bound in field.metadata:
        match bound:
            case Ge(ge=value):
                low = value
            case Gt(gt=value):
                low = value + 0.1 * usual
            case Le(le=value):
                high = value
            case Lt(lt=value):
                high = value - 1e-6 * (value - low)
    whole = field.annotation is int
    return [math.ceil(low), math.floor(high)] if whole else [low, high]


def pairs(system: str, compiled: bool) -> list[dict[str, typing.Any]]:
    """Return all pairs of parameters at the ends of their ranges."""
    declared = declarations(SYSTEMS[system])
    names = [
        name for name, row in declared.items() if name not in LEFT_OUT and compiled >= row.compiled
    ]
    return [
        {one: first, other: second}
        for one, other in combinations(names, 2)
        for first in ends(system, one)
        for second in ends(system, other)
    ]


def read(values: dict[str, typing.Any]) -> Parameters:
    """Return a point that takes little work, unless a rule that joins parameters refuses it."""
    try:
        point = parse_point(values, "p")
    except InputError:
        assume(False)
    assume((point.steps + point.settling_steps) * point.effective_particles < MOST_WORK)
    return point


def touched_images(system) -> int:
    """Return by how many periodic images at most a particle touches another one."""
    if system.parameters.system == "belt":
        place, radius = system.disks.taylor[0].copy(), system.disks.radius
        if system.parameters.obstacle:
            obstacle = system.obstacle
            place = np.column_stack([place, [obstacle.x, obstacle.z]])
            radius = np.append(radius, obstacle.radius)
        lengths = system.box.length[:1]
    else:
        place, radius = system.spheres.position, system.spheres.radius
        # The box of discs is as wide as they need across their plane.
        lengths = system.box.length[: 1 if system.parameters.is_flat else 2]
        fixed = system.spheres.mass == 0
        place, radius = place[:, ~fixed | fixed.any()], radius[~fixed | fixed.any()]
    gap = place[:, :, None] - place[:, None, :]
    reach, count = radius[:, None] + radius, 0
    shifts = np.stack(np.meshgrid(*[[-2, -1, 0, 1, 2]] * len(lengths)), -1).reshape(
        -1, len(lengths)
    )
    for shift in shifts:
        moved = gap.copy()
        for axis, (length, turns) in enumerate(zip(lengths, shift, strict=True)):
            moved[axis] -= length * (np.round(gap[axis] / length) + turns)
        count = count + ((moved**2).sum(axis=0) < reach**2)
    movable = np.append(system.disks.mass, 0) if hasattr(system, "disks") else system.spheres.mass
    movable = movable[: len(radius)] > 0
    count[~movable[:, None] & ~movable] = 0
    np.fill_diagonal(count, np.maximum(np.diagonal(count) - 1, 0))
    return int(np.max(count))


def check(values: dict[str, typing.Any]) -> None:
    """Run a small flow, which is to be finite, to lose no energy, and to meet single images."""
    point = read(values)
    system = build(point, 0)
    samples = []
    try:
        system.settle()
        for _ in range(point.average_samples):
            samples.append(system.advance())
            assert touched_images(system) <= 1
    except BlowUp:
        return
    except InputError as error:
        assert "cell" in str(error)
        return
    series = {name: np.array([one[name] for one in samples]) for name in system.series}
    assert all(np.isfinite(one).all() for one in series.values())
    coarse = "time step" in point.caveat  # the point says that its step is too long
    if not coarse and all(
        getattr(point, name, None) != value for name, value in MAKES_ENERGY.items()
    ):
        turned = sum(series[name][-1] - series[name][0] for name in system.ledger.turnover)
        largest = max(np.ptp(series[name]) for name in system.ledger.terms)
        # Where hardly anything is lost, the residual is compared with what goes to and fro.
        missing = abs(energy_residual(series, system.ledger) * turned) if turned else 0.0
        assert missing <= MISSING * max(abs(turned), largest)


@pytest.mark.parametrize(
    "system",
    ["chute", *(pytest.param(one, marks=pytest.mark.long) for one in ("belt", "conveyor"))],
)
@settings(max_examples=6, derandomize=True, suppress_health_check=list(HealthCheck), deadline=None)
@given(data=st.data())
def test_two_numbers_at_the_ends_of_their_ranges_make_a_sound_flow(system, data):
    pair = data.draw(st.sampled_from(pairs(system, compiled=False)))
    check({"system": system, **SMALL[system], **pair})


@pytest.mark.long
@pytest.mark.parametrize("system", SYSTEMS)
@settings(max_examples=300, suppress_health_check=list(HealthCheck), deadline=None)
@given(data=st.data())
def test_no_pair_of_parameters_at_the_ends_of_their_ranges_clashes(system, data):
    pair = data.draw(st.sampled_from(pairs(system, compiled=True)))
    check({"system": system, **SMALL[system], **pair})


@pytest.mark.long
def test_no_loop_reads_or_writes_beyond_an_array(tmp_path):
    """Code that checks its bounds is not that of others."""
    words = ["-q", "-m", "", "-k", "two_numbers", __file__]
    code = f"""
import pytest
import sim.engine.compile
sim.engine.compile.numba.config.BOUNDSCHECK = True
raise SystemExit(pytest.main({words}))
"""
    settings = {"TALUS_CACHE_DIR": str(tmp_path / "cache")}
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, env=os.environ | settings)
    assert done.returncode == 0
