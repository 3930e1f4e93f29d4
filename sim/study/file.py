"""Models of a study file: its keys, its series and its boundaries, whatever their system."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import chain
from math import prod
from typing import Annotated, Any, Literal, get_args

from pydantic import ConfigDict, Field

from sim.base.additions import additions
from sim.base.plugins import ALLOWED, PATTERN
from sim.parameters import AMOUNTS, SYSTEMS, Parameters
from sim.parameters.common import PREVIOUS, TWO_NUMBERS, Real, broken_rule, sphere_volume
from sim.parameters.in_place import given_by
from sim.parameters.roles import fixed_parameters
from sim.study.design import Axis, axis_of
from sim.study.design_file import DesignFile
from sim.study.entries import (
    ALLOWED_NAME,
    JUDGE,
    DecideFile,
    Lists,
    Name,
    Override,
    Some,
    Strict,
    optional,
    require_printable,
)
from sim.study.figure_spec import FIGURES
from sim.study.model import MAX_ROUNDS, PARTS, further_rounds
from sim.study.papers import papers
from sim.study.plot_file import PlotFile
from sim.study.questions import CalibrateFile, PropagationFile, SensitivityFile
from sim.study.surrogate import Question, SurrogateFile

#: Maximum number of points of a study.
MAX_POINTS = 100_000

#: Pattern of the name of a part. A lone hyphen would be standard input.
PART_NAME = r"^([^/\\-]|[^/\\]{2,})$"

#: Name that no study may have: the folder of results that holds published studies.
_RESERVED_NAME = "published"


class _Family(Strict):
    """Points or boundaries of one system that share most of their parameters."""

    @classmethod
    def hint(cls, key: str, value: Any) -> str:
        """Return a hint at the intended value or key, empty if there is none."""
        if key == "figures" and isinstance(value, str) and value in FIGURES:
            (system,) = get_args(cls.model_fields["system"].annotation)
            return f"a figure of the {system}; {value} is one of the {FIGURES[value].system}"
        if any(key in model.model_fields for model in SYSTEMS.values()):
            return "parameters belong under base, grid or cases"
        return ""

    name: Name = Field(description="name, unique in the study")
    system: str = Field(description="which of the systems")
    base: Some = optional("parameters shared by all points")
    grid: Lists = optional("one point (boundary) for every combination of the values listed")
    overrides: list[Override] = Field([], description="changes at certain values")

    def require_rules(self) -> None:
        for key, section in self.varied.items():
            for index, override in enumerate(self.overrides):
                for name in sorted(section.model_fields_set & override.set.model_fields_set):
                    value = getattr(override.set, name)
                    allowed = f"parameters other than {key}.{name} of the series"
                    raise broken_rule(f"overrides[{index}].set.{name}", value, allowed)
        for name in sorted(AMOUNTS & self.grid_lists.keys()):
            if len(values := self.grid_lists[name]) > 1:
                allowed = "one value, as it makes no other point"
                raise broken_rule(f"grid.{name}", values, allowed)

    @property
    def varied(self) -> dict[str, Lists]:
        """Parameters that vary all over it, by the key where they stand."""
        return {"grid": self.grid} if self.grid else {}

    @property
    def grid_lists(self) -> dict[str, list[Any]]:
        """Lists of values by parameter, empty without a grid."""
        return self.grid.explicit_values() if self.grid else {}


class SeriesFile(_Family):
    """A series of points. Without grid, cases and design, the base is its one point."""

    cases: list[Some] = optional("further points, each with the parameters given", min_length=1)
    design: DesignFile = optional("points spread over ranges, in place of grid and cases")
    figures: list[str] = Field([], description="figures that the series feeds")
    profiles: bool = Field(True, description="whether the dataset has the profiles of its points")

    def require_rules(self) -> None:
        super().require_rules()
        for key in ("grid", "cases"):
            if self.design and getattr(self, key):
                allowed = f"no {key} beside it; a series has a design or a grid or cases"
                raise broken_rule("design", "a design", allowed)
        start = getattr(self.base, "start_from", "")
        if start == PREVIOUS and (self.design or self.max_points < 2):
            allowed = f"{PREVIOUS} in a series with a grid or cases of several points"
            raise broken_rule("base.start_from", start, allowed)

    @property
    def varied(self) -> dict[str, Lists]:
        """Parameters that vary all over it, by the key where they stand."""
        return super().varied | ({"design.over": self.design.over} if self.design else {})

    def axes(self, points: Sequence[Parameters]) -> tuple[Axis, ...]:
        """Return the parameters that its points vary, as its design, grid or cases give them."""
        if self.design:
            return tuple(_of_mass(axis, points) for axis in self.design.axes)
        in_cases = [name for case in self.cases or [] for name in case.explicit_values()]
        model = SYSTEMS[self.system]
        others = (f"{name}_across" for name in in_cases if name in model.pairs)
        given = (*self.grid_lists, *in_cases, *others)
        axes, fields = list[Axis](), model.model_fields
        for name in dict.fromkeys(chain(*(given_by(model, one) for one in given))):
            values = [getattr(one, name) for one in points]
            if name not in AMOUNTS and len(set(values)) > 1:
                axes.append(axis_of(name, values, fields[name].annotation is int))
        return tuple(axes)

    @property
    def max_points(self) -> int:
        """Number of points under each reading, duplicates included."""
        if self.design:
            return self.design.max_points
        number = prod(map(len, self.grid_lists.values())) if self.grid else 0
        return number + len(self.cases or [])


def _of_mass(axis: Axis, points: Sequence[Parameters]) -> Axis:
    """Return an axis of densities as that of the masses that points have, any other unchanged."""
    if axis.name != "density":
        return axis
    volumes = [sphere_volume(point.diameter) for point in points]
    low, high = min(volumes) * axis.low, max(volumes) * axis.high
    choices = tuple(sorted({point.mass for point in points})) if axis.choices else ()
    return replace(axis, name="mass", low=low, high=high, choices=choices, normal=None)


class BoundaryFile(_Family):
    """A boundary between regimes, for each combination of the grid."""

    kind: Literal["search", "stop"] = Field(
        "search",
        description="`search`: flows start as in the paper; `stop`: that at the high end of the "
        "range does, the others from its end",
    )
    of: str = Field(
        "flow",
        description="what changes there: flow (arrested or not; usual), acceleration (accelerating "
        "or not), transport (belt: mean velocity beyond 10 % of the belt's or not)",
    )
    along: str = Field(description="parameter along which it is looked for")
    range: list[Real] = Field(
        description="lowest and highest value of that parameter",
        min_length=2,
        max_length=2,
        json_schema_extra={"allowed": TWO_NUMBERS},
    )
    tolerance: Real = Field(description="width of the interval to find the boundary in", gt=0)
    figures: list[str] = Field([], description="figures that are fed")

    def require_rules(self) -> None:
        super().require_rules()
        low, high = self.range
        self.require("range", low < high, TWO_NUMBERS)
        if self.kind == "stop":
            self.require("of", self.of == "flow", "flow with kind: stop")
            may_change = self.along not in fixed_parameters(SYSTEMS[self.system])
            allowed = "with kind: stop, a parameter that may change while a flow goes on"
            self.require("along", may_change, allowed)
        finest = (high - low) / PARTS ** (MAX_ROUNDS + 1)
        is_possible = further_rounds(low, high, self.tolerance) <= MAX_ROUNDS
        self.require("tolerance", is_possible, f"a number >= {1.01 * finest:.3g}")
        sections = {"base": self.base, "grid": self.grid}
        sections |= {f"overrides[{i}].set": one.set for i, one in enumerate(self.overrides)}
        for path, section in sections.items():
            if section and self.along in section.model_fields_set:
                value = getattr(section, self.along)
                allowed = f"parameters other than {self.along}, which the boundary is along"
                raise broken_rule(f"{path}.{self.along}", value, allowed)

    @property
    def max_points(self) -> int:
        """Maximum number of points after all rounds: each divides at most two gaps."""
        low, high = self.range
        rounds = further_rounds(low, high, self.tolerance)
        return prod(map(len, self.grid_lists.values())) * (PARTS + 1 + 2 * (PARTS - 1) * rounds)


class StudyFile(Strict):
    """A study: series of points, boundaries to be found, and the figures they feed.

    `file_models` makes its keys concrete with the parameters of the systems and the figures.
    """

    model_config = ConfigDict(
        json_schema_extra={
            "anyOf": [{"required": [key]} for key in ("series", "boundaries", "parts")]
        }
    )

    @classmethod
    def hint(cls, key: str, value: Any) -> str:
        """Return where a parameter belongs that stands at the top of the file, empty for others."""
        is_parameter = any(key in model.model_fields for model in SYSTEMS.values())
        text = f"{key} is a parameter: it belongs under defaults.<system>, or base of a series"
        return text if is_parameter and key not in cls.model_fields else ""

    study: Name = Field(
        description="name of the study and of its folder of results, not published",
        json_schema_extra=ALLOWED_NAME | {"not": {"enum": [_RESERVED_NAME]}},
    )
    title: str = Field("", description="one line for the report")
    figures: list[str] = optional(
        "all figures of the study, each fed by a series (omitted: those that are fed)"
    )
    paper: str = optional("paper whose `defaults` stand where the study gives no value")
    units: Literal["si", "natural"] = optional(
        "`natural`: diameter, mass and gravity are 1, so that all numbers are in units of these, "
        "stiffness in mg/d for instance; plots and report show them so, files say it of a "
        "particle of 1 m and 1 kg (omitted: the paper's, or si)"
    )
    defaults: Strict = Field(Strict(), description="parameters shared by series")
    readings: Strict = Field(
        Strict(), description="readings of the papers under which every series is run"
    )
    series: list[SeriesFile] = optional(
        "the series of points (omitted: none, if there are boundaries or parts)", min_length=1
    )
    boundaries: list[BoundaryFile] = optional(
        "boundaries between regimes, found by refinement", min_length=1
    )

    surrogate: list[SurrogateFile] = optional(
        "observables anywhere between the points of a series, with their errors", min_length=1
    )
    sensitivity: list[SensitivityFile] = optional(
        "what matters: how much each parameter changes an observable", min_length=1
    )
    propagate: list[PropagationFile] = optional(
        "how an observable is spread where parameters are: mean, quantiles, exceedance",
        min_length=1,
    )
    calibrate: list[CalibrateFile] = optional("which parameters measurements allow", min_length=1)
    plots: list[PlotFile] = optional("plots of the study's own points", min_length=1)
    decide: DecideFile = optional(
        "what more replicates and longer runs are to decide, and at what cost"
    )
    plugins: list[
        Annotated[str, Field(pattern=PATTERN, json_schema_extra={"allowed": ALLOWED})]
    ] = optional(
        "code that the study runs with: Python files in the same folder, and names of installed "
        "plug-ins (docs/extending.md)",
        min_length=1,
    )
    parts: list[
        Annotated[str, Field(pattern=PART_NAME, json_schema_extra={"allowed": "a file's name"})]
    ] = optional(
        "study files in the same folder whose points, boundaries and figures this one has too",
        min_length=1,
    )

    def require_rules(self) -> None:
        allowed = f"a name other than {_RESERVED_NAME}, where published studies lie"
        self.require("study", self.study != _RESERVED_NAME, allowed)
        require_printable(self.title)
        if self.paper is not None:
            self.require("paper", self.paper in papers(), f"one of {', '.join(papers())}")
        has_points = self.series or self.boundaries or self.parts
        self.require("series", has_points, "at least one series, boundaries, or parts")
        self._require_known_claims()
        names, total = set[str](), 0
        for key, entry in self.entries:
            if entry.name in names:
                raise broken_rule(f"{key}.name", entry.name, "a name that no other series has")
            names.add(entry.name)
        for key, entry in self.entries:
            lists = self.reading_lists(entry.system) if isinstance(entry, SeriesFile) else {}
            total += prod(map(len, lists.values())) * entry.max_points
            if total > MAX_POINTS:
                allowed = f"at most {MAX_POINTS:,} points in the study"
                section = "design" if getattr(entry, "design", None) else "grid"
                raise broken_rule(f"{key}.{section}", f"{total:,} points", allowed)

    def _require_known_claims(self) -> None:
        claims = (self.decide and self.decide.claims) or []
        if set(claims) <= {"all"}:
            return
        ids = [[claim["id"] for claim in paper.claims] for paper in papers().values()]
        ranges = ", ".join(f"{one[0]} to {one[-1]}" for one in ids if one)
        for index, name in enumerate(claims):
            if name not in {"all", *chain(*ids), *additions(JUDGE)}:
                allowed = f"{ranges}, all, or the name of a judge of a plug-in"
                raise broken_rule(f"decide.claims[{index}]", name, allowed)

    @property
    def is_natural(self) -> bool:
        """Whether all numbers are in units of diameter, mass and gravity."""
        own = papers()[self.paper].units if self.paper else "si"
        return (self.units or own) == "natural"

    @property
    def entries(self) -> Iterator[tuple[str, SeriesFile | BoundaryFile]]:
        """Pairs of a key in the file and the series or boundaries there, in order."""
        for name in ("series", "boundaries"):
            for index, entry in enumerate(getattr(self, name) or []):
                yield f"{name}[{index}]", entry

    def reading_lists(self, system: str) -> dict[str, list[Any]]:
        """Return the lists of readings of a system by parameter; there may be none."""
        readings = getattr(self.readings, system)
        return readings.explicit_values() if readings else {}


#: The questions of a study by their keys: whatever goes through all of them asks here. Surrogates
#: come first, as the others are asked of them.
QUESTIONS: dict[str, type[Question]] = {
    key: kind
    for key, field in StudyFile.model_fields.items()
    for kind in get_args(field.annotation)
    if isinstance(kind, type) and issubclass(kind, Question)
}
