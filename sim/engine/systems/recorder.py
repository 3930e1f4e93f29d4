"""Collects the data of one replicate while it runs, its trajectory included, until it may end."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from sim.engine.dynamics.cells import BlowUp
from sim.engine.observe.force_balance import base_forces
from sim.engine.observe.regime import (
    ARRESTED,
    FAILED_TREND,
    LENGTH,
    LIMIT,
    Trend,
    analyse,
    look_lengths,
    verdict,
    window_start,
)
from sim.engine.observe.samples import MAX_BLOCKS, ProfileBlocks, Samples
from sim.engine.states import FlatState, flatten, subtree
from sim.engine.systems.replica import Replica
from sim.parameters.variables import HISTORY, INSTANTANEOUS, variables_of


@dataclass
class Record:
    """Everything measured in one replicate.

    ``series`` name -> (T,), not-a-number after a failure; ``profiles`` name -> (H,), averages over
    the window, and with the suffix ``_instantaneous`` those of the last sample; ``tables`` name ->
    array with its own dimensions; ``path`` (S, N, D) of the particles after the last sample, m;
    ``frames`` name -> (F, N, D) of the trajectory; ``snapshots`` name -> first and last state;
    ``scalars`` name -> number or text.
    """

    series: dict[str, np.ndarray]
    profiles: dict[str, np.ndarray] = field(default_factory=dict)
    tables: dict[str, np.ndarray] = field(default_factory=dict)
    path: np.ndarray | None = None
    frames: dict[str, np.ndarray] = field(default_factory=dict)
    snapshots: dict[str, list[np.ndarray]] = field(default_factory=dict)
    scalars: dict[str, float | int | str] = field(default_factory=dict)


class Recorder:
    """Collects the samples of one replicate until its protocol ends the run.

    ``sample_count`` number of samples so far; ``stop_reason`` reason to end the run, empty until
    then; ``snapshots`` name -> states so far; ``path`` of the particles, once it has been traced.
    """

    def __init__(self, system: Replica):
        p = system.parameters
        self.system = system
        self.sample_count = 0
        self.stop_reason = ""
        self._reason = ""
        self._published = p.protocol == "published"
        self._interval = p.sample_steps * p.time_step
        self._start = self._transient = p.transient_samples
        self._looks = look_lengths(p.shortest_samples, p.longest_samples)
        self._trend: Trend | None = None
        self._table = np.full((len(system.series), p.shortest_samples), np.nan)
        self._profiles = ProfileBlocks()
        self._trajectory = Trajectory(p.trajectory_samples, p.trajectory_room)
        self.snapshots: dict[str, list[np.ndarray]] = {}
        self.path: np.ndarray | None = None

    def next_samples(self) -> tuple[int, bool]:
        """Return the number of samples to take next at once, and True where with profiles."""
        stops = [stop for stop in (self._transient, *self._looks) if stop > self.sample_count]
        stops += self._trajectory.next_frame(self.sample_count)
        return min(stops) - self.sample_count, self.sample_count >= self._transient

    def take(self, samples: Samples) -> None:
        """Store samples and decide whether the run ends after them.

        Only the last of them may be a sample at which the run is analysed or a frame is taken.
        """
        rows = np.array([samples.values[name] for name in self.system.series])
        last = self.sample_count + rows.shape[1]
        while last > self._table.shape[1]:
            growth = self._table.shape[1]
            self._table = np.pad(self._table, ((0, 0), (0, growth)), constant_values=np.nan)
        self._table[:, self.sample_count : last] = rows
        if samples.profiles:
            self._profiles.add(samples.profiles)
        self.sample_count = last
        self._trajectory.take(self.system, last)
        if self.sample_count in self._looks:
            self._look()

    def state(self) -> FlatState:
        """Return all collected data, arrays and numbers by name."""
        table = self._table[:, : self.sample_count]
        data = {"taken": self.sample_count, "table": table, "snapshots": self.snapshots}
        data |= {"profiles": self._profiles.state(), "frames": self._trajectory.frames()}
        return flatten(data)

    def restore(self, state: Mapping[str, Any]) -> None:
        """Put the data of another recorder of such a system into this new one.

        Raises ``ValueError`` when the data do not fit, or when the other run is longer than this
        one may become.
        """
        table, samples = state["table"], state["taken"]
        if table.shape != (len(self._table), samples):
            raise ValueError("its series are not those of the system")
        for look in self._looks:
            if look < samples:
                self._table, self.sample_count = table, look
                self._look()
        if self.stop_reason or samples > self._looks[-1]:
            raise ValueError("it has been run for longer than is wanted")
        self.sample_count = samples
        self._table = table if samples else self._table
        for path, array in subtree("snapshots", state).items():
            self.snapshots.setdefault(path.partition(".")[0], []).append(array)
        self._profiles.restore(subtree("profiles", state), self.system.slices.empty())
        self._trajectory.restore(subtree("frames", state), samples)
        if samples in self._looks:
            self._look()

    def _look(self) -> None:
        """Analyse the velocity so far; end the run where that suffices, and at its full length."""
        p, velocity = self.system.parameters, self._velocity()
        scales, period = self.system.scales, self.system.period
        reason = LENGTH
        if self._published:
            self._trend = analyse(velocity[self._start :], self._interval, scales, period)
        else:
            self._start, self._trend, reason = verdict(
                velocity, self._interval, scales, period, p.transient_samples
            )
            confirmed = reason in (self._reason, ARRESTED)
            self._reason, reason = reason, reason if confirmed else ""
        last = self.sample_count == self._looks[-1]
        self.stop_reason = reason or (LIMIT if last else "")

    def _velocity(self) -> np.ndarray:
        row = list(self.system.series).index("mean_velocity")
        return self._table[row, : self.sample_count]

    def take_snapshot(self) -> None:
        """Store the present state as the next snapshot."""
        for name, array in self.system.snapshot().items():
            self.snapshots.setdefault(name, []).append(array)

    def finish(self, failure: str) -> Record:
        """Return the record with its averages; ``failure`` is the cause of a blow-up, or empty."""
        length = self.sample_count if self.stop_reason else max(self.sample_count, self._looks[0])
        table = self._table[:, :length]
        record = Record(dict(zip(self.system.series, table, strict=True)))
        record.snapshots = self.snapshots
        record.path = self.path
        record.frames = self._trajectory.frames()
        trend = FAILED_TREND if failure else self._trend
        assert trend is not None, "a run that did not fail ends after an analysis"
        record.scalars = {
            **self._averages(trend),
            **self._energies(record.series),
            "stopped": "failure" if failure else self.stop_reason,
            "status": "failed" if failure else "completed",
            "reason": failure,
        }
        if "largest_overlap" in record.series:
            overlaps = record.series["largest_overlap"][: self.sample_count]
            record.scalars["max_overlap"] = float(np.max(overlaps, initial=0))
        if "base_shear_force" in record.series:
            record.scalars |= self._base_forces(record.series, length if failure else self._start)
        self._add_profiles(record)
        return record

    def _averages(self, trend: Trend) -> dict[str, float | str]:
        transient = window_start(self._velocity(), self.system.period)
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
        """Return mean powers over the window and the relative energy error over the whole run.

        Nothing where the engine does not tell all terms of the ledger.
        """
        ledger, last = self.system.ledger, self.sample_count - 1
        if not ledger.terms.keys() <= series.keys():
            return {}
        if last < 1:
            return dict.fromkeys(("energy_residual", *ledger.powers.values()), np.nan)
        change = {name: float(values[last] - values[0]) for name, values in series.items()}
        residual = _sum([sign * change[name] for name, sign in ledger.terms.items()])
        turnover = _sum([change[name] for name in ledger.turnover])
        start = min(max(self._start - 1, 0), last - 1)
        time = (last - start) * self._interval
        powers = {
            power: float(series[name][last] - series[name][start]) / time
            for name, power in ledger.powers.items()
        }
        return {"energy_residual": residual / turnover if turnover else np.nan, **powers}

    def _base_forces(self, series: dict[str, np.ndarray], start: int) -> dict[str, float]:
        names = ("base_shear_force", "base_normal_force", "mean_velocity")
        shear, normal, velocity = (series[name][start:] for name in names)
        system = self.system
        return base_forces(shear, normal, velocity, system.mass, system.weight, self._interval)

    def _add_profiles(self, record: Record) -> None:
        """Add profiles and tables; they are undefined without a sample past the transient."""
        empty = self.system.slices.empty()
        window = self._profiles.sum_since(self._start - self._transient)
        latest = self._profiles.latest
        with np.errstate(invalid="ignore", divide="ignore"):
            for suffix, sums in (("", window), (INSTANTANEOUS, latest)):
                for name, values in self.system.slices.profiles(sums or empty).items():
                    record.profiles[name + suffix] = values
            record.tables = self.system.slices.tables(window or empty)
            if self.system.history_profiles:
                record.tables |= self._history()

    def _history(self) -> dict[str, np.ndarray]:
        """Return profiles (B, H) of the blocks of samples, and the end time of each block (B,), s.

        Rows beyond the number of blocks are not-a-number.
        """
        slices, blocks = len(self.system.profile_height), self._profiles.blocks()
        end = np.full(MAX_BLOCKS, np.nan)
        end[: len(blocks)] = [(self._transient + count) * self._interval for count, _ in blocks]
        profiles = [self.system.slices.profiles(sums) for _, sums in blocks]
        tables = {"block_end": end}
        for name in self.system.history_profiles:
            table = tables[name + HISTORY] = np.full((MAX_BLOCKS, slices), np.nan, np.float32)
            for row, block in zip(table, profiles, strict=False):
                row[:] = block[name]
        return tables


def _sum(values: list[float]) -> float:
    """Return the sum of values, added in order; Python's `sum` rounds differently from 3.12 on."""
    return float(np.cumsum(values)[-1])


class Trajectory:
    """Takes a frame at the end of every ``samples``-th sample, no frames where that is 0.

    Each frame has space for ``contacts`` contacts, none where that is 0; unused rows are
    not-a-number. Frames are in single precision, like the formats of other programs: a position in
    a cell of ten diameters is accurate to a millionth of a diameter.
    """

    def __init__(self, samples: int, contacts: int = 0):
        self._samples, self._contacts = samples, contacts
        self._frames: dict[str, list[np.ndarray]] = {}

    def next_frame(self, count: int) -> list[int]:
        """Return the number of samples at the next frame after ``count`` samples, if any."""
        return [(count // self._samples + 1) * self._samples] if self._samples else []

    def take(self, system: Replica, count: int) -> None:
        """Take a frame of a system after ``count`` samples, if one is due."""
        if self._samples and count % self._samples == 0:
            state = system.snapshot()
            if self._contacts:
                state |= self._contact_arrays(system)
            for name, row in variables_of("trajectory").items():
                if row.of in state:
                    frame = np.array(state[row.of], np.float32)
                    self._frames.setdefault(name, []).append(frame)

    def _contact_arrays(self, system: Replica) -> dict[str, np.ndarray]:
        """Return the contacts of the present state; unused rows are not-a-number."""
        contacts = system.current_contacts(self._contacts)
        if (number := int(contacts.number[0])) > self._contacts:
            raise BlowUp(f"{number} contacts, more than {self._contacts}, which a frame holds")
        return {"contact_pair": contacts.pair, "contact_force": contacts.force}

    def frames(self) -> dict[str, np.ndarray]:
        """Return the frames so far, name -> (F, N, D); empty before the first."""
        return {name: np.array(frames) for name, frames in self._frames.items()}

    def restore(self, frames: Mapping[str, Any], count: int) -> None:
        """Replace the frames by those of another trajectory after ``count`` samples.

        Raises ``ValueError`` when the frames do not fit.
        """
        expected = count // self._samples if self._samples else 0
        is_complete = all(len(values) == expected for values in frames.values())
        if not is_complete or bool(frames) != bool(expected):
            raise ValueError("its frames are not those of the trajectory")
        self._frames = {name: list(values) for name, values in frames.items()}
