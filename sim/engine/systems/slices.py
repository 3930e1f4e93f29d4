"""How profiles cut a flow on a plane and a bed on the belt, those of every run and on request."""

from math import ceil, pi
from typing import Any, NamedTuple

import numpy as np

from sim.engine.observe.contacts import XX, XZ, YY, ZZ, Slip, Stress, no_slip, no_stress
from sim.engine.observe.force_balance import inertial_number, shear_rate
from sim.engine.observe.profiles import Profile, Squares, empty_profile, no_overlaps, ratio, squares
from sim.engine.observe.samples import Sums, mask_samples
from sim.parameters import BeltParameters
from sim.parameters.spheres import SphereParameters
from sim.parameters.variables import AT_PHASE_0, parts

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
        tables["stress_ratio_profile"] = ratio(contact[:, XZ] + kinetic[:, XZ], normal)
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

    Sums are profiles by centres and by area, and the field in the ``squares``. Where ``at_phase_0``
    is true, the same two profiles follow for the beginning of the cycle alone. Where ``phases`` is
    not 0, sums of so many phases follow.
    """

    slices: int
    slice_height: float
    width: float
    squares: Squares
    at_phase_0: bool
    phases: int

    def empty(self) -> Sums:
        """Return sums of zero."""
        profiles = [empty_profile(self.slices, 2) for _ in range(4 if self.at_phase_0 else 2)]
        shape = (self.phases, self.slices)
        phases = (Phases(np.zeros(shape), np.zeros((*shape, 2))),) if self.phases else ()
        return *profiles[:2], self.squares.empty(), *profiles[2:], *phases

    def phase_sums(self, centres: Profile, area: Profile, phase: np.ndarray) -> Sums:
        """Return the requested sums per sample, zero for samples of other phases.

        ``phase`` (K,) is the number of each sample in its cycle, 0 at its beginning.
        """
        sums: list[Any] = []
        if self.at_phase_0:
            sums += [mask_samples(profile, phase == 0) for profile in (centres, area)]
        if self.phases:
            shape, samples = (len(phase), self.phases, self.slices), np.arange(len(phase))
            phase_sums = Phases(np.zeros(shape), np.zeros((*shape, 2)))
            phase_sums.count[samples, phase] = centres.weight
            phase_sums.moved[samples, phase] = centres.relative
            sums.append(phase_sums)
        return tuple(sums)

    def profiles(self, sums: Any) -> dict[str, np.ndarray]:
        """Return velocity, densities and granular temperature per slice."""
        (centres, area), slab = sums[:2], self.width * self.slice_height
        temperature = centres.temperature()
        return {
            "velocity_profile": centres.velocity(),
            "packing_profile": area.weight / (slab * area.samples[0]),
            "number_density": centres.weight / (slab * centres.samples[0]),
            "granular_temperature_profile": temperature.mean(axis=1),
            "vertical_temperature_profile": temperature[:, 1],
        }

    def tables(self, sums: Any) -> dict[str, np.ndarray]:
        """Return the means in the squares and the requested tables.

        These are velocity and densities at the beginning of the cycle, and the granular temperature
        about the mean velocity at each phase.
        """
        centres, _, field, *phased = sums
        tables = self.squares.tables(field)
        if self.at_phase_0:
            profiles = self.profiles(phased)
            tables |= {name: profiles[mean] for name, mean in parts(AT_PHASE_0, "belt").items()}
        if self.phases:
            tables["fluctuation_temperature_profile"] = _fluctuation_temperature(
                centres, phased[-1]
            )
        return tables


def _fluctuation_temperature(centres: Profile, phases: Phases) -> np.ndarray:
    """Return the granular temperature (H,) (m²/s²) about the mean velocities at all phases.

    It is the sum of squares about these means over the degrees of freedom, one less for each
    mean, so beads of few samples do not count as cold. It is not-a-number without a degree of
    freedom.
    """
    count = phases.count[..., None]
    mean = np.divide(phases.moved, count, out=np.zeros_like(phases.moved), where=count > 0)
    squares = centres.squared - (mean * phases.moved).sum(axis=0)
    freedom = centres.weight - (phases.count > 0).sum(axis=0)
    return ratio(squares.mean(axis=1), freedom)


def bed_profiles(p: BeltParameters) -> BedProfiles:
    """Return the slices of a point."""
    return BedProfiles(
        max(1, round(HEIGHT / p.slice_height)),
        p.slice_height * p.diameter,
        p.width * p.diameter,
        squares(p.width * p.diameter, p.diameter, p.amplitude),
        p.phase_0_profiles,
        p.samples_per_cycle if p.fluctuation_profiles else 0,
    )
