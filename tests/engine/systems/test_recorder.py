"""Records of a made-up system, and the base forces of a window."""

from types import SimpleNamespace

import numpy as np
import pytest

import sim
from sim.engine.observe.force_balance import BLOCKS, base_forces, bounded_error, momentum_budget
from sim.engine.observe.profiles import empty_profile
from sim.engine.observe.regime import Scales
from sim.engine.observe.samples import MAX_BLOCKS, Ledger, Samples, zero_samples
from sim.engine.systems.recorder import Recorder, Trajectory

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

CHUTE = {"system": "chute", "depth": 2, "cell": 5}

SHORT = {"transient": 2, "average": 3, "replicates": 2, "progress": False}


class Ramp:
    """A system, and its slices: the mean velocity is the sample's number; one slice counts them."""

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
        self.slices = self

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

    def empty(self):
        return (empty_profile(1, 3),)

    def profiles(self, sums):
        return {
            "velocity_profile": sums[0].velocity(),
            "packing_profile": sums[0].weight / sums[0].samples,
        }

    def tables(self, sums):
        return {"samples": sums[0].samples}

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
    # Of 1.02 J lost per sample the kinetic energy knows 1.
    assert scalars["energy_residual"] == pytest.approx(0.02 / 1.02)
    assert scalars["normal_power"] == pytest.approx(10.2)
    # A mass of 2 kg that gains 10 m/s each second under a drag of 4 N.
    assert scalars["momentum_budget"] == pytest.approx(24.0)
    assert record.profiles["velocity_profile"] == pytest.approx([10.5])
    assert record.profiles["velocity_profile_instantaneous"] == pytest.approx([16.0])
    assert record.profiles["packing_profile"] == pytest.approx([2.0])
    assert [float(state[0, 0]) for state in record.snapshots["position"]] == [0.0, 16.0]


def test_a_converged_run_goes_on_until_its_mean_is_known_or_to_its_limit():
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
    noise = np.random.default_rng(1).normal(size=65)
    record = record_ramp(parameters=CONVERGED, velocity=lambda number: 1.0 + noise[number])
    assert (record.series["mean_velocity"].size, record.scalars["stopped"]) == (64, "limit")


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


def still(samples: int) -> SimpleNamespace:
    """A system whose only particle is where the number of its samples says."""
    place = np.full((1, 2), float(samples))
    return SimpleNamespace(snapshot=lambda: {"position": place, "radius": np.ones(1)})


def test_frames_are_taken_at_multiples_of_their_distance_and_go_on_where_they_were():
    trajectory = Trajectory(2)
    assert [trajectory.next_frame(count) for count in range(4)] == [[2], [2], [4], [4]]
    for count in range(1, 6):
        trajectory.take(still(count), count)
    held, again = trajectory.frames(), Trajectory(2)
    again.restore(held, 5)
    again.take(still(6), 6)
    assert list(held) == ["trajectory_position"]
    assert again.frames()["trajectory_position"][:, 0, 0].tolist() == [2, 4, 6]
    assert again.frames()["trajectory_position"].dtype == np.float32
    Trajectory(2).restore({}, 1)
    for frames, samples in ((held, 6), ({}, 2), (held, 0)):
        with pytest.raises(ValueError, match="frames"):
            Trajectory(2).restore(frames, samples)
    none = Trajectory(0)
    none.take(still(5), 5)
    assert none.next_frame(5) == [] and none.frames() == {}


def test_a_trajectory_changes_nothing_else_and_its_frames_are_the_flow():
    usual = sim.simulate(**CHUTE, **SHORT)
    run = sim.simulate(**CHUTE, **SHORT, trajectory=0.5)
    shown = {"position": "positions", "velocity": "velocities", "spin": "spins"}
    added = {"trajectory", "trajectory_time", *(f"trajectory_{name}" for name in shown)}
    assert set(run.variables) - set(usual.variables) == added
    for name in set(usual.variables) - {"wall_time", "loop_time"}:
        np.testing.assert_array_equal(run[name], usual[name], name)
    assert run.sizes["trajectory_time"] == 10
    flow = sim.Flow(**CHUTE, replicate=1).run(1.5, progress=False)
    frame = run.isel(replicate=1, trajectory_time=2)
    assert float(frame.trajectory_time) == pytest.approx(flow.time)
    for name, of_flow in shown.items():
        assert np.array_equal(frame[f"trajectory_{name}"], np.float32(getattr(flow, of_flow)))


INTERVAL, MASS, WEIGHT = 0.01, 2.0, 3.0


def flow(samples: int, seed: int):
    """Velocity that wanders, and the base force that Newton's law then asks for."""
    velocity = np.cumsum(np.random.default_rng(seed).normal(size=samples + 1)) * 0.01
    # The means of two neighboring intervals differ by the force over a ramp up and down.
    fine = np.repeat(np.diff(velocity) / INTERVAL, 2)
    force = WEIGHT - MASS * fine
    mean = 0.5 * (velocity[1:] + velocity[:-1])
    return force.reshape(-1, 2).mean(axis=1), mean


def test_the_budget_is_the_weight_along_the_slope_within_its_error():
    for seed in range(20):
        shear, velocity = flow(400, seed)
        budget, error = momentum_budget(shear, MASS * velocity, INTERVAL)
        assert abs(budget - WEIGHT) < 5 * error


def test_the_error_of_a_bounded_fluctuation_falls_with_the_length():
    wave = np.sin(np.arange(6000) * 0.37)
    assert bounded_error(wave) < 0.15 * bounded_error(wave[:600])
    blocks = [np.std([part.mean() for part in np.array_split(wave, b)], ddof=1) / b for b in BLOCKS]
    assert bounded_error(wave) == pytest.approx(max(blocks), rel=1e-12)


@pytest.mark.filterwarnings("error")
def test_balances_are_relative_to_the_weight_and_one_sample_has_no_error():
    for samples in (0, 1):
        found = base_forces(*(np.ones(samples) for _ in range(3)), MASS, (0.5, 2.0), INTERVAL)
        assert np.isnan(found["base_normal_error"]) and np.isnan(found["momentum_budget"])
        assert found["base_normal"] == 1.0 or samples == 0
    series = np.full(20, 0.6), np.full(20, 1.9), np.ones(20), MASS
    found = base_forces(*series, (0.5, 2.0), INTERVAL)
    assert (found["shear_balance"], found["normal_balance"]) == pytest.approx((1.2, 0.95))
    assert np.isnan(base_forces(*series, (0.0, 1.0), INTERVAL)["shear_balance"])
