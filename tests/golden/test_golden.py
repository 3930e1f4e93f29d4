"""The numbers of the golden points, and that together they take every path that makes numbers."""

import os
import platform
import signal
import subprocess
import sys
from typing import Any, Literal, get_args, get_origin

import pytest

from sim.engine.states import TERMINATION_CODE, States
from sim.engine.systems.start import beds
from sim.parameters import SYSTEMS, complete_values
from tests.engine_motion.points import pause_within_samples
from tests.golden import (
    BITS,
    FAILING,
    TOLERANCE,
    VALUES,
    computed,
    contents,
    digest,
    early,
    machine,
    points,
    stored,
    worst_error,
)
from tests.made.processes import ROOT, SHORTER_VECTORS

POINTS = points()

#: Laws and readings that other golden points have as well: only how they meet a plane that moves,
#: or rests, is new, and compiling takes long.
KNOWN_LAWS = {
    "chute_sliding_along_slip",
    "conveyor_hertz",
    "conveyor_hertz_rescaled",
    "conveyor_hertz_of_material",
    "conveyor_drag",
    "conveyor_damped",
    "conveyor_tilted",
    "conveyor_discs_bumps",
    "conveyor_discs_dashpot",
    "conveyor_sliding_as_printed",
    "conveyor_threads_stress",
}


def names(*without: str) -> list[Any]:
    """Return the names of the points but some, those of `KNOWN_LAWS` marked as long."""
    return [
        pytest.param(name, marks=pytest.mark.long) if name in KNOWN_LAWS else name
        for name in POINTS
        if name not in without
    ]


ADVICE = "the numbers of runs have changed: undo that, or raise NUMERICS (docs/architecture.md)"


@pytest.mark.parametrize("name", names())
def test_bits_are_those_recorded_on_the_same_kind_of_machine(name, tmp_path):
    recorded = stored(BITS).get(machine(), {}).get(name)
    found = digest(computed(POINTS[name], tmp_path))
    if recorded:
        assert found == recorded, ADVICE
    else:
        (tmp_path / "again").mkdir()
        assert found == digest(computed(POINTS[name], tmp_path / "again"))


@pytest.mark.parametrize("name", names(*FAILING))
def test_first_samples_are_those_recorded_on_any_machine(name):
    error = worst_error(POINTS[name], early(POINTS[name]), stored(VALUES)[name])
    assert error < TOLERANCE, ADVICE


@pytest.mark.long
@pytest.mark.skipif(platform.machine() != "x86_64", reason="names a processor of another kind")
def test_so_they_are_where_vectors_are_shorter():
    every = [sys.executable, "-m", "pytest", "-q", "-m", "", "-k", "first_samples", __file__]
    done = subprocess.run(every, cwd=ROOT, env=os.environ | SHORTER_VECTORS)
    assert done.returncode == 0


def test_recorded_are_the_points_there_are():
    assert set(stored(VALUES)) == set(POINTS) - set(FAILING)
    # A machine that is not at hand cannot record a point that has been added since.
    assert all(set(bits) <= set(POINTS) for bits in stored(BITS).values())
    assert any(set(bits) == set(POINTS) for bits in stored(BITS).values())


#: Offers of a state, counted over all starts, after which a run is interrupted: soon, and later on.
INTERRUPTED = {6 * 2**number for number in range(12)}


@pytest.mark.parametrize("name", ["chute_threads", "belt_shaken_before", "belt_trajectory"])
def test_a_run_that_goes_on_from_a_checkpoint_has_the_same_bits(name, tmp_path, monkeypatch):
    whole = digest(computed(POINTS[name], tmp_path))
    offers = iter(range(10**6))
    offer = States.offer

    def terminated_now_and_then(self, replicate):
        if next(offers) in INTERRUPTED:
            signal.raise_signal(signal.SIGTERM)
        offer(self, replicate)

    monkeypatch.setattr(States, "offer", terminated_now_and_then)
    pause_within_samples(monkeypatch, POINTS[name])
    folder = tmp_path / "interrupted"
    folder.mkdir()
    path, starts = folder / "run.nc", 0
    while not path.exists():
        # As in a process of its own.
        beds.clear()
        starts += 1
        try:
            computed(POINTS[name], folder)
        except SystemExit as ended:
            assert ended.code == TERMINATION_CODE
    assert starts > 3
    assert digest(path) == whole


def test_a_blow_up_is_retried_in_one_point_of_each_system_and_final_in_another(tmp_path):
    for name in ("chute_retried", "belt_retried", "chute_failed"):
        held = contents(computed(POINTS[name], tmp_path))
        assert (held["time_step_used"] == POINTS[name].time_step / 2).all()
        assert (list(held["status"]) == ["failed"]) == (name in FAILING)


#: What takes a second run; tests/engine/test_replicate.py compares bits.
OF_TWO_RUNS = {"start_from"}

#: Bits of another engine are those of another program.
OF_OTHERS = {"engine", "ranks"}


@pytest.mark.parametrize("system", SYSTEMS)
def test_every_option_and_two_values_of_every_number_occur(system):
    taken = [complete_values(point) for point in POINTS.values() if point.system == system]
    for name, field in SYSTEMS[system].model_fields.items():
        values = {point[name] for point in taken}
        if name in OF_TWO_RUNS | OF_OTHERS:
            continue
        if get_origin(field.annotation) is Literal:
            assert values == set(get_args(field.annotation)), name
        else:
            assert len(values) > 1, f"{name}: no golden point has another value than {values}"
