"""A replicate that blows up is tried once more with half the time step; what fails can be shown."""

import netCDF4
import numpy as np
import pytest

from sim.__main__ import main
from sim.engine.dynamics.status import BlowUp
from sim.engine.replicate import Replicate
from sim.engine.run import BLOW_UP_CODE, run_point
from sim.engine.systems import build
from sim.engine.systems.belt import Belt
from sim.engine.systems.chute import Chute
from sim.parameters import load_point
from tests.engine_motion.points import belt_point, chute_point

CHUTE = chute_point(depth=1.24, cell=4, transient=2, average=4, replicates=2)
BELT = belt_point(beads=12, width=5, transient=1, average=2, replicates=2)
HOPELESS = chute_point(depth=1.24, cell=4, transient=2, average=4, replicates=2, overlap_limit=1e-9)


class NoKeeper:
    """Keeps no states."""

    def offer(self, replicate: Replicate) -> None:
        pass

    def check_signals(self) -> None:
        pass

    def keep(self, replicate: Replicate) -> None:
        pass


def run(replicate: Replicate):
    """Run a replicate to its end without anyone watching."""
    return replicate.run(lambda steps: None, NoKeeper())


def blow_up_of_whole_steps(monkeypatch, system: type, after: int = 3) -> None:
    """Make a system blow up at a sample unless its time step is divided."""
    sample = system.sample

    def failing(self, most, profiles):
        if self.sample_steps == self.parameters.sample_steps:
            self.taken = getattr(self, "taken", 0) + 1
            if self.taken > after:
                raise BlowUp("an overlap too large at step 7")
            most = 1
        return sample(self, most, profiles)

    monkeypatch.setattr(system, "sample", failing)


@pytest.mark.parametrize(("point", "system"), [(CHUTE, Chute), (BELT, Belt)])
def test_half_the_step_is_half_the_step_from_the_same_start(point, system, monkeypatch, tmp_path):
    blow_up_of_whole_steps(monkeypatch, system)
    assert run_point(point, tmp_path / "run.nc", quiet=True) == 0
    assert {path.name for path in tmp_path.iterdir()} == {"run.nc", ".run.nc.state"}
    with netCDF4.Dataset(tmp_path / "run.nc") as file:
        file.set_auto_mask(False)
        assert file.status == "completed" and list(file["reason"][:]) == ["", ""]
        assert (file["time_step_used"][:] == point.time_step / 2).all()
        assert (file["steps"][:] == 2 * point.steps).all()
        assert file["time"].size == point.transient_samples + point.average_samples
        assert float(file["time"][-1]) == pytest.approx(point.steps * point.time_step, rel=1e-12)
        assert np.isfinite(file["mean_velocity"][:]).all()


# Beds that settle with different steps come to rest in different places.
@pytest.mark.parametrize(("point", "tolerance"), [(CHUTE, 0.02), (BELT, 0.2)])
def test_a_divided_step_samples_the_same_motion(point, tolerance):
    whole, half = build(point, 0), build(point, 0, 2)
    for system in (whole, half):
        system.settle()
    assert half.time_step == whole.time_step / 2
    for _ in range(2):
        one, other = whole.advance(), half.advance()
        assert other["mean_velocity"] == pytest.approx(one["mean_velocity"], rel=tolerance)
        assert other["height_of_mass"] == pytest.approx(one["height_of_mass"], rel=tolerance)
    if point.system == "belt":
        assert other["belt_phase"] == pytest.approx(one["belt_phase"], abs=1e-12)


def test_one_failure_leaves_the_other_replicates_alone(monkeypatch):
    expected = run(Replicate(CHUTE, 1)).scalars["velocity"]
    blow_up_of_whole_steps(monkeypatch, Chute, after=10**9)
    record = run(Replicate(CHUTE, 1))
    assert record.scalars["velocity"] == expected
    assert record.scalars["time_step_used"] == CHUTE.time_step


def test_a_second_blow_up_is_final_and_names_both(caplog):
    record = run(Replicate(HOPELESS, 0))
    first, second = record.scalars["reason"].split("; with half the time step: ")
    assert "overlap_limit at step" in first and "overlap_limit at step" in second
    assert record.scalars["time_step_used"] == HOPELESS.time_step / 2
    assert sum("again with half the time step" in line for line in caplog.messages) == 1


def test_a_bed_that_does_not_settle_is_tried_with_half_the_step_too():
    record = run(Replicate(belt_point(beads=100, width=5, stiffness=1.0), 0))
    first, second = record.scalars["reason"].split("; with half the time step: ")
    assert "while the bed settles" in first and "while the bed settles" in second
    assert first != second


def test_progress_counts_no_sample_twice(monkeypatch):
    blow_up_of_whole_steps(monkeypatch, Chute)
    reported = []
    Replicate(CHUTE, 0).run(reported.append, NoKeeper())
    assert sum(reported) == CHUTE.steps


def test_a_failed_run_names_the_command_that_gives_its_point(tmp_path, caplog, capsys):
    output = tmp_path / "run.nc"
    assert run_point(HOPELESS, output, quiet=True) == BLOW_UP_CODE
    (hint,) = (line for line in caplog.messages if "to see the failure again" in line)
    assert main(hint.partition(": python -m sim ")[2].split()) == 0
    path = tmp_path / "point.yaml"
    path.write_text(capsys.readouterr().out)
    assert load_point(path) == HOPELESS
    assert main(["run", str(path), "-o", str(tmp_path / "again.nc"), "--quiet"]) == BLOW_UP_CODE
    with netCDF4.Dataset(output) as one, netCDF4.Dataset(tmp_path / "again.nc") as other:
        assert other["reason"][0] == one["reason"][0]
    names = {path.name for path in tmp_path.iterdir() if not path.name.startswith(".")}
    assert names == {"again.nc", "point.yaml", "run.nc"}
