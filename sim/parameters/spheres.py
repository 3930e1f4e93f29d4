"""Parameters of spheres on a plane, common to chute and conveyor."""

import math
from typing import TYPE_CHECKING, Any, ClassVar, Literal

from sim.base.additions import attribute_errors_to, plain_name
from sim.base.plugins import module_names
from sim.parameters import roles
from sim.parameters.common import CHOICES, MAX_PARTICLES, Parameters, Real, broken_rule
from sim.parameters.images import largest_diameter, usual_cell, wider_cell
from sim.parameters.roles import declare, numerics, reading

#: Particle-steps per second on one core of a present-day server up to a depth, that depth, and the
#: exponent with which the rate falls above it, as there are more contacts per particle.
RATE = 45.0e6
RATE_DEPTH = 5.0
RATE_EXPONENT = -0.55

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

SlidingDirection = Literal["printed", "slip"]

#: Declaration of ``sliding_direction`` without its default.
SLIDING: dict[str, Any] = {
    "description": "a friction cut to its limit has the direction of the printed sum, which does "
    "not settle where spheres slip by more than 2 μ F_N/K0 in a step, or that of the old force "
    "and K0 times all of the slip, which settles along the slip",
    "equation": "Walton, Sec. 2.2",
    "role": "reading",
    "compiled": True,
}


class SphereParameters(Parameters):
    """Particles that rotate and slide on a plane.

    Lengths in diameters; a concrete system adds ``angle``, ``initial_velocity`` and the lengths of
    a run.
    """

    state_numbers: ClassVar[int] = 9
    axes: ClassVar[int] = 3
    # Twelve neighbors of equal size, and more where sizes differ or overlaps are large.
    most_contacts: ClassVar[int] = 10
    smallest_values: ClassVar[dict[str, Any]] = {"depth": 0.2, "cell": 5}
    fixed_parameters: ClassVar[tuple[str, ...]] = (
        *("seed", "depth", "cell", "diameter", "diameter_spread", "mass"),
        *("bumps", "bump_coverage", "bump_arrangement"),
        *("restitution", "stiffness", "law", "tangential_ratio", "tangential_exponent"),
        *("attraction", "tangential_unloading"),
        *("overlap_memory", "initial_packing", "orientations", "threads", "engine"),
    )

    depth: Real = declare(
        5,
        symbol="n",
        description="depth of the flow: particles per squared diameter of plane",
        equation="Walton, Sec. 3: n = N/σ²",
        id_part="depth",
        gt=0,
    )
    friction: Real = declare(
        0.4,
        symbol="μ",
        description="friction coefficient between particles",
        equation="Walton, Sec. 2.2: |T| ≤ μ F_N",
        id_part="friction",
        ge=0,
    )
    friction_plane: Real = declare(
        symbol="μ_p",
        unit="1",
        description="friction coefficient between particles and plane (omitted: friction)",
        equation="Walton, Sec. 3",
        ge=0,
        default_factory=lambda values: values["friction"],
    )
    restitution: Real = declare(
        0.85,
        symbol="e",
        description="normal coefficient of restitution, the same at every impact velocity",
        equation="Walton, Sec. 2.1: e = √(K1/K2)",
        id_part="restitution",
        ge=0.001,
        le=1,
    )
    stiffness: Real = declare(
        100,
        symbol="K1",
        unit="N m-1",
        description="normal stiffness in loading",
        equation="Walton, Sec. 2.1: F_N = K1 α",
        id_part="stiffness",
        gt=0,
    )
    law: LawName = reading(
        "walton_braun",
        # The laws that are declared say what they are.
        description="contact law",
        compiled=True,
    )
    tangential_ratio: Real = reading(
        0.8,
        symbol="K0/K1",
        description="initial tangential stiffness relative to the normal stiffness",
        equation="Walton, Eq. 1",
        gt=0,
    )
    shear_damping: Real = roles.shear_damping(
        description="shear friction coefficient of law: drag", added=True
    )
    attraction: Literal["kept", "clipped"] = declare(
        "kept",
        description="a dashpot that would pull at the end of a contact does so, or the normal "
        "force is then 0; the restitution is the same",
        compiled=True,
        added=True,
    )
    tangential_unloading: Literal["kept", "rescaled"] = declare(
        "kept",
        description="the tangential force of law: hertz stays while a contact unloads, or falls "
        "with the stiffness of its spring",
        compiled=True,
        added=True,
    )
    tangential_exponent: Real = reading(
        1 / 3,
        symbol="γ",
        description="exponent of the tangential stiffness (0: linear spring)",
        equation="Walton, Eq. 1",
        compiled=True,
        ge=0,
    )
    diameter: Real = declare(
        1e-3,
        symbol="σ",
        unit="m",
        description="diameter of a particle",
        equation="Walton, Sec. 3",
        gt=0,
    )
    mass: Real = declare(
        1.492e-6,
        symbol="m",
        unit="kg",
        description="mass of a particle",
        equation="Walton, Sec. 3",
        gt=0,
    )
    diameter_spread: Real = declare(
        0,
        symbol="Δσ/σ",
        scale="σ",
        description="half width of the uniform distribution of diameters, which are scaled so that "
        "the mean mass is mass (the paper: 0)",
        equation="Walton, Sec. 3",
        ge=0,
        le=0.5,
    )
    bumps: Real = declare(
        0,
        symbol="d_b",
        scale="σ",
        description="diameter of the spheres glued to the plane (0: none)",
        equation="Walton, Sec. 3: various degrees of roughness",
        ge=0,
        le=3,
    )
    cell: Real = numerics(
        symbol="L",
        scale="σ",
        description="side of the periodic cell (omitted: 10 up to depth 10; above, 5, and 8 with "
        "bumps)",
        equation="Walton, Sec. 3, Figs. 1.1-1.6",
        changes_start=True,
        ge=3,
        default_factory=lambda values: usual_cell(values["depth"], values["bumps"]),
    )
    bump_coverage: Real = declare(
        0.4,
        symbol="c_b",
        description="share of the plane that the glued spheres cover, seen from above",
        ge=0.01,
        le=0.45,
    )
    bump_arrangement: Literal["random", "ordered"] = declare(
        "random",
        description="glued spheres lie at random places, or on a square lattice along x and y, of "
        "as many as come nearest to the coverage",
        equation="Walton, Sec. 3: various degrees of roughness",
        added=True,
    )
    gravity: Real = roles.gravity(9.8, equation="Walton, Sec. 3")
    initial_packing: Real = numerics(
        0.32,
        symbol="φ0",
        description="packing fraction of the random initial state",
        equation="Walton, Sec. 1: 0.4 or less",
        ge=0.001,
        le=0.35,
    )
    initial_agitation: Real = numerics(
        0.1,
        symbol="u0",
        scale="√(gσ)",
        description="root mean square of the random initial velocities",
        equation="Walton, Sec. 1",
        ge=0,
    )
    steps_per_collision: int = numerics(
        40,
        symbol="t_c/Δt",
        description="time steps in one binary collision",
        equation="t_c = (π/2) √(m/2K1) (1 + e)",
        ge=10,
        le=1000,
    )
    slice_height: Real = numerics(
        0.25,
        symbol="Δz",
        scale="σ",
        description="height of the slices of the profiles",
        equation="Walton, Figs. 1.1-1.6",
        ge=0.01,
    )
    stress_profiles: bool = roles.extra(
        description="also keep profiles of stress, spin and slip, and how the profiles change with "
        "time",
        compiled=True,
    )
    overlap_limit: Real = numerics(
        0.25,
        symbol="α_lim",
        scale="σ",
        description="overlap at which the run stops as unphysical (0.25: half a radius)",
        gt=0,
        le=0.95,
    )
    orientations: bool = numerics(
        True,
        description="follow the orientations of the particles (changes no trajectory)",
        equation="Walton, Sec. 2",
        compiled=True,
    )
    threads: int = numerics(
        1,
        description="threads of one run (pays from some thousand particles on); the bits of the "
        "result depend on their number",
        ge=1,
        le=256,
    )
    overlap_memory: Literal["separation", "shrink", "reset"] = reading(
        "separation",
        description="the largest overlap of a contact is remembered until the particles separate, "
        "shrinks with the overlap once the force is zero, or is reset when the force is zero",
        equation="Walton, Sec. 2.1: α0",
        compiled=True,
    )
    friction_cap: Literal["before", "after"] = reading(
        "before",
        description="a tangential force above the friction limit is cut before or after the "
        "tangential stiffness is evaluated",
        equation="Walton, Sec. 2.2",
        compiled=True,
    )

    sliding_direction: SlidingDirection = declare("printed", added=True, **SLIDING)

    # No numerical parameter: what two programs computed is not one flow until it is shown to be.
    engine: EngineName = declare(
        "talus",
        # The engines that are declared say what they are.
        description="program that computes the flow",
        compiled=True,
        added=True,
    )
    ranks: int = numerics(
        1, description="processes of one run of another engine, by MPI", added=True, ge=1, le=4096
    )

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
    def lightest_mass(self) -> float:
        """Mass of the lightest particles, kg."""
        spread = self.diameter_spread
        return self.mass * (1 - spread) ** 3 / (1 + spread**2)

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
        return max(1, round(self.depth * self.cell * self._breadth))

    @property
    def glued_particles(self) -> int:
        """Number of spheres glued to the plane, from the share of it that they cover."""
        if not self.bumps:
            return 0
        if self.bump_arrangement == "ordered":
            return self.bump_rows ** (1 if self.is_flat else 2)
        return max(1, round(self.bump_coverage * self._area / self._bump_area))

    @property
    def bump_rows(self) -> int:
        """Glued spheres in a row of an ordered arrangement, where they do not overlap."""
        number = self.bump_coverage * self._area / self._bump_area
        rows = round(number if self.is_flat else number**0.5)
        return max(1, min(rows, math.floor(self.cell / self.bumps)))

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
    def is_flat(self) -> bool:
        """True where all particles lie in one plane, y = 0."""
        return False

    @property
    def _breadth(self) -> float:
        """Side of the cell across the flow, in diameters."""
        return self.cell

    @property
    def _area(self) -> float:
        return self.cell * self._breadth

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
        overlap = speed * math.sqrt(0.5 * self.mass / self.stiffness) / self.diameter
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
        return speed * RATE * (max(RATE_DEPTH, self.depth) / RATE_DEPTH) ** RATE_EXPONENT

    @property
    def refusals(self) -> list[tuple[str, str]]:
        """What the engine cannot do of the point: parameters, and what they may be in words."""
        with attribute_errors_to("engine", plain_name(self.engine)):
            return list(self.option("engine").refuses(self))

    def require_rules(self) -> None:
        """Raise for values that do not go together."""
        super().require_rules()
        for name, allowed in self.refusals:
            allowed += f" with engine: {plain_name(self.engine)}"
            raise broken_rule(name, getattr(self, name), allowed)
        if self.option("law").one_mass:
            for name in ("diameter_spread", "bumps"):
                if getattr(self, name):
                    raise broken_rule(name, getattr(self, name), f"0 with law: {self.law}")
        if self.bump_arrangement != "random" and not self.bumps:
            allowed = "random, unless there are bumps"
            raise broken_rule("bump_arrangement", self.bump_arrangement, allowed)
        largest = largest_diameter(self.diameter_spread, self.is_flat)
        if allowed := wider_cell(self.cell, largest, self.bumps):
            raise broken_rule("cell", self.cell, allowed)
        if not self.depth * self._area <= MAX_PARTICLES:
            allowed = f"a value that gives at most {MAX_PARTICLES:.0e} particles in the cell"
            raise broken_rule("depth", self.depth, allowed)
        room = (MAX_PARTICLES - self.particles) * self._bump_area
        has_room = not self.bumps or self.bump_coverage * self._area <= room
        if not (has_room and self.effective_particles <= MAX_PARTICLES):
            allowed = (
                f"a value that gives at most {MAX_PARTICLES:.0e} particles, glued ones included; "
                "dense ones count more"
            )
            raise broken_rule("bumps", self.bumps, allowed)
