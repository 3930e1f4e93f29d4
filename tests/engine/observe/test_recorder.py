"""What a replicate leaves behind, recorded from a made-up system."""

from types import SimpleNamespace

import numpy as np
import pytest

from sim.engine.observe.blocks import MAX_BLOCKS
from sim.engine.observe.ledger import Ledger
from sim.engine.observe.profiles import empty_profile
from sim.engine.observe.recorder import Recorder
from sim.engine.observe.regime import Scales
from sim.engine.observe.sums import zero_samples
from sim.engine.systems.replica import Samples

#: Samples of 0.1 s: 4 of transient and 12 to average, or up to 64 of the converged protocol.
LENGTHS = {
    "sample_steps": 1,
    "time_step": 0.1,
    "transient_samples": 4,
    "shortest_samples": 16,
    "target": 0.02,
    "trajectory_samples": 0,
    "trajectory_room": 0,
}
PUBLISHED = SimpleNamespace(protocol="published", longest_samples=16, **LENGTHS)
CONVERGED = SimpleNamespace(protocol="converged", longest_samples=64, **LENGTHS)


class Ramp:
    """A system whose mean velocity is its sample's number, and whose one slice counts samples."""

    series = {
        "mean_velocity": ("m s-1", ""),
        "largest_overlap": ("1", ""),
        "base_normal_force": ("N", ""),
        "base_shear_force": ("N", ""),
        "kinetic_energy": ("J", ""),
        "lost": ("J", ""),
    }
    ledger = Ledger({"kinetic_energy": 1, "lost": 1}, ("lost",), {"lost": "normal_power"})
    mass = 2.0
    weight = (4.0, 100.0)
    profile_height = np.array([0.5])
    scales = Scales(arrested=1e-3, acceleration=0.1, drift=0.1, target=0.02)
    period = 1
    most = 3
    history_profiles = ()

    def __init__(self, parameters, velocity=float):
        self.parameters, self.velocity, self.number = parameters, velocity, 0

    def sample(self, most, profiles):
        first = self.number
        rows = [self.row() for _ in range(min(most, self.most))]
        sums = zero_samples(len(rows), empty_profile(1, 3))
        sums.samples[:], sums.weight[:] = 1.0, 2.0
        sums.moved[:, 0] = 2.0 * np.arange(first + 1, self.number + 1)
        values = {name: [row[name] for row in rows] for name in self.series}
        return Samples(values, (sums,) if profiles else None)

    def row(self):
        self.number += 1
        return {
            "mean_velocity": self.velocity(self.number),
            "largest_overlap": 0.3 if self.number == 2 else 0.1,
            "base_normal_force": 10.0 * self.number,
            "base_shear_force": 4.0,
            "kinetic_energy": 100.0 - self.number,
            "lost": 1.02 * self.number,
        }

    def no_profiles(self):
        return (empty_profile(1, 3),)

    def profiles(self, sums):
        return {
            "velocity_profile": sums[0].velocity(),
            "packing_profile": sums[0].weight / sums[0].samples,
        }

    def tables(self, sums):
        return {"samples": sums[0].samples}

    def trace(self):
        return np.full((3, 1, 3), float(self.number))

    def snapshot(self):
        return {"position": np.full((1, 3), float(self.number))}


def record_ramp(samples: int = 1000, failure: str = "", parameters=PUBLISHED, velocity=float):
    """The record of a ramp (or another velocity) of as many samples, or until its protocol ends."""
    system = Ramp(parameters, velocity)
    recorder = Recorder(system)
    recorder.take_snapshot()
    while recorder.sample_count < samples and not recorder.stop_reason:
        most, profiles = recorder.next_samples()
        recorder.take(system.sample(min(most, samples - recorder.sample_count), profiles))
    recorder.take_snapshot()
    return recorder.finish(failure)


def test_the_course_of_profiles_is_told_block_by_block_where_it_is_asked_for(monkeypatch):
    """Twelve samples of the window, one to a block; before them there are no profiles."""
    assert "block_end" not in record_ramp().tables
    monkeypatch.setattr(Ramp, "history_profiles", ("velocity_profile",))
    tables = record_ramp().tables
    end, course = tables["block_end"], tables["velocity_profile_history"]
    assert end.shape == (MAX_BLOCKS,) and course.shape == (MAX_BLOCKS, 1)
    assert end[:12] == pytest.approx(0.1 * np.arange(5, 17))
    assert course[:12, 0].tolist() == list(range(5, 17))
    assert np.isnan(end[12:]).all() and np.isnan(course[12:]).all()
    failed = record_ramp(samples=2, failure="an overlap").tables
    assert np.isnan(failed["block_end"]).all()


def test_averages_are_over_the_window_and_extremes_over_the_whole_run():
    record = record_ramp()
    scalars = record.scalars
    assert np.array_equal(record.series["mean_velocity"], np.arange(1.0, 17.0))
    assert scalars["velocity"] == 10.5
    assert scalars["acceleration"] == pytest.approx(10.0)
    assert (scalars["regime"], scalars["quality"]) == ("accelerating", "drifting")
    assert scalars["stopped"] == "length"
    assert scalars["average_start"] == pytest.approx(0.4)
    assert scalars["base_normal"] == 105.0
    assert scalars["base_shear"] == 4.0
    assert scalars["max_overlap"] == 0.3
    assert (scalars["status"], scalars["reason"]) == ("completed", "")


def test_the_ledger_says_what_it_lacks_and_where_the_power_goes():
    """Of 1.02 J lost per sample the kinetic energy knows 1."""
    scalars = record_ramp().scalars
    assert scalars["energy_residual"] == pytest.approx(0.02 / 1.02)
    assert scalars["normal_power"] == pytest.approx(10.2)


def test_the_momentum_budget_is_that_of_the_window():
    """A mass of 2 kg that gains 10 m/s each second under a drag of 4 N: 24 N."""
    assert record_ramp().scalars["momentum_budget"] == pytest.approx(24.0)


def test_profiles_are_cumulative_over_the_window_and_of_the_last_sample():
    record = record_ramp()
    assert record.profiles["velocity_profile"] == pytest.approx([10.5])
    assert record.profiles["velocity_profile_instantaneous"] == pytest.approx([16.0])
    assert record.profiles["packing_profile"] == pytest.approx([2.0])


def test_a_converged_run_goes_on_until_its_mean_is_known():
    noise = 1e-3 * np.random.default_rng(0).normal(size=257)
    parameters = SimpleNamespace(**vars(CONVERGED) | {"longest_samples": 256})
    record = record_ramp(
        parameters=parameters, velocity=lambda number: 100.0 * 0.5**number + 1.0 + noise[number]
    )
    length = record.series["mean_velocity"].size
    assert 16 < length < 256
    assert record.scalars["stopped"] == "target"
    assert record.scalars["velocity"] == pytest.approx(1.0, rel=0.02)
    assert record.scalars["average_start"] > 0.3
    first = round(record.scalars["average_start"] / 0.1) + 1
    assert record.profiles["velocity_profile"] == pytest.approx([(first + length) / 2], abs=1.0)


def test_a_converged_run_ends_at_its_limit():
    noise = np.random.default_rng(1).normal(size=65)
    record = record_ramp(parameters=CONVERGED, velocity=lambda number: 1.0 + noise[number])
    assert record.series["mean_velocity"].size == 64
    assert record.scalars["stopped"] == "limit"


def test_snapshots_are_the_first_and_the_last_state():
    first, last = record_ramp().snapshots["position"]
    assert (first[0, 0], last[0, 0]) == (0.0, 16.0)


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("samples", [0, 3, 7])
def test_a_failure_keeps_what_was_measured_and_claims_no_average(samples):
    record = record_ramp(samples, failure="burst")
    velocity = record.series["mean_velocity"]
    assert np.array_equal(velocity[:samples], np.arange(1.0, samples + 1))
    assert np.isnan(velocity[samples:]).all()
    assert (record.scalars["status"], record.scalars["reason"]) == ("failed", "burst")
    assert record.scalars["regime"] == "undetermined"
    for name in ("velocity", "velocity_error", "acceleration", "acceleration_error", "base_normal"):
        assert np.isnan(record.scalars[name])
    assert record.scalars["max_overlap"] == (0.3 if samples > 1 else 0.0)
    in_window = samples > 4
    assert np.isfinite(record.profiles["velocity_profile"]).all() == in_window
