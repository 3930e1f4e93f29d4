"""Profiles of the bed over the height above the belt, at all times and as the cycle begins."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from sim.engine.observe.profiles import Profile, empty_profile
from sim.engine.observe.sums import Sums, chosen_of
from sim.parameters import BeltParameters
from sim.parameters.variables import AT_PHASE_0, parts

#: Height of the profiles in mean diameters.
HEIGHT = 80


class Phases(NamedTuple):
    """Sums over samples at each of P phases of the cycle: ``count`` (P, H) of the centres in a
    slice, and ``moved`` (P, H, 2), their velocities relative to the mean of all (m/s)."""

    # A name that hides a method of tuples, which nobody calls.
    count: np.ndarray  # type: ignore[assignment]
    moved: np.ndarray


class BedProfiles(NamedTuple):
    """How the bed is cut into ``slices`` of ``slice_height`` (m) and of ``width`` (m).

    Sums are profiles by centres and by area. Where ``at_phase_0`` is true, as many follow of the
    beginning of the cycle alone; where there are ``phases`` of the cycle to be told apart, those.
    """

    slices: int
    slice_height: float
    width: float
    at_phase_0: bool
    phases: int

    def height(self) -> np.ndarray:
        """Return the centres of the slices above the belt, m."""
        return (np.arange(self.slices) + 0.5) * self.slice_height

    def empty(self) -> Sums:
        """Return sums of zero."""
        profiles = (empty_profile(self.slices, 2) for _ in range(4 if self.at_phase_0 else 2))
        shape = (self.phases, self.slices)
        phases = (Phases(np.zeros(shape), np.zeros((*shape, 2))),) if self.phases else ()
        return *profiles, *phases

    def of_phases(self, centres: Profile, area: Profile, phase: np.ndarray) -> Sums:
        """Return what is asked for of several samples by their phase, zero where it is another.

        ``phase`` (K,) is the number of each sample in its cycle, 0 at its beginning.
        """
        found: list[Any] = []
        if self.at_phase_0:
            found += [chosen_of(one, phase == 0) for one in (centres, area)]
        if self.phases:
            shape, samples = (len(phase), self.phases, self.slices), np.arange(len(phase))
            several = Phases(np.zeros(shape), np.zeros((*shape, 2)))
            several.count[samples, phase] = centres.weight
            several.moved[samples, phase] = centres.relative
            found.append(several)
        return tuple(found)

    def profiles(self, centres: Profile, area: Profile) -> dict[str, np.ndarray]:
        """Return velocity, densities and granular temperature per slice."""
        slab = self.width * self.slice_height
        temperature = centres.temperature()
        return {
            "velocity_profile": centres.velocity(),
            "packing_profile": area.weight / (slab * area.samples[0]),
            "number_density": centres.weight / (slab * centres.samples[0]),
            "granular_temperature_profile": temperature.mean(axis=1),
            "vertical_temperature_profile": temperature[:, 1],
        }

    def tables(self, centres: Profile, phased: Sequence[Any]) -> dict[str, np.ndarray]:
        """Return what is asked for: velocity and densities at the beginning of the cycle, and the
        granular temperature about the mean velocity at each phase."""
        found = {}
        if self.at_phase_0:
            profiles = self.profiles(*phased[:2])
            found = {name: profiles[mean] for name, mean in parts(AT_PHASE_0, "belt").items()}
        if self.phases:
            found["fluctuation_temperature_profile"] = _fluctuation(centres, phased[-1])
        return found


def _fluctuation(centres: Profile, phases: Phases) -> np.ndarray:
    """Return the granular temperature (H,) (m²/s²) about the mean velocities at all phases.

    The sum of squares about these means, one freedom less for each of them, so that beads of few
    samples do not count as cold; not-a-number where nothing is left.
    """
    count = phases.count[..., None]
    mean = np.divide(phases.moved, count, out=np.zeros_like(phases.moved), where=count > 0)
    about = centres.squared - (mean * phases.moved).sum(axis=0)
    freedom = centres.weight - (phases.count > 0).sum(axis=0)
    found = np.full(len(freedom), np.nan)
    return np.divide(about.mean(axis=1), freedom, out=found, where=freedom > 0)


def bed_profiles(p: BeltParameters) -> BedProfiles:
    """Return the slices of a point."""
    return BedProfiles(
        max(1, round(HEIGHT / p.slice_height)),
        p.slice_height * p.diameter,
        p.width * p.diameter,
        p.phase_0_profiles,
        p.samples_per_cycle if p.fluctuation_profiles else 0,
    )
