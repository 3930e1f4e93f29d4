"""What a replicate leaves behind, recorded from a made-up system."""

import numpy as np
import pytest

from sim.observe.profiles import empty_profile
from sim.observe.recorder import Recorder
from sim.observe.regime import Scales


class Ramp:
    """A system whose mean velocity is its sample's number, and whose one slice counts samples."""

    series = {
        "mean_velocity": ("m s-1", ""),
        "largest_overlap": ("1", ""),
        "base_normal_force": ("N", ""),
    }
    profile_height = np.array([0.5])
    scales = Scales(arrested=1e-3, acceleration=0.1, drift=0.0)
    period = 1

    def __init__(self):
        self.number = 0

    def advance(self):
        self.number += 1
        return {
            "mean_velocity": float(self.number),
            "largest_overlap": 0.3 if self.number == 2 else 0.1,
            "base_normal_force": 10.0 * self.number,
        }

    def sample_profiles(self):
        profile = empty_profile(1, 3)
        profile.samples[0], profile.weight[0], profile.moved[0] = 1.0, 2.0, 2.0 * self.number
        return (profile,)

    def profiles(self, sums):
        return {
            "velocity_profile": sums[0].velocity(),
            "packing_profile": sums[0].weight / sums[0].samples,
        }

    def snapshot(self):
        return {"position": np.full((1, 3), float(self.number))}


def recorded(samples: int, failure: str = ""):
    """The record of a ramp with 4 transient and 6 averaged samples, of which some were taken."""
    system = Ramp()
    recorder = Recorder(system, 4, 6)
    recorder.take_snapshot()
    for _ in range(samples):
        recorder.take(system.advance())
    recorder.take_snapshot()
    return recorder.finish(0.1, failure)


def test_averages_are_over_the_window_and_extremes_over_the_whole_run():
    record = recorded(10)
    assert np.array_equal(record.series["mean_velocity"], np.arange(1.0, 11.0))
    assert record.scalars["velocity"] == 7.5
    assert record.scalars["acceleration"] == pytest.approx(10.0)
    assert record.scalars["regime"] == "accelerating"
    assert record.scalars["base_normal"] == 75.0
    assert record.scalars["max_overlap"] == 0.3
    assert (record.scalars["status"], record.scalars["reason"]) == ("completed", "")


def test_profiles_are_cumulative_over_the_window_and_of_the_last_sample():
    record = recorded(10)
    assert record.profiles["velocity_profile"] == pytest.approx([7.5])
    assert record.profiles["velocity_profile_instantaneous"] == pytest.approx([10.0])
    assert record.profiles["packing_profile"] == pytest.approx([2.0])


def test_snapshots_are_the_first_and_the_last_state():
    first, last = recorded(10).snapshots["position"]
    assert (first[0, 0], last[0, 0]) == (0.0, 10.0)


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("samples", [0, 3, 7])
def test_a_failure_keeps_what_was_measured_and_claims_no_average(samples):
    record = recorded(samples, failure="burst")
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
