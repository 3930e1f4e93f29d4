"""What one replicate leaves behind, collected while it runs."""

from dataclasses import dataclass, field

import numpy as np

from sim.observe.profiles import Profile
from sim.observe.regime import Trend, analyse
from sim.systems import System


@dataclass
class Record:
    """Everything measured in one replicate.

    ``series`` name -> (T,), not-a-number after a failure; ``profiles`` name -> (H,), cumulative,
    and with the suffix ``_instantaneous`` the last sample's; ``snapshots`` name -> first and last
    state; ``scalars`` name -> number or text.
    """

    series: dict[str, np.ndarray]
    profiles: dict[str, np.ndarray] = field(default_factory=dict)
    snapshots: dict[str, list[np.ndarray]] = field(default_factory=dict)
    scalars: dict[str, float | int | str] = field(default_factory=dict)


class Recorder:
    """Collects the samples of one replicate: ``transient`` ones first, then ``average`` ones."""

    def __init__(self, system: System, transient: int, average: int):
        self.system = system
        self.transient = transient
        self.total = transient + average
        self.taken = 0
        self.record = Record({name: np.full(self.total, np.nan) for name in system.series})
        self._cumulative: tuple[Profile, ...] | None = None
        self._latest: tuple[Profile, ...] | None = None

    def take(self, values: dict[str, float]) -> None:
        """Store one sample and, past the transient, add its profiles."""
        for name, value in values.items():
            self.record.series[name][self.taken] = value
        if self.taken >= self.transient:
            self._latest = self.system.sample_profiles()
            if self._cumulative is None:
                self._cumulative = self._latest
            else:
                self._cumulative = tuple(
                    total.plus(latest)
                    for total, latest in zip(self._cumulative, self._latest, strict=True)
                )
        self.taken += 1

    def take_snapshot(self) -> None:
        """Store the present state as the next snapshot."""
        for name, array in self.system.snapshot().items():
            self.record.snapshots.setdefault(name, []).append(array)

    def finish(self, interval: float, failure: str) -> Record:
        """Return the record with its averages; ``failure`` is the reason of a blow-up, or empty."""
        record = self.record
        window = slice(self.transient, self.total)
        trend = self._trend(interval, failure)
        record.scalars = {
            "velocity": trend.velocity,
            "velocity_error": trend.velocity_error,
            "acceleration": trend.acceleration,
            "acceleration_error": trend.acceleration_error,
            "regime": trend.regime,
            "max_overlap": float(np.max(record.series["largest_overlap"][: self.taken], initial=0)),
            "status": "failed" if failure else "completed",
            "reason": failure,
        }
        for scalar, name in (
            ("base_normal", "base_normal_force"),
            ("base_shear", "base_shear_force"),
        ):
            if name in record.series:
                record.scalars[scalar] = float(record.series[name][window].mean())
        self._add_profiles()
        return record

    def _trend(self, interval: float, failure: str) -> Trend:
        """Analyse the averaging window; a failed run has no mean and no regime."""
        if failure:
            return Trend(np.nan, np.nan, np.nan, np.nan, "undetermined")
        velocity = self.record.series["mean_velocity"][self.transient :]
        return analyse(velocity, interval, self.system.scales, self.system.period)

    def _add_profiles(self) -> None:
        """Turn the sums into profiles; without a sample past the transient they are undefined."""
        empty = tuple(profile.zeros() for profile in self.system.sample_profiles())
        for suffix, sums in (("", self._cumulative), ("_instantaneous", self._latest)):
            with np.errstate(invalid="ignore", divide="ignore"):
                profiles = self.system.profiles(sums or empty)
            for name, values in profiles.items():
                self.record.profiles[name + suffix] = values
