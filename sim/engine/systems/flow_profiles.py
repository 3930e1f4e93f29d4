"""Profiles of a flow on a plane over the height: those of every run, and those on request."""

from math import ceil, pi
from typing import Any, NamedTuple

import numpy as np

from sim.engine.observe.contacts import XX, XZ, YY, ZZ, Slip, Stress, no_slip, no_stress
from sim.engine.observe.force_balance import inertial_number, shear_rate, stress_ratio
from sim.engine.observe.overlaps import no_overlaps
from sim.engine.observe.profiles import Profile, empty_profile
from sim.engine.observe.sums import Sums
from sim.parameters.spheres import SphereParameters

#: Names of the components of the stress.
STRESSES = {
    "longitudinal_stress": XX,
    "transverse_stress": YY,
    "normal_stress": ZZ,
    "shear_stress": XZ,
}


class FlowProfiles(NamedTuple):
    """How a flow is cut into ``slices`` of ``slice_height`` (m) above an ``area`` (m²).

    ``gravity`` (m/s²) is that normal to the plane; the particles have a ``diameter`` (m) and are
    of a material with a ``density`` (kg/m³). Sums are the profile and the overlaps; where
    ``stress`` is true, the profile of the spin, stress and slip follow. For discs, whose profile is
    weighted by area instead of volume, ``area`` is the length of the cell (m).
    """

    slices: int
    slice_height: float
    area: float
    gravity: float
    diameter: float
    density: float
    stress: bool

    def height(self) -> np.ndarray:
        """Return the centres of the slices, m."""
        return (np.arange(self.slices) + 0.5) * self.slice_height

    def empty(self) -> Sums:
        """Return sums of zero."""
        base_sums = empty_profile(self.slices, 3), no_overlaps()
        if not self.stress:
            return base_sums
        return (
            *base_sums,
            empty_profile(self.slices, 1),
            no_stress(self.slices),
            no_slip(self.slices),
        )

    def profiles(self, sums: Any) -> dict[str, np.ndarray]:
        """Return velocity, packing fraction and granular temperature per slice."""
        profile, slab = sums[0], self.area * self.slice_height
        temperature = profile.temperature()
        return {
            "velocity_profile": profile.velocity(),
            "packing_profile": profile.weight / (slab * profile.samples[0]),
            "granular_temperature_profile": temperature.mean(axis=1),
            "vertical_temperature_profile": temperature[:, 2],
        }

    def tables(self, sums: Any) -> dict[str, np.ndarray]:
        """Return the histogram of overlaps and, if requested, profiles of contacts and rheology."""
        profile, overlaps, *contact_sums = sums
        histogram = {"overlap_histogram": overlaps.counts}
        return histogram | (self._contact_tables(profile, *contact_sums) if contact_sums else {})

    def _contact_tables(
        self, profile: Profile, spin: Profile, stress: Stress, slip: Slip
    ) -> dict[str, np.ndarray]:
        """Return stress, rheology, spin, slip and dissipation per slice."""
        slab = self.area * self.slice_height
        contact, kinetic = stress.contact(slab), stress.kinetic(slab)
        weight = self.gravity * stress.above / (self.area * stress.samples[0])
        tables = {"overburden_profile": weight, "spin_profile": spin.velocity()}
        for name, component in STRESSES.items():
            tables[f"contact_{name}_profile"] = contact[:, component]
            tables[f"kinetic_{name}_profile"] = kinetic[:, component]
        with np.errstate(invalid="ignore", divide="ignore"):
            tables["sliding_share_profile"] = slip.sliding / slip.contacts
            tables["slip_velocity_profile"] = slip.speed / slip.sliding
        volume = slab * stress.samples[0]
        tables["normal_dissipation_profile"] = slip.lost / volume
        tables["frictional_dissipation_profile"] = slip.rubbed / volume
        normal = contact[:, ZZ] + kinetic[:, ZZ]
        rate = shear_rate(profile.velocity(), self.slice_height, self.diameter)
        tables["stress_ratio_profile"] = stress_ratio(contact[:, XZ] + kinetic[:, XZ], normal)
        tables["inertial_number_profile"] = inertial_number(
            rate, normal, self.diameter, self.density
        )
        return tables


def flow_profiles(p: SphereParameters, depth: float, area: float, gravity: float) -> FlowProfiles:
    """Return the slices of a point for a layer of an initial ``depth`` (m)."""
    slice_height = p.slice_height * p.diameter
    return FlowProfiles(
        ceil((1.5 * depth + 10.0 * p.diameter) / slice_height),
        slice_height,
        area,
        gravity,
        p.diameter,
        density=p.mass / (pi / 6.0 * p.diameter**3),
        stress=p.stress_profiles,
    )
