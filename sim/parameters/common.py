"""Parameters of all systems: canonical numbers, lengths of runs, sizes."""

from collections.abc import Mapping
from math import pi
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal, NamedTuple, Self

from annotated_types import Ge, Gt
from pydantic import BaseModel, BeforeValidator, ConfigDict, model_validator
from pydantic.fields import FieldInfo
from pydantic_core import PydanticCustomError

from sim.base.additions import plain_name, shipped
from sim.base.errors import Allowed
from sim.parameters.roles import rows_of

row = rows_of("all")

SIGNIFICANT_DIGITS = 12
MAX_PARTICLES = 10_000_000
MAX_STEPS = 10**12
MAX_SAMPLES = 10**7

#: Largest size of the trajectories of a run in bytes, and bytes of a number in them.
MAX_TRAJECTORY, SINGLE = 2 * 10**9, 4

#: Parameters to which plug-ins add options, with the default of each.
CHOICES = {"law": "walton_braun", "motion": "harmonic", "engine": "talus", "function": ""}

#: Work of a time step beside that of its particles, in particles.
STEP_WORK = 15

#: Magnitudes that double precision carries through every formula without overflow.
SMALLEST, LARGEST = 1e-15, 1e15


def canonical_number(value: Any) -> Any:
    """Round a number to 12 significant digits, so that 0.1 + 0.2 and 0.3 are one value.

    Integers become floats and -0.0 becomes 0.0. Booleans, other non-numbers and numbers too large
    for a float are returned unchanged, for validation to refuse.
    """
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return value
    try:
        return float(f"{value:.{SIGNIFICANT_DIGITS}g}") + 0.0
    except OverflowError:
        return value


Real = Annotated[float, BeforeValidator(canonical_number)]
"""A finite float in canonical form; range constraints act on the rounded value."""


def in_place(name: str) -> FieldInfo:
    """Return the declaration of a key in place of parameters, see `Parameters.in_place`."""
    return FieldInfo.from_annotated_attribute(Real, rows_of("in_place")(name))


#: In a series, the start from the end of the point before.
PREVIOUS = "previous"

#: What is allowed for a range, in words.
TWO_NUMBERS = "two numbers without a unit, the lower one first"


def sphere_volume(diameter: float) -> float:
    """Return the volume of a sphere of a diameter, m³; discs count as spheres."""
    return pi / 6 * diameter**3


def drift_bound(target: float) -> float:
    """Return the change of a velocity over a window, relative to its mean, that counts as a drift.

    A mean known to within ``target`` leaves the change of a steady series uncertain by √12 times as
    much. A smaller change could not be distinguished from zero.
    """
    return min(max(0.1, 5 * target), 0.25)


def broken_rule(key: str, value: Any, allowed: str | Allowed) -> PydanticCustomError:
    """Return the error of a rule on several parameters, reported for ``key``."""
    # In a list, as pydantic would render a text, and not every text of a file can be encoded.
    context = {"key": key, "got": [value], "allowed": allowed}
    return PydanticCustomError("rule", "{allowed}", context)


class Ruled(BaseModel):
    """A model of values that do not all go together."""

    @model_validator(mode="after")
    def _require_rules(self) -> Self:
        self.require_rules()
        return self

    def require_rules(self) -> None:
        """Refuse values that do not go together; a model adds its own rules."""

    def require(self, key: str, holds: object, allowed: str | Allowed) -> None:
        """Refuse the value of a key unless something holds; ``allowed`` says what it may be."""
        if not holds:
            raise broken_rule(key, getattr(self, key), allowed)

    def require_default(self, key: str, unless: str) -> None:
        """Refuse another value of a key than its default, ``unless`` something is."""
        usual = type(self).model_fields[key].default
        text = usual if isinstance(usual, str) else f"{usual:g}"
        self.require(key, getattr(self, key) == usual, f"{text} unless {unless}")


class GivenSizes(NamedTuple):
    """Masses and diameters of given particles over those of the point."""

    lightest: float = 1.0
    smallest: float = 1.0
    heaviest: float = 1.0


def given_sizes(p: "Parameters") -> GivenSizes:
    """Return the sizes that the name of a given state tells."""
    return GivenSizes(*map(float, p.initial_state.split("_")[1:]))


class Parameters(Ruled):
    """Parameters shared by all systems, and the lengths of a run counted in steps.

    Instances are immutable, complete (every omitted parameter has its value) and canonical.
    A concrete system adds ``diameter`` (m), ``mass`` (kg), ``gravity`` (m s⁻²), ``stiffness``,
    ``transient``, ``average``, ``limit`` and ``trajectory`` (multiples of ``time_unit``), the
    properties ``time_unit``, ``time_step``, ``sample_steps``, ``particles``, ``period`` and
    ``rate``, and class variables: ``sampling_key``, the parameter that sets how often samples are
    taken; ``boundaries``, what may change between its regimes; ``smallest_values``, which make a
    run as small and short as possible; ``state_numbers`` of a particle (position and motion) and
    ``most_contacts`` per particle in a frame of a trajectory; and the number of ``axes`` along
    which particles move. ``offered`` are options of plug-ins: parameter → name in points → option.
    ``pairs`` are parameters that files may give as a list of two, which is split into parameters.
    ``in_place`` declares keys that stand in place of parameters in files and calls, see `GIVES`.
    ``is_flow`` is false where a function stands in place of particles.
    """

    model_config = ConfigDict(
        frozen=True, extra="forbid", strict=True, allow_inf_nan=False, validate_default=True
    )
    is_flow: ClassVar[bool] = True
    sampling_key: ClassVar[str]
    boundaries: ClassVar[tuple[str, ...]]
    smallest_values: ClassVar[dict[str, Any]]
    state_numbers: ClassVar[int]
    axes: ClassVar[int]
    most_contacts: ClassVar[int]
    offered: ClassVar[Mapping[str, Mapping[str, Any]]] = {}
    pairs: ClassVar[frozenset[str]] = frozenset()
    in_place: ClassVar[dict[str, FieldInfo]] = {"density": in_place("density")}

    if TYPE_CHECKING:
        # Every concrete system adds these, with its own ranges, defaults and meanings.
        system: str = ""
        diameter: float = 0.0
        mass: float = 0.0
        gravity: float = 0.0
        stiffness: float = 0.0
        transient: float = 0.0
        average: float = 0.0
        limit: float = 0.0
        trajectory: float = 0.0
        overlap_limit: float = 0.0

        @property
        def time_unit(self) -> float: ...
        @property
        def time_step(self) -> float: ...
        @property
        def sample_steps(self) -> int: ...
        @property
        def particles(self) -> int: ...
        @property
        def period(self) -> float: ...
        @property
        def rate(self) -> float: ...
        @property
        def breadth(self) -> float: ...

    seed: int = row("seed")
    replicates: int = row("replicates")
    start_from: str = row(
        "start_from",
        default="",
        pattern=rf"^(|{PREVIOUS}|[a-z]+-[\w.-]+-[0-9a-f]{{8}}|[^\x00-\x1f\x7f]+\.nc)$",
        max_length=1000,
    )
    initial_state: str = row(
        "initial_state",
        default="",
        pattern=r"^(|[^/\\\n]+\.csv|[0-9a-f]{12}(_[0-9.e+-]+){0,3}|[^\n]+\n[\s\S]*)$",
    )
    trajectory_contacts: bool = row("trajectory_contacts")

    # Not an amount: ids of points and names of curves distinguish the protocols.
    protocol: Literal["published", "converged"] = row("protocol")
    target: Real = row("target")

    @classmethod
    def options(cls, choice: str) -> dict[str, Any]:
        """Return the laws or the motions, of Talus and of plug-ins, by their names in points."""
        return {**shipped(choice), **cls.offered.get(choice, {})}

    @classmethod
    def without_effect(cls, values: Mapping[str, Any]) -> set[str]:
        """Return what laws and motions of others have, what is replaced, what the law ignores."""
        used, others = set[str](), set[str]()
        for choice in CHOICES:
            field = cls.model_fields.get(choice)
            for name, option in cls.options(choice).items():
                chosen = values.get(choice, field.default if field else name)
                is_chosen = plain_name(name) == plain_name(chosen)
                (used if is_chosen else others).update((*option.owns, *option.parameters))
                if not is_chosen:
                    continue
                others.update(getattr(option, "ignores", ()))
                pairs = getattr(option, "replaces", {}).items()
                others.update(*(names for key, names in pairs if values.get(key)))
        return others - used

    def option(self, choice: str) -> Any:
        """Return the law or the motion that the point has."""
        return self.options(choice)[getattr(self, choice, CHOICES[choice])]

    @property
    def replaced(self) -> frozenset[str]:
        """Names of the parameters without effect, as others stand in their place."""
        return frozenset()

    @property
    def glued_particles(self) -> int:
        """Number of particles fixed to the boundary, not included in `particles`."""
        return 0

    @property
    def effective_particles(self) -> float:
        """Number of moving particles with the same work and memory as all, fixed ones included."""
        return self.particles + self.glued_particles

    @property
    def ground(self) -> float:
        """Height of what is below the particles when a flow starts, m."""
        return 0.0

    @property
    def is_flat(self) -> bool:
        """True where all particles lie in one plane, y = 0."""
        return self.axes == 2

    @property
    def is_alike(self) -> bool:
        """True where nothing of the initial state is random: all replicates would be equal."""
        return bool(self.initial_state)

    @property
    def is_stable(self) -> bool | None:
        """True where the time step is within the known bound, None without a bound."""
        return None

    @property
    def caveat(self) -> str:
        """Warning to read before trusting a run of this point, or an empty text."""
        return ""

    def caveat_of(self, overlap: float) -> str:
        """Return a further warning for a run with this largest overlap (diameters), or nothing."""
        return ""

    @property
    def limits(self) -> dict[str, tuple[float, str]]:
        """Accelerations (m s⁻²) that a flow is compared with: name -> (value, meaning)."""
        return {}

    @property
    def cores(self) -> int:
        """Cores that a run can keep busy."""
        return 1

    @property
    def settling_steps(self) -> int:
        """Time steps before the first sample, about."""
        return 0

    @property
    def velocity_unit(self) -> float:
        """Velocity √(g·diameter), m s⁻¹."""
        return (self.gravity * self.diameter) ** 0.5

    @property
    def density(self) -> float:
        """Mass of a particle over the volume of the sphere of its diameter, kg m⁻³."""
        return float(canonical_number(self.mass / sphere_volume(self.diameter)))

    def samples_in(self, length: float) -> int:
        """Return the number of samples, rounded, in a length of time."""
        return round(length * self.time_unit / (self.sample_steps * self.time_step))

    @property
    def transient_samples(self) -> int:
        """Samples before averaging starts (the transient rounded to whole samples)."""
        return self.samples_in(self.transient)

    @property
    def average_samples(self) -> int:
        """Samples averaged over (the average rounded to whole samples, at least one)."""
        return max(1, self.samples_in(self.average))

    @property
    def drift(self) -> float:
        """Change of the velocity over the window that counts as a drift, see `drift_bound`."""
        return drift_bound(self.target)

    @property
    def shortest_samples(self) -> int:
        """Samples of the shortest run: transient and average."""
        return self.transient_samples + self.average_samples

    @property
    def longest_samples(self) -> int:
        """Samples of the longest run: the limit of the converged protocol, else the shortest."""
        if self.protocol == "published":
            return self.shortest_samples
        return max(self.shortest_samples, self.samples_in(self.limit))

    @property
    def steps(self) -> int:
        """Time steps of the longest replicate, without the settling of the belt's bed."""
        return self.longest_samples * self.sample_steps

    @property
    def trajectory_samples(self) -> int:
        """Samples from one frame of the trajectory to the next, at least one; 0 without frames."""
        return max(1, self.samples_in(self.trajectory)) if self.trajectory else 0

    @property
    def trajectory_room(self) -> int:
        """Contacts that fit in a frame of the trajectory, 0 where none are stored."""
        has_contacts = self.trajectory and self.trajectory_contacts
        return self.most_contacts * (self.particles + self.glued_particles) if has_contacts else 0

    @property
    def trajectory_frames(self) -> int:
        """Frames of all replicates, of the longest run."""
        if not self.trajectory:
            return 0
        return self.replicates * (self.longest_samples // self.trajectory_samples)

    @property
    def trajectory_bytes(self) -> int:
        """Bytes of these frames, before compression."""
        numbers = (self.particles + self.glued_particles) * self.state_numbers
        numbers += self.trajectory_room * (2 + self.axes)
        return self.trajectory_frames * SINGLE * numbers

    def require_rules(self) -> None:
        allowed = "a point's id or a run file, and previous along a grid or cases of a series"
        self.require("start_from", self.start_from != PREVIOUS, allowed)
        self._require_option_of_parameters()
        allowed = "nothing beside initial_state, which is another start"
        self.require("start_from", not (self.initial_state and self.start_from), allowed)
        allowed = "1 with this initial_state, from which all replicates are alike"
        self.require("replicates", not self.is_alike or self.replicates == 1, allowed)
        self._require_feasible_magnitude()
        self._require_feasible_size()

    def _require_option_of_parameters(self) -> None:
        for choice in CHOICES:
            chosen = getattr(self, choice, "")
            owners: dict[str, list[str]] = {}
            for name, option in self.options(choice).items() if chosen else ():
                for key in (*option.owns, *option.parameters):
                    owners.setdefault(key, []).append(name)
            for key, names in owners.items():
                if key in type(self).model_fields and chosen not in names:
                    owner = " or ".join(map(plain_name, names))
                    self.require_default(key, f"{choice} is {owner}, whose it is")

    def _require_feasible_magnitude(self) -> None:
        for name, field in type(self).model_fields.items():
            if isinstance(value := getattr(self, name), float):
                least = _least_feasible(field)
                allowed = f"a number in [{least:g}, {LARGEST:g}]"
                self.require(name, least <= value <= LARGEST, allowed)

    def _require_feasible_size(self) -> None:
        # Comparisons are written so that inf and nan, from extreme inputs, fail them too.
        has_time_step = 0 < self.time_step < float("inf")
        self.require("stiffness", has_time_step, "a value that gives a finite time step")
        shortest = self.transient + self.average
        longest = shortest if self.protocol == "published" else max(shortest, self.limit)
        steps = longest * self.time_unit / self.time_step
        longer = "transient" if self.transient > self.average else "average"
        key = longer if longest == shortest else "limit"
        is_short = steps <= MAX_STEPS and self.steps <= MAX_STEPS
        self.require(key, is_short, f"a run of at most {MAX_STEPS:.0e} time steps")
        allowed = f"a value that gives at most {MAX_SAMPLES:.0e} samples"
        self.require(self.sampling_key, steps / self.sample_steps <= MAX_SAMPLES, allowed)
        allowed = f"at least transient + average = {shortest:g}"
        self.require("limit", self.protocol != "converged" or self.limit >= shortest, allowed)

    # The last rule, as the rules before it bound the numbers of particles.
    @model_validator(mode="after")
    def _require_feasible_trajectory(self) -> Self:
        allowed = "false without a trajectory, whose frames have them"
        has_frames = self.trajectory or not self.trajectory_contacts
        self.require("trajectory_contacts", has_frames, allowed)
        allowed = f"0 or at most transient + average = {self.transient + self.average:g}"
        self.require("trajectory", self.trajectory_samples <= self.shortest_samples, allowed)
        interval = self.trajectory_samples * self.sample_steps * self.time_step / self.time_unit
        # 1 % more, as the message shows three digits.
        least = 1.01 * interval * self.trajectory_bytes / MAX_TRAJECTORY
        limit = f"the frames of a run take at most {MAX_TRAJECTORY / 1e9:g} GB"
        allowed = f"0 or at least {least:.3g}: {limit}"
        self.require("trajectory", self.trajectory_bytes <= MAX_TRAJECTORY, allowed)
        return self


def _least_feasible(field: FieldInfo) -> float:
    """Return the least feasible value of a field; for a range above 0 that is `SMALLEST`."""
    for bound in field.metadata:
        if isinstance(bound, Ge | Gt):
            least = float(bound.ge if isinstance(bound, Ge) else bound.gt)  # type: ignore[arg-type]
            return SMALLEST if isinstance(bound, Gt) and least == 0 else least
    return -LARGEST
