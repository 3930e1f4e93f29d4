"""What one replicate leaves behind, collected while it runs, and when it has run long enough."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, cast

import numpy as np

from sim.engine.flatten import FlatState, flattened, part_at
from sim.engine.observe import stopping
from sim.engine.observe.blocks import MOST, ProfileBlocks
from sim.engine.observe.force_balance import base_forces
from sim.engine.observe.regime import FAILED, Trend, analyse
from sim.engine.observe.system import OnSlope, Samples, System
from sim.engine.observe.trajectory import Trajectory
from sim.parameters.variables import HISTORY, INSTANTANEOUS


@dataclass
class Record:
    """Everything measured in one replicate.

    ``series`` name -> (T,), not-a-number after a failure; ``profiles`` name -> (H,), cumulative,
    and with the suffix ``_instantaneous`` the last sample's; ``tables`` name -> array of dimensions
    of its own; ``path`` (S, N, D) of the particles after the last sample, m; ``frames`` name ->
    (F, N, D) of the trajectory; ``snapshots`` name -> first and last state; ``scalars`` name ->
    number or text.
    """

    series: dict[str, np.ndarray]
    profiles: dict[str, np.ndarray] = field(default_factory=dict)
    tables: dict[str, np.ndarray] = field(default_factory=dict)
    path: np.ndarray | None = None
    frames: dict[str, np.ndarray] = field(default_factory=dict)
    snapshots: dict[str, list[np.ndarray]] = field(default_factory=dict)
    scalars: dict[str, float | int | str] = field(default_factory=dict)


class Recorder:
    """Collects the samples of one replicate until its protocol is content.

    ``taken`` samples so far; ``stopped`` is the reason to take no more, empty until then;
    ``snapshots`` name -> states so far; ``path`` of the particles once it has been traced.
    """

    def __init__(self, system: System):
        p = system.parameters
        self.system = system
        self.taken = 0
        self.stopped = ""
        self._reason = ""
        self._published = p.protocol == "published"
        self._interval = p.sample_steps * p.time_step
        self._start = self._transient = p.transient_samples
        self._looks = stopping.looks(p.shortest_samples, p.longest_samples)
        self._trend: Trend | None = None
        self._table = np.full((len(system.series), p.shortest_samples), np.nan)
        self._profiles = ProfileBlocks()
        self._trajectory = Trajectory(p.trajectory_samples, p.trajectory_room)
        self.snapshots: dict[str, list[np.ndarray]] = {}
        self.path: np.ndarray | None = None

    def due(self) -> tuple[int, bool]:
        """Return how many samples to take next in one go, and whether with profiles."""
        stops = [stop for stop in (self._transient, *self._looks) if stop > self.taken]
        stops += self._trajectory.due(self.taken)
        return min(stops) - self.taken, self.taken >= self._transient

    def take(self, samples: Samples) -> None:
        """Store samples, of which only the last may be one to look at or have a frame, and decide
        whether it was the last of all."""
        rows = np.array([samples.values[name] for name in self.system.series])
        last = self.taken + rows.shape[1]
        while last > self._table.shape[1]:
            more = self._table.shape[1]
            self._table = np.pad(self._table, ((0, 0), (0, more)), constant_values=np.nan)
        self._table[:, self.taken : last] = rows
        if samples.profiles:
            self._profiles.add(samples.profiles)
        self.taken = last
        self._trajectory.take(self.system, last)
        if self.taken in self._looks:
            self._look()

    def state(self) -> FlatState:
        """Return what has been collected, arrays and numbers by name."""
        table = self._table[:, : self.taken]
        collected = {"taken": self.taken, "table": table, "snapshots": self.snapshots}
        collected |= {"profiles": self._profiles.state(), "frames": self._trajectory.frames()}
        return flattened(collected)

    def restore(self, state: Mapping[str, Any]) -> None:
        """Put what another recorder of such a system has collected into this new one.

        Raises ``ValueError`` when it is none of such a recorder, or of a run that has gone beyond
        the end of this one.
        """
        table, taken = state["table"], state["taken"]
        if table.shape != (len(self._table), taken):
            raise ValueError("its series are not those of the system")
        for look in self._looks:
            if look < taken:
                self._table, self.taken = table, look
                self._look()
        if self.stopped or taken > self._looks[-1]:
            raise ValueError("it has been run for longer than is wanted")
        self.taken = taken
        self._table = table if taken else self._table
        for place, array in part_at("snapshots", state).items():
            self.snapshots.setdefault(place.partition(".")[0], []).append(array)
        self._profiles.restore(part_at("profiles", state), self.system.no_profiles())
        self._trajectory.restore(part_at("frames", state), taken)
        if taken in self._looks:
            self._look()

    def _look(self) -> None:
        """Analyse the velocity so far; stop where that is enough, and at the longest length."""
        p, velocity = self.system.parameters, self._velocity()
        scales, period = self.system.scales, self.system.period
        reason = stopping.LENGTH
        if self._published:
            self._trend = analyse(velocity[self._start :], self._interval, scales, period)
        else:
            self._start, self._trend, reason = stopping.verdict(
                velocity, self._interval, scales, period, p.transient_samples
            )
            confirmed = reason in (self._reason, stopping.ARRESTED)
            self._reason, reason = reason, reason if confirmed else ""
        last = self.taken == self._looks[-1]
        self.stopped = reason or (stopping.LIMIT if last else "")

    def _velocity(self) -> np.ndarray:
        row = list(self.system.series).index("mean_velocity")
        return self._table[row, : self.taken]

    def take_snapshot(self) -> None:
        """Store the present state as the next snapshot."""
        for name, array in self.system.snapshot().items():
            self.snapshots.setdefault(name, []).append(array)

    def finish(self, failure: str) -> Record:
        """Return the record with its averages; ``failure`` is the reason of a blow-up, or empty."""
        length = self.taken if self.stopped else max(self.taken, self._looks[0])
        table = self._table[:, :length]
        record = Record(dict(zip(self.system.series, table, strict=True)))
        record.snapshots = self.snapshots
        record.path = self.path
        record.frames = self._trajectory.frames()
        trend = FAILED if failure else self._trend
        assert trend is not None, "a replicate ends well after a look only"
        record.scalars = {
            **self._averages(trend),
            **self._energies(record.series),
            "max_overlap": float(np.max(record.series["largest_overlap"][: self.taken], initial=0)),
            "stopped": "failure" if failure else self.stopped,
            "status": "failed" if failure else "completed",
            "reason": failure,
        }
        if "base_shear_force" in record.series:
            record.scalars |= self._base_forces(record.series, length if failure else self._start)
        self._add_profiles(record)
        return record

    def _averages(self, trend: Trend) -> dict[str, float | str]:
        transient = stopping.window_start(self._velocity(), self.system.period)
        return {
            "velocity": trend.velocity.value,
            "velocity_error": trend.velocity.error,
            "velocity_half_width": trend.velocity.half_width,
            "acceleration": trend.acceleration.value,
            "acceleration_error": trend.acceleration.error,
            "acceleration_half_width": trend.acceleration.half_width,
            "regime": trend.regime,
            "quality": trend.quality,
            "independent_samples": trend.independent,
            "average_start": self._start * self._interval,
            "transient_end": transient * self._interval,
        }

    def _energies(self, series: dict[str, np.ndarray]) -> dict[str, float]:
        """Return mean powers over the window and how well the ledger closes over the whole run."""
        ledger, taken = self.system.ledger, self.taken
        if taken < 2:
            return dict.fromkeys(("energy_residual", *ledger.powers.values()), np.nan)
        change = {name: float(values[taken - 1] - values[0]) for name, values in series.items()}
        residual = _added([sign * change[name] for name, sign in ledger.terms.items()])
        turnover = _added([change[name] for name in ledger.turnover])
        start = min(max(self._start - 1, 0), taken - 2)
        time = (taken - 1 - start) * self._interval
        powers = {
            power: float(series[name][taken - 1] - series[name][start]) / time
            for name, power in ledger.powers.items()
        }
        return {"energy_residual": residual / turnover if turnover else np.nan, **powers}

    def _base_forces(self, series: dict[str, np.ndarray], start: int) -> dict[str, float]:
        names = ("base_shear_force", "base_normal_force", "mean_velocity")
        shear, normal, velocity = (series[name][start:] for name in names)
        # The series of base forces are there on a slope alone.
        system = cast(OnSlope, self.system)
        return base_forces(shear, normal, velocity, system.mass, system.weight, self._interval)

    def _add_profiles(self, record: Record) -> None:
        """Turn the sums into profiles; without a sample past the transient they are undefined."""
        empty = self.system.no_profiles()
        window = self._profiles.since(self._start - self._transient)
        latest = self._profiles.latest
        with np.errstate(invalid="ignore", divide="ignore"):
            for suffix, sums in (("", window), (INSTANTANEOUS, latest)):
                for name, values in self.system.profiles(sums or empty).items():
                    record.profiles[name + suffix] = values
            record.tables = self.system.tables(window or empty)
            if self.system.followed:
                record.tables |= self._history()

    def _history(self) -> dict[str, np.ndarray]:
        """Return profiles (B, H) of the blocks of samples, and when each ends (B,) in s.

        Not-a-number where there are fewer blocks.
        """
        slices, blocks = len(self.system.profile_height), self._profiles.each()
        end = np.full(MOST, np.nan)
        end[: len(blocks)] = [(self._transient + taken) * self._interval for taken, _ in blocks]
        profiles = [self.system.profiles(sums) for _, sums in blocks]
        found = {"block_end": end}
        for name in self.system.followed:
            held = found[name + HISTORY] = np.full((MOST, slices), np.nan, np.float32)
            for row, block in zip(held, profiles, strict=False):
                row[:] = block[name]
        return found


def _added(values: list[float]) -> float:
    """Return the sum of values added one to the next; Python's `sum` rounds less from 3.12 on."""
    return float(np.cumsum(values)[-1])
