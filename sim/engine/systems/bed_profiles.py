"""Profiles of the bed over the height above the belt, at all times and as the cycle begins."""

from typing import NamedTuple

import numpy as np

from sim.engine.observe.arrays import AT_PHASE_0, PHASED
from sim.engine.observe.profiles import Profile, empty_profile
from sim.engine.observe.sums import Sums, chosen_of
from sim.parameters import BeltParameters

#: Height of the profiles in mean diameters.
HEIGHT = 80


class BedProfiles(NamedTuple):
    """How the bed is cut into ``slices`` of ``slice_height`` (m) and of ``width`` (m).

    Sums are profiles by centres and by area. Where ``at_phase_0`` is true, as many follow of the
    beginning of the cycle alone.
    """

    slices: int
    slice_height: float
    width: float
    at_phase_0: bool

    def height(self) -> np.ndarray:
        """Return the centres of the slices above the belt, m."""
        return (np.arange(self.slices) + 0.5) * self.slice_height

    def empty(self) -> Sums:
        """Return sums of zero."""
        return tuple(empty_profile(self.slices, 2) for _ in range(4 if self.at_phase_0 else 2))

    def of_starts(self, centres: Profile, area: Profile, starts: np.ndarray) -> Sums:
        """Return the profiles of several samples where they begin a cycle, zero elsewhere.

        ``starts`` (K,) says which do; nothing is returned where it is not kept.
        """
        return (chosen_of(centres, starts), chosen_of(area, starts)) if self.at_phase_0 else ()

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

    def phased(self, *starts: Profile) -> dict[str, np.ndarray]:
        """Return velocity and densities at the beginning of the cycle, if they are kept."""
        if not starts:
            return {}
        profiles = self.profiles(*starts)
        return {name + AT_PHASE_0: profiles[name] for name in PHASED}


def bed_profiles(p: BeltParameters) -> BedProfiles:
    """Return the slices of a point."""
    return BedProfiles(
        max(1, round(HEIGHT / p.slice_height)),
        p.slice_height * p.diameter,
        p.width * p.diameter,
        p.phase_0_profiles,
    )
