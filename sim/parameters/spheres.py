"""Parameters of spheres on a plane, common to chute and conveyor."""

import math
from typing import TYPE_CHECKING, Any, ClassVar, Literal

from pydantic import model_validator

from sim.base.additions import attribute_errors_to, plain_name
from sim.base.plugins import module_names
from sim.parameters.common import (
    CHOICES,
    MAX_PARTICLES,
    Parameters,
    Real,
    broken_rule,
    canonical_number,
    given_sizes,
)
from sim.parameters.dashpot import damping_ratio, restitution_of
from sim.parameters.images import (
    LEAST_CELL,
    LEAST_SIDE,
    SIDES,
    largest_diameter,
    spheres_in_slice,
    usual_cell,
    wider_cell,
)
from sim.parameters.roles import rows_of
from sim.parameters.schedule import Schedule, require_schedule, with_ends

row = rows_of("spheres")

#: Particle-steps per second on one core of a present-day server up to a depth, the depths between
#: which the rate falls, as there are more contacts per particle, and its exponent there.
RATE = 45.0e6
RATE_DEPTHS = 3.0, 20.0
RATE_EXPONENT = -0.66

#: Largest overlap of an impact, in diameters, at which laws of small overlaps are valid: twice that
#: of the paper's softest spheres.
SMALL_OVERLAP = 0.1

_OVERLAP_CAVEAT = (
    f"overlap by more than {100 * SMALL_OVERLAP:g} % of a diameter, beyond the range of the "
    "contact law; a larger stiffness cures it"
)

#: Largest relative difference of the depth of whole particles from the requested one without a
#: caveat.
DEPTH_TOLERANCE = 0.01

_DEPTH_CAVEAT = (
    "whole particles in the cell have a depth that differs by more than "
    f"{100 * DEPTH_TOLERANCE:g} % from the one asked for; a wider cell cures it"
)

#: Largest share of a slip that a tangential damping may take in a time step, for one contact of a
#: body that does not turn; 3.5 times that of a sphere.
MOST_DAMPING = 0.2

#: Skin of the neighbor list, in diameters, and the usual number of neighbors of a sphere in it.
SKIN, USUAL_NEIGHBORS = 0.2, 8

if TYPE_CHECKING:
    LawName = str
    EngineName = str
else:
    #: Names of the laws that ship, those of their files, the default first. Motions have a folder.
    _NAMES = dict.fromkeys((CHOICES["law"], *module_names("sim.laws")))
    LawName = Literal[tuple(name for name in _NAMES if name != "motions")]
    EngineName = Literal[tuple(dict.fromkeys((CHOICES["engine"], *module_names("sim.engines"))))]

#: Parameters of the random initial state alone.
DRAWN = ("initial_packing", "initial_agitation", "initial_height", "diameter_spread")

SlidingDirection = Literal["printed", "slip"]


class SphereParameters(Parameters):
    """Particles that rotate and slide on a plane.

    Lengths in diameters; a concrete system adds ``angle``, ``initial_velocity`` and the lengths of
    a run. Parameters in ``driven`` may have a schedule.
    """

    driven: ClassVar[tuple[str, ...]] = ("angle",)

    state_numbers: ClassVar[int] = 9
    axes: ClassVar[int] = 3
    pairs: ClassVar[frozenset[str]] = frozenset({"cell"})
    # Twelve neighbors of equal size, and more where sizes differ or overlaps are large.
    most_contacts: ClassVar[int] = 10
    smallest_values: ClassVar[dict[str, Any]] = {"depth": 0.2, "cell": 5}
    if TYPE_CHECKING:
        angle: float = 0.0
        initial_velocity: float = 0.0

    depth: Real = row("depth")
    friction: Real = row("friction")
    friction_plane: Real = row("friction_plane", default_factory=lambda values: values["friction"])
    restitution: Real = row("restitution")
    stiffness: Real = row("stiffness")
    law: LawName = row("law")
    tangential_ratio: Real = row("tangential_ratio")
    shear_damping: Real = row("shear_damping")
    normal_damping: Real = row("normal_damping")
    tangential_damping: Real = row("tangential_damping")
    attraction: Literal["kept", "clipped"] = row("attraction")
    tangential_unloading: Literal["kept", "rescaled"] = row("tangential_unloading")
    youngs_modulus: Real = row("youngs_modulus")
    poisson_ratio: Real = row("poisson_ratio")
    tangential_exponent: Real = row("tangential_exponent")
    diameter: Real = row("diameter")
    mass: Real = row("mass")
    diameter_spread: Real = row("diameter_spread")
    bumps: Real = row("bumps")
    cell: Real = row(
        "cell",
        default_factory=lambda values: usual_cell(
            0 if values["initial_state"] else values["depth"], values["bumps"]
        ),
    )
    cell_across: Real = row("cell_across")
    bump_coverage: Real = row("bump_coverage")
    bump_arrangement: Literal["random", "ordered", "packing"] = row("bump_arrangement")
    gravity: Real = row("gravity")
    schedule: Schedule = row("schedule", default="")
    initial_packing: Real = row("initial_packing")
    initial_agitation: Real = row("initial_agitation")
    initial_height: Real = row("initial_height")
    initial_normal_velocity: Real = row("initial_normal_velocity")
    steps_per_collision: int = row("steps_per_collision")
    slice_height: Real = row("slice_height")
    stress_profiles: bool = row("stress_profiles")
    overlap_limit: Real = row("overlap_limit")
    orientations: bool = row("orientations")
    threads: int = row("threads")
    overlap_memory: Literal["separation", "shrink", "reset"] = row("overlap_memory")
    friction_cap: Literal["before", "after"] = row("friction_cap")
    sliding_direction: SlidingDirection = row("sliding_direction")

    # No numerical parameter: what two programs computed is not one flow until it is shown to be.
    engine: EngineName = row("engine")
    ranks: int = row("ranks")

    @model_validator(mode="before")
    @classmethod
    def _split_cell(cls, values: Any) -> Any:
        """Return the values with both sides of a cell apart; those of a square one are one number.

        Raises for a list beside ``cell_across``, or of another length than two.
        """
        if not isinstance(values, dict) or "cell" not in values:
            return values
        sides = values["cell"]
        if isinstance(sides, list | tuple):
            if len(sides) != 2 or "cell_across" in values:
                raise broken_rule("cell", sides, SIDES)
            values = values | dict(zip(("cell", "cell_across"), sides, strict=True))
        across = canonical_number(values.get("cell_across", 0))
        is_square = across == canonical_number(values["cell"])
        return values | {"cell_across": 0.0} if is_square else values

    @model_validator(mode="before")
    @classmethod
    def _end_schedule(cls, values: Any) -> Any:
        return with_ends(values, cls.driven)

    @classmethod
    def hint(cls, key: str, value: Any) -> str:
        """Return a hint on a wrong value of a parameter, or an empty text."""
        if key == "law" and isinstance(value, str):
            return "a plug-in's, where plugins of the study or TALUS_PLUGINS name the plug-in"
        return ""

    @property
    def collision_time(self) -> float:
        """Duration of the shortest collision, s, as the law of the point gives it."""
        law = self.option("law")
        with attribute_errors_to("law", plain_name(self.law)):
            time = float(law.collision_time(self))
            if not 0 < time < math.inf:
                raise ValueError(f"a collision takes {time} s")
        return time

    @property
    def law_reach(self) -> float:
        """How far beyond contact the law of the point acts, m."""
        with attribute_errors_to("law", plain_name(self.law)):
            reach = float(self.option("law").reach(self))
            if not 0 <= reach < math.inf:
                raise ValueError(f"it reaches {reach} m beyond contact")
        return reach

    @property
    def lightest_mass(self) -> float:
        """Mass of the lightest particles, kg."""
        if self.initial_state:
            return self.mass * given_sizes(self).lightest
        spread = self.diameter_spread
        return self.mass * (1 - spread) ** 3 / (1 + spread**2)

    @property
    def smallest_diameter(self) -> float:
        """Diameter of the smallest particles, m."""
        if self.initial_state:
            return self.diameter * given_sizes(self).smallest
        return self.diameter * (1 - self.diameter_spread)

    @property
    def is_alike(self) -> bool:
        """True where nothing of the initial state is random, bumps included."""
        return super().is_alike and not (self.bumps and self.bump_arrangement != "ordered")

    @property
    def heaviest_mass(self) -> float:
        """Mass of the heaviest particles, kg."""
        if self.initial_state:
            return self.mass * given_sizes(self).heaviest
        spread = self.diameter_spread
        return self.mass * (1 + spread) ** 3 / (1 + spread**2)

    @property
    def has_one_mass(self) -> bool:
        """True where all particles have the mass of the point, and none is glued to the plane."""
        sizes = given_sizes(self)
        return not (self.bumps or self.diameter_spread) and sizes.lightest == sizes.heaviest == 1

    @property
    def normal_stiffness(self) -> float:
        """Stiffness K1, N/m; under Young's modulus that of Hertz's spring at an overlap of σ/100.

        (4/3) E* √(σ/4) (σ/100)^(3/2) = K1 σ/100, with E* = E/(2 (1 - ν²)).
        """
        if not self.youngs_modulus:
            return self.stiffness
        return self.youngs_modulus / (2 * (1 - self.poisson_ratio**2)) * self.diameter / 15

    @property
    def tangential_share(self) -> float:
        """Tangential over normal stiffness; under Young's modulus 2 (1 - ν)/(2 - ν)."""
        nu = self.poisson_ratio
        return 2 * (1 - nu) / (2 - nu) if self.youngs_modulus else self.tangential_ratio

    @property
    def replaced(self) -> frozenset[str]:
        """Names of the parameters without effect, as others stand in their place."""
        pairs = self.option("law").replaces.items()
        return frozenset(name for key, names in pairs if getattr(self, key) for name in names)

    @property
    def restitutions(self) -> dict[str, float]:
        """Restitutions that a damping of the point gives spheres of the mean mass, by partner."""
        if not self.normal_damping:
            return {}
        masses = {"another": 0.5 * self.mass, "what is fixed": self.mass}
        rate, attraction = self.normal_damping, self.attraction
        return {
            name: restitution_of(damping_ratio(rate, self.stiffness, mass), attraction)
            for name, mass in masses.items()
        }

    @property
    def loading_time(self) -> float:
        """Time for which two of the lightest particles press a spring K1, s.

        (π/2) √(m*/K1), with m* = m/2.
        """
        return math.pi / 2 * math.sqrt(self.lightest_mass / 2 / self.stiffness)

    @property
    def period(self) -> float:
        """Length of the periodic cell along x, m."""
        return self.cell * self.diameter

    @property
    def particles(self) -> int:
        """Particles in the cell: depth times the cell's area in squared diameters."""
        return max(1, round(self.depth * self.cell * self.breadth))

    @property
    def glued_particles(self) -> int:
        """Number of spheres glued to the plane, from the share of it that they cover."""
        if not self.bumps:
            return 0
        if self.bump_arrangement == "ordered":
            return math.prod(self.bump_rows)
        if self.bump_arrangement == "packing":
            return spheres_in_slice(self.cell / self.bumps, self.breadth / self.bumps)
        return max(1, round(self.bump_coverage * self._area / self._bump_area))

    @property
    def bump_rows(self) -> tuple[int, ...]:
        """Glued spheres in a row of an ordered arrangement along x and y, without overlap."""
        number = self.bump_coverage * self._area / self._bump_area
        if self.is_flat:
            return (max(1, min(round(number), math.floor(self.cell / self.bumps))),)
        ratio = self.cell / self.breadth
        return tuple(
            max(1, min(round((number * share) ** 0.5), math.floor(side / self.bumps)))
            for side, share in ((self.cell, ratio), (self.breadth, 1 / ratio))
        )

    @property
    def effective_particles(self) -> float:
        """Number of moving spheres with the same work and memory as moving and glued ones.

        Glued spheres count by their pairs in the neighbor list, at least 1: small ones are dense.
        """
        reach = self.bumps + SKIN
        area = 2 * reach if self.is_flat else math.pi * reach**2
        pairs = 0.5 * area * self.glued_particles / self._area
        return self.particles + self.glued_particles * max(1.0, pairs / USUAL_NEIGHBORS)

    @property
    def breadth(self) -> float:
        """Side of the cell across the flow, in diameters."""
        return self.cell_across or self.cell

    @property
    def _area(self) -> float:
        return self.cell * self.breadth

    @property
    def _bump_area(self) -> float:
        """Area of a glued sphere's circle in squared diameters; 0 where it underflows."""
        return math.pi / 4 * self.bumps**2

    def caveat_of(self, overlap: float) -> str:
        """Return a warning of an overlap beyond the range of the contact law, or an empty text."""
        return f"spheres {_OVERLAP_CAVEAT}" if overlap > SMALL_OVERLAP else ""

    def _caveat_at(self, speed: float, source: str) -> str:
        """Return warnings of impacts at a speed (m/s) and of the depth, or an empty text.

        Spheres that meet head-on at a speed v overlap by v √(m/2K1), which may be beyond the range
        of the contact law. The depth of whole particles may differ from the requested one.
        """
        overlap = speed * math.sqrt(0.5 * self.mass / self.normal_stiffness) / self.diameter
        is_large = overlap > self.option("law").max_overlap
        caveats = [f"impacts at {source} {_OVERLAP_CAVEAT}"] if is_large else []
        if (
            abs(self.particles - self.depth * self._area)
            > DEPTH_TOLERANCE * self.depth * self._area
        ):
            caveats.append(_DEPTH_CAVEAT)
        return "; ".join(caveats)

    @property
    def cores(self) -> int:
        """Cores that a run can keep busy: one per thread or process."""
        return self.threads * self.ranks

    @property
    def rate(self) -> float:
        """Particle-steps per second, about."""
        speed = self.option("engine").speed
        shallow, deep = RATE_DEPTHS
        return speed * RATE * (min(max(shallow, self.depth), deep) / shallow) ** RATE_EXPONENT

    @property
    def refusals(self) -> list[tuple[str, str]]:
        """What the engine cannot do of the point: parameters, and what they may be in words."""
        with attribute_errors_to("engine", plain_name(self.engine)):
            return list(self.option("engine").refuses(self))

    def _require_packing(self) -> None:
        self.require("bump_arrangement", not self.is_flat, "random or ordered with shape: disc")
        self.require_default("bump_coverage", "bump_arrangement is random or ordered")
        least = LEAST_SIDE * self.bumps
        allowed = f"at least {LEAST_SIDE:g} bumps = {least:g} with bump_arrangement: packing"
        for name, side in self._sides.items():
            if side < least:
                raise broken_rule(name, side, allowed)

    @property
    def _sides(self) -> dict[str, float]:
        """Sides of the cell in diameters, by parameter."""
        return {"cell": self.cell, "cell_across": self.cell_across or self.cell}

    def require_rules(self) -> None:
        # Before the rules on time steps, which an impact that never ends would not have.
        self._require_damping()
        super().require_rules()
        require_schedule(self, self.schedule, self.driven)
        for name in DRAWN if self.initial_state else ():
            self.require_default(name, "there is no initial_state")
        most = MOST_DAMPING / self.time_step
        allowed = f"at most {most:.4g}; more steps_per_collision allow more"
        self.require("tangential_damping", self.tangential_damping <= most, allowed)
        for name, allowed in self.refusals:
            allowed += f" with engine: {plain_name(self.engine)}"
            raise broken_rule(name, getattr(self, name), allowed)
        for name in ("diameter_spread", "bumps") if self.option("law").one_mass else ():
            self.require(name, not getattr(self, name), f"0 with law: {plain_name(self.law)}")
        is_possible = self.bumps or self.bump_arrangement == "random"
        self.require("bump_arrangement", is_possible, "random, unless there are bumps")
        if self.bump_arrangement == "packing":
            self._require_packing()
        largest = largest_diameter(self.diameter_spread, self.is_flat)
        is_wide = not 0 < self.cell_across < LEAST_CELL
        self.require("cell_across", is_wide, f"0, or a number >= {LEAST_CELL:g}")
        reach = self.law_reach / self.diameter
        for name, side in self._sides.items():
            if allowed := wider_cell(side, largest, self.bumps, reach):
                raise broken_rule(name, side, allowed)
        allowed = f"a value that gives at most {MAX_PARTICLES:.0e} particles"
        self.require("depth", self.depth * self._area <= MAX_PARTICLES, f"{allowed} in the cell")
        room = (MAX_PARTICLES - self.particles) * self._bump_area
        has_room = not self.bumps or self.bump_coverage * self._area <= room
        has_room = has_room and self.effective_particles <= MAX_PARTICLES
        self.require("bumps", has_room, f"{allowed}, glued ones included; dense ones count more")

    def _require_damping(self) -> None:
        """Raise for values beside those that stand in their place, and for impacts without end."""
        for key, names in self.option("law").replaces.items():
            for name in names if getattr(self, key) else ():
                self.require_default(name, f"{key} is 0, which else stands in its place")
        if not self.youngs_modulus:
            self.require_default("poisson_ratio", "youngs_modulus is given")
        critical = 2 * math.sqrt(self.stiffness / self.heaviest_mass)
        allowed = f"below {critical:.4g}, from where on what meets the plane never leaves it"
        ends = self.attraction != "kept" or self.normal_damping < critical
        self.require("normal_damping", ends, allowed)
