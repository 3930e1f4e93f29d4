"""Entries under ``plots`` of a study file: observables, parameters, and data beside them."""

from typing import Annotated, Any, Literal, Self

from pydantic import AfterValidator, BeforeValidator, Field, WithJsonSchema, model_validator

from sim.base.additions import NAME as PLUGIN_NAME
from sim.base.messages import one_of
from sim.parameters.common import Real, broken_rule
from sim.study.entries import ALLOWED_NAME, NAME, Strict, optional, require_printable
from sim.study.plot_kinds import REGIME, Keys, find_kind, study_kinds
from sim.study.plottable import every_name


def _require_known_kind(kind: str) -> str:
    kinds = study_kinds(own=True)
    if kind not in kinds:
        raise broken_rule("", kind, one_of(kind, kinds))
    return kind


#: Type of a kind of plot, of Talus or of a plug-in.
Kind = Annotated[
    str,
    AfterValidator(_require_known_kind),
    WithJsonSchema(
        {"anyOf": [{"enum": study_kinds()}, {"type": "string", "pattern": PLUGIN_NAME}]}
    ),
]

#: Allowed values of ``between``, for messages.
_ALLOWED_BETWEEN = "two heights in diameters, 0 or more, the lower one first"


def _as_list(value: Any) -> Any:
    return [value] if isinstance(value, str) else value


#: Type of a list of names, for which a file may give a single name.
Names = Annotated[
    list[str],
    BeforeValidator(_as_list),
    WithJsonSchema({"anyOf": [{"type": "string"}, {"type": "array", "items": {"type": "string"}}]}),
]

_OBSERVABLE_EXAMPLES = {"examples": every_name()}


#: Maximum number of data sets beside a plot; each has a style of its own.
MAX_BESIDE = 6

#: Maximum length of a label.
_MAX_LABEL_LENGTH = 60

#: Largest magnitude of a number that can be drawn; on a logarithmic axis, its inverse is the least.
MAX_MAGNITUDE = 1e100

_LABEL: dict[str, Any] = {"allowed": "a text that is not empty"}
_POINTS: dict[str, Any] = {
    "allowed": f"a list of points [x, y], numbers of size up to {MAX_MAGNITUDE:g}"
}

#: A number that can be drawn.
_DrawableNumber = Annotated[Real, Field(ge=-MAX_MAGNITUDE, le=MAX_MAGNITUDE)]


class BesideFile(Strict):
    """Data that are not of the study, in the units of the plot."""

    label: str = Field(
        pattern=r"\S",
        description=f"what it is, for legend and caption, at most {_MAX_LABEL_LENGTH} letters",
        json_schema_extra=_LABEL,
    )
    points: list[Annotated[list[_DrawableNumber], Field(min_length=2, max_length=2)]] = Field(
        min_length=1,
        description="points [x, y], in the units of the axes as they are drawn",
        json_schema_extra=_POINTS,
    )
    line: bool = Field(False, description="a line through the points, in their order, not markers")

    @model_validator(mode="after")
    def _require_label_and_line_ends(self) -> Self:
        require_printable(self.label, "label", _MAX_LABEL_LENGTH)
        if self.line and len(self.points) < 2:
            raise broken_rule("points", self.points, "at least two points for a line")
        return self


class PlotFile(Strict):
    """A plot of the points of a study."""

    name: str = Field(
        pattern=NAME,
        max_length=60,
        description="name of the plot and of its files, unique in the study and none of the "
        "catalogue's",
        json_schema_extra=ALLOWED_NAME,
    )
    kind: Kind = Field(
        "curves",
        description="`curves` of a number with intervals; `map` over two parameters; `profiles` "
        "over the height; `time_series`; `distribution` of the replicates; or one of a plug-in",
    )
    system: Literal["chute", "belt", "conveyor"] = optional(
        "which system, where the series have several"
    )
    title: str = Field("", description="one line (omitted: made from what is shown)")
    x: str = optional(
        "parameter on the horizontal axis, of `curves` also another observable; of `profiles` the "
        "observable (velocity)",
        json_schema=_OBSERVABLE_EXAMPLES,
    )
    y: str = optional(
        "observable on the vertical axis (velocity); of a `map` a parameter; of `profiles` an "
        "observable over the height, in each slice shown against x (omitted: the height itself)",
        json_schema=_OBSERVABLE_EXAMPLES,
    )
    colour: str = optional(
        "of a `map`: observable that the colour shows, or `regime` (omitted)",
        json_schema=_OBSERVABLE_EXAMPLES,
    )
    curves: Names = optional(
        "parameter, or list of them, that tells curves apart",
        json_schema={"allowed": "a name, or a list of names"},
    )
    panels: str = optional(
        "parameter that tells panels apart", json_schema={"allowed": "the name of one parameter"}
    )
    series: list[str] = optional(
        "series whose points are drawn (omitted: all of the system)", min_length=1
    )
    units: Literal["si", "natural"] = Field(
        "si",
        description="units of what is observed: `si`, or `natural` ones of diameter, mass and "
        "gravity; parameters are as in study files",
    )
    between: list[Real] = optional(
        "of `profiles`: heights above the base between which slices are shown, in diameters",
        json_schema={"allowed": _ALLOWED_BETWEEN},
        min_length=2,
        max_length=2,
    )
    beside: list[BesideFile] = optional(
        "data that are not of the study, drawn beside it: of `curves`, `profiles` and `map`",
        min_length=1,
        max_length=MAX_BESIDE,
        json_schema={"allowed": f"a list of at most {MAX_BESIDE} mappings with label and points"},
    )
    log: list[Literal["x", "y", "colour"]] = Field(
        [],
        description="axes that are logarithmic",
        json_schema_extra={"allowed": "a list of 'x', 'y' or 'colour'"},
    )

    @model_validator(mode="after")
    def _require_printable_title(self) -> Self:
        require_printable(self.title)
        return self

    @model_validator(mode="after")
    def _require_keys_of_kind(self) -> Self:
        for key in ("x", "y", "colour", "curves", "panels", "between", "beside"):
            value = getattr(self, key)
            if value is not None and key not in self.keys_of_kind:
                allowed = f"a key of {self.kind}: {', '.join(self.keys_of_kind)}"
                raise broken_rule(key, value[0].label if key == "beside" else value, allowed)
            if value is None and key in self.keys.axes:
                alternative = ", or an observable" if self.keys.second == key else ""
                raise broken_rule(key, value, f"a parameter that the points vary{alternative}")
        for number, axis in enumerate(self.log):
            if axis not in self.log_axes:
                raise broken_rule(f"log[{number}]", axis, "one of " + ", ".join(self.log_axes))
        return self

    @model_validator(mode="after")
    def _require_valid_heights(self) -> Self:
        low, high = self.between or (0, 1)
        if not 0 <= low < high:
            raise broken_rule("between", self.between, _ALLOWED_BETWEEN)
        return self

    @model_validator(mode="after")
    def _require_drawable_beside(self) -> Self:
        labels: set[str] = set()
        for number, data in enumerate(self.beside or []):
            if data.label in labels:
                raise broken_rule(f"beside[{number}].label", data.label, "a label of its own")
            labels.add(data.label)
            for index, point in enumerate(data.points):
                low = [
                    axis
                    for axis, value in zip("xy", point, strict=True)
                    if value < 1 / MAX_MAGNITUDE
                ]
                if axes := [axis for axis in low if axis in self.log]:
                    allowed = f"numbers >= {1 / MAX_MAGNITUDE:g} on the logarithmic axis {axes[0]}"
                    raise broken_rule(f"beside[{number}].points[{index}]", point, allowed)
        return self

    @property
    def keys(self) -> Keys:
        """The keys of its kind."""
        return find_kind(self.kind).keys

    @property
    def keys_of_kind(self) -> tuple[str, ...]:
        """Names of the keys that its kind has besides those of all kinds."""
        return self.keys.every

    @property
    def log_axes(self) -> tuple[str, ...]:
        """Axes that can be logarithmic: where an observable is on one, or no regime."""
        second = [key for key in (self.keys.second,) if key and getattr(self, key)]
        axes = dict.fromkeys((*self.keys.log, *second))
        return tuple(axis for axis in axes if (axis, self.observable) != ("colour", REGIME))

    @property
    def observable(self) -> str:
        """Name of the observable that is shown, or ``regime``."""
        key = self.keys.observable
        return (getattr(self, key) or self.keys.usual) if key else ""

    @property
    def axis_names(self) -> tuple[str, ...]:
        """Names on the axes that show parameters; at a second key it may be an observable."""
        return tuple(getattr(self, key) for key in self.keys.axes)

    @property
    def options(self) -> dict[str, Any]:
        """What the kind of plot leaves open, as plain data."""
        return {
            "show": self.observable,
            "second": "",
            "between": tuple(self.between or ()),
            "beside": tuple(
                (data.label, tuple(map(tuple, data.points)), data.line)
                for data in self.beside or ()
            ),
            "panels": self.panels or "",
            "curves": tuple(self.curves or ()),
            "units": self.units,
            "log": tuple(self.log),
        }
