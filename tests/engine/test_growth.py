"""A run that grows has the bits of one that was long from the start, and computes no more."""

from pathlib import Path

import netCDF4
import numpy as np
import pytest

from sim.engine.replicate import Replicate
from sim.engine.run import read_stored_run, run_point
from sim.engine.stored_run import current_status
from sim.parameters import Parameters
from tests.engine_motion.points import belt_point, chute_point
from tests.golden import CLOCK, contents, digest

CHUTE = chute_point(depth=2, cell=5, transient=5, average=6, replicates=2)
BELT = belt_point(beads=20, width=5, transient=1, average=3, replicates=2)
CONVERGED = {"protocol": "converged", "limit": 8}
OPEN = {
    "corrector_order": 4,
    "corrections": 2,
    "slice_height": 0.5,
    "phase_0_profiles": True,
    "belt_forces": True,
    "fluctuation_profiles": True,
    "phase": 90.0,
}


def with_amounts(point: Parameters, **changes) -> Parameters:
    """Return the same point with other amounts."""
    return point.model_copy(update=changes)


def run_points(path: Path, *points: Parameters) -> Path:
    """Run points into the same file, one after the other."""
    for point in points:
        assert run_point(point, path, quiet=True) == 0
    return path


class SampleCounter:
    """Counts the samples that are computed by ``Replicate.run``."""

    def __init__(self, monkeypatch):
        self.samples = 0
        original = Replicate.run

        def run(replicate, report_steps, keeper, origin):
            def counting(steps):
                self.samples += steps // replicate.parameters.sample_steps
                report_steps(steps)

            return original(replicate, counting, keeper, origin)

        monkeypatch.setattr(Replicate, "run", run)


WAYS = {
    "replicates": (with_amounts(BELT, trajectory=0.5), {"replicates": 3}),
    "limit": (with_amounts(BELT, **CONVERGED), {"limit": 16.0}),
    "readings": (with_amounts(BELT, trajectory=0.5, **OPEN), {"average": 5.0, "replicates": 3}),
    "profiles": (with_amounts(CHUTE, stress_profiles=True), {"average": 11.0, "replicates": 3}),
}


@pytest.mark.parametrize("way", WAYS)
def test_a_run_that_grows_has_the_bits_of_a_long_one(way, tmp_path, monkeypatch):
    point, changes = WAYS[way]
    whole = run_points(tmp_path / "whole.nc", with_amounts(point, **changes))
    path = run_points(tmp_path / "run.nc", point)
    with netCDF4.Dataset(path) as short, netCDF4.Dataset(whole) as long:
        more = long["steps"][:].sum() - short["steps"][:].sum()
        step = point.sample_steps
    counter = SampleCounter(monkeypatch)
    run_points(path, with_amounts(point, **changes))
    assert digest(path) == digest(whole)
    assert counter.samples * step == more > 0


def test_growth_in_several_steps_ends_at_the_same_bits(tmp_path):
    whole = run_points(tmp_path / "whole.nc", with_amounts(BELT, average=5.0, replicates=3))
    path = run_points(
        tmp_path / "run.nc",
        with_amounts(BELT, replicates=1),
        with_amounts(BELT, average=4.0),
        with_amounts(BELT, average=4.0, replicates=3),
        with_amounts(BELT, average=5.0, replicates=1),
    )
    assert digest(path) == digest(whole)


def test_less_than_is_held_is_current(tmp_path):
    path = run_points(tmp_path / "run.nc", BELT, with_amounts(BELT, average=5.0))
    before = path.stat().st_ino
    for wanted in (BELT, with_amounts(BELT, replicates=1), with_amounts(BELT, average=4.0)):
        assert current_status(path, wanted) == "completed"
    run_points(path, BELT)
    assert path.stat().st_ino == before
    for wanted in (with_amounts(BELT, average=6.0), with_amounts(BELT, replicates=3)):
        assert not current_status(path, wanted)


@pytest.mark.parametrize("changes", [{"replicates": 3}, {"average": 5.0}])
def test_without_its_states_a_run_grows_all_the_same(changes, tmp_path, monkeypatch):
    path = run_points(tmp_path / "run.nc", BELT)
    (tmp_path / ".run.nc.state").unlink()
    counter, longer = SampleCounter(monkeypatch), with_amounts(BELT, **changes)
    run_points(path, longer)
    again = 1 if "replicates" in changes else 2
    assert counter.samples == again * longer.longest_samples
    assert digest(path) == digest(run_points(tmp_path / "whole.nc", longer))


def test_states_of_a_longer_run_are_none_of_a_shorter_one(tmp_path, caplog):
    """The run file is gone, and less is wanted: as much is run, no more."""
    run_points(tmp_path / "run.nc", with_amounts(BELT, average=5.0)).unlink()
    path = run_points(tmp_path / "run.nc", BELT)
    assert "longer than is wanted" in caplog.text
    assert digest(path) == digest(run_points(tmp_path / "whole.nc", BELT))


def test_a_replicate_that_failed_stays_failed_and_the_others_go_on(tmp_path, monkeypatch):
    hopeless = chute_point(depth=1.24, cell=4, transient=2, average=4, overlap_limit=1e-9)
    longer = with_amounts(hopeless, average=8.0)
    for point in (hopeless, longer):
        assert run_point(point, tmp_path / "run.nc", quiet=True, record_failure=True) == 0
    run_point(longer, tmp_path / "whole.nc", quiet=True)
    assert digest(tmp_path / "run.nc") == digest(tmp_path / "whole.nc")


def test_what_is_read_from_a_run_file_is_what_was_written(tmp_path):
    path = run_points(tmp_path / "run.nc", BELT, with_amounts(BELT, average=5.0))
    run = read_stored_run(path, BELT)
    assert run.parameters == with_amounts(BELT, average=5.0)
    stored = contents(path)
    for index, record in enumerate(run.records):
        for kind in (record.series, record.profiles, record.tables, record.scalars):
            for name, value in kind.items():
                if name not in CLOCK:
                    np.testing.assert_array_equal(value, stored[name][index], name)
