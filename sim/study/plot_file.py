"""Entries under ``plots`` of a study file, and the call that adds a law to fit to their curves."""

from collections.abc import Callable, Collection, Mapping
from inspect import Parameter, Signature
from math import isfinite
from pathlib import Path
from typing import Annotated, Any, Literal, TypeVar

from pydantic import AfterValidator, BeforeValidator, ConfigDict, Field, WithJsonSchema

from sim.base.additions import NAME as PLUGIN_NAME
from sim.base.additions import add, additions, attribute_errors_to
from sim.base.measured import ALLOWED_FILE, FILE
from sim.base.messages import one_of
from sim.base.plugins import Declared, Words, allowed, declared, require_function
from sim.parameters.common import Real, broken_rule
from sim.study.entries import Name, Strict, optional, require_printable
from sim.study.plottable import REGIME, Keys, every_name, kinds, study_kinds

_Function = TypeVar("_Function", bound=Callable[..., Any])

#: Kind of the additions that are laws to fit.
FIT = "fit"

#: Names of the laws that ship; `sim.figures.fit` has them.
FITS = ("linear", "quadratic", "power", "exponential", "pouliquen", "mu_of_i")


def _are_numbers(start: Any) -> bool:
    return (
        isinstance(start, Mapping)
        and bool(start)
        and all(isinstance(name, str) and name.isidentifier() for name in start)
        and all(type(one) in (int, float) and isfinite(one) for one in start.values())
    )


class FitLaw(Declared):
    """A law of a plug-in: its ``formula`` in words, first values of its numbers by letter."""

    formula: Words
    start: Annotated[dict[str, float], allowed("a mapping of letters to numbers", _are_numbers)]
    function: Callable[..., Any]


def fit(name: str, *, formula: str, start: Mapping[str, float]) -> Callable[[_Function], _Function]:
    """Declare a law that plots of studies fit to curves: ``fit: name``.

    The decorated function gets the values along x, an array (n,), then the numbers of the law, each
    by its letter; it returns the values along y, (n,), in the units of the axes.

    Parameters
    ----------
    name : str
        What study files call it.
    formula : str
        The law, for captions: ``"y = a (1 - exp(-x/b))"``.
    start : mapping
        Letter of each number -> the value from which least squares begin.
    """

    def register(function: _Function) -> _Function:
        fields = {"formula": formula, "start": start, "function": function}
        law = declared(FitLaw, f"fit {name}", **fields)
        require_function(f"fit {name}", function, takes=1, named=law.start)

        def attributed(x: Any, **numbers: float) -> Any:
            with attribute_errors_to(FIT, name):
                return function(x, **numbers)

        # That of the function may be wider than what least squares call it with.
        names = ("x", *law.start)
        attributed.__signature__ = Signature(  # type: ignore[attr-defined]
            [Parameter(one, Parameter.POSITIONAL_OR_KEYWORD) for one in names]
        )
        add(FIT, name, law.model_copy(update={"function": attributed}), FITS)
        return function

    return register


def fits() -> tuple[str, ...]:
    """Return the names of all laws: those that ship, then those of plug-ins."""
    return (*FITS, *additions(FIT))


def require_kind(kind: str, kinds: Collection[str] = ()) -> str:
    """Return the name of a kind of studies' plots, or one of other ``kinds``; refuse any other."""
    kinds = kinds or study_kinds(own=True)
    if kind not in kinds:
        raise broken_rule("", kind, one_of(kind, kinds))
    return kind


#: Type of a kind of plot, of Talus or of a plug-in.
Kind = Annotated[
    str,
    AfterValidator(require_kind),
    WithJsonSchema(
        {"anyOf": [{"enum": study_kinds()}, {"type": "string", "pattern": PLUGIN_NAME}]}
    ),
]

#: Type of the name of a law, of Talus or of a plug-in.
FitName = Annotated[
    str,
    AfterValidator(lambda name: require_kind(name, fits())),
    WithJsonSchema({"anyOf": [{"enum": [*FITS]}, {"type": "string", "pattern": PLUGIN_NAME}]}),
]

#: Allowed values of ``between``, for messages.
_ALLOWED_BETWEEN = "two heights in diameters, 0 or more, the lower one first"


def _as_list(value: Any) -> Any:
    return [value] if isinstance(value, (str, dict)) else value


#: Type of a list of names, for which a file may give a single name.
Names = Annotated[
    list[str],
    BeforeValidator(_as_list),
    WithJsonSchema({"anyOf": [{"type": "string"}, {"type": "array", "items": {"type": "string"}}]}),
]

_OBSERVABLE_EXAMPLES = {"examples": every_name()}
_NAME_OR_NAMES: dict[str, Any] = {"allowed": "a name, or a list of names"}

#: Maximum number of data sets beside a plot, as each has a style of its own; and of letters in a
#: label.
MAX_BESIDE, _MAX_LABEL_LENGTH = 6, 60

#: Largest magnitude of a number that can be drawn; on a logarithmic axis, its inverse is the least.
MAX_MAGNITUDE = 1e100

_LABEL = "a text that is not empty"
_POINTS = f"a list of points [x, y], numbers of size up to {MAX_MAGNITUDE:g}"
_COLUMN = "the name of a column of the file"

#: What data beside a plot need and what they cannot have: points, and columns of a file.
_NEEDED = {
    False: {"label": _LABEL, "points": f"{_POINTS}, or a file"},
    True: {"x": _COLUMN, "y": _COLUMN},
}
_OTHERS = {False: ("x", "y", "yerr"), True: ("points",)}

#: Values of ``beside``: its entry in the JSON schema, and in words.
_ONE_OR_SEVERAL: dict[str, Any] = {
    "type": ["array", "object"],
    "anyOf": [{"type": "array"}, {"$ref": "#/$defs/BesideFile"}],
    "allowed": f"a list of at most {MAX_BESIDE} mappings with label and points, or with file",
}

#: A number that can be drawn.
_DrawableNumber = Annotated[Real, Field(ge=-MAX_MAGNITUDE, le=MAX_MAGNITUDE)]


class BesideFile(Strict):
    """Data that are not of the study: points in the units of the plot, or columns of a CSV file."""

    model_config = ConfigDict(
        json_schema_extra={
            "anyOf": [{"required": ["label", "points"]}, {"required": ["file", "x", "y"]}]
        }
    )

    label: str = optional(
        f"what it is, for legend and caption, at most {_MAX_LABEL_LENGTH} letters (omitted: the "
        "name of the file)",
        pattern=r"\S",
        json_schema={"allowed": _LABEL},
    )
    points: list[Annotated[list[_DrawableNumber], Field(min_length=2, max_length=2)]] = optional(
        "points [x, y], in the units of the axes as they are drawn",
        min_length=1,
        json_schema={"allowed": _POINTS},
    )
    file: str = optional(
        "in place of points: a CSV file in the folder of the study file, with units in its "
        "headings, as velocity (mm/s), or those of the axes as they are drawn",
        pattern=FILE,
        json_schema={"allowed": ALLOWED_FILE},
    )
    x: str = optional("of a file: column on the horizontal axis")
    y: str = optional("of a file: column on the vertical axis")
    yerr: str = optional("of a file: column with the errors of y, half the length of their bars")
    line: bool = Field(False, description="a line through the points, in their order, not markers")

    def require_rules(self) -> None:
        has_file = self.file is not None
        for key, needed in _NEEDED[has_file].items():
            self.require(key, getattr(self, key) is not None, needed)
        for key in _OTHERS[has_file]:
            is_left = getattr(self, key) is None
            self.require(key, is_left, "points, or columns of a file, not both")
        require_printable(self.name, "label", _MAX_LABEL_LENGTH)
        is_enough = has_file or not self.line or len(self.points) > 1
        self.require("points", is_enough, "at least two points for a line")

    @property
    def name(self) -> str:
        """Label, which of a file may be its name."""
        return self.label or Path(self.file).stem


def allowed_on_logarithmic(axis: str) -> str:
    """Return the numbers allowed on a logarithmic axis, in words."""
    return f"numbers >= {1 / MAX_MAGNITUDE:g} on the logarithmic axis {axis}"


class PlotFile(Strict):
    """A plot of the points of a study."""

    name: Name = Field(
        description="name of the plot and of its files, unique in the study and none of the "
        "catalogue's"
    )
    kind: Kind = Field(
        "curves",
        description="`curves` of a number with intervals; `map` over two parameters; `profiles` "
        "over the height; `time_series`; `distribution` of the replicates, `likelihood` of a rise; "
        "of points scattered in several parameters `scatter`, `main_effects`; or one of a plug-in",
    )
    system: Literal["chute", "belt", "conveyor", "function"] = optional(
        "which system, where the series have several"
    )
    title: str = Field("", description="one line (omitted: made from what is shown)")
    x: str = optional(
        "parameter on the horizontal axis, of `curves` and `scatter` also another observable; of "
        "`profiles` the observable (velocity)",
        json_schema=_OBSERVABLE_EXAMPLES,
    )
    y: str = optional(
        "observable on the vertical axis (velocity); of a `map` a parameter; of `profiles` an "
        "observable over the height, in each slice shown against x (omitted: the height itself)",
        json_schema=_OBSERVABLE_EXAMPLES,
    )
    colour: str = optional(
        "of a `map`: observable that the colour shows, or `regime` (omitted); of a `scatter` also "
        "a parameter (omitted: one colour)",
        json_schema=_OBSERVABLE_EXAMPLES,
    )
    parameters: Names = optional(
        "of `main_effects`: parameters on the axes (omitted: all that vary)",
        json_schema=_NAME_OR_NAMES,
        min_length=1,
    )
    curves: Names = optional(
        "parameter, or list of them, that tells curves apart", json_schema=_NAME_OR_NAMES
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
    beside: Annotated[list[BesideFile], BeforeValidator(_as_list)] = optional(
        "data that are not of the study, drawn beside it: of `curves`, `profiles` and `map`; a "
        "mapping, or a list of them",
        json_schema=_ONE_OR_SEVERAL,
        min_length=1,
        max_length=MAX_BESIDE,
    )
    fit: FitName = optional(
        "law that is fitted to each of `curves`, and drawn in place of its line, or to boundaries "
        "in a `map` of regimes (docs/plots.md)"
    )
    log: list[Literal["x", "y", "colour"]] = Field(
        [],
        description="axes that are logarithmic",
        json_schema_extra={"allowed": "a list of 'x', 'y' or 'colour'"},
    )

    def require_rules(self) -> None:
        require_printable(self.title)
        keys = ("x", "y", "colour", "parameters", "curves", "panels", "between", "beside", "fit")
        for key in keys:
            value = getattr(self, key)
            if value is not None and key not in self.keys_of_kind:
                allowed = f"a key of {self.kind}: {', '.join(self.keys_of_kind)}"
                raise broken_rule(key, value[0].name if key == "beside" else value, allowed)
            if value is None and key in self.keys.axes:
                alternative = ", or an observable" if self.keys.second == key else ""
                raise broken_rule(key, value, f"a parameter that the points vary{alternative}")
        for number, axis in enumerate(self.log):
            if axis not in self.log_axes:
                raise broken_rule(f"log[{number}]", axis, "one of " + ", ".join(self.log_axes))
        has_lines = not self.keys.is_map or self.show == REGIME
        self.require("fit", has_lines or not self.fit, "a map of regimes, with boundaries")
        low, high = self.between or (0, 1)
        self.require("between", 0 <= low < high, _ALLOWED_BETWEEN)
        labels: set[str] = set()
        for number, data in enumerate(self.beside or []):
            if data.name in labels:
                raise broken_rule(f"beside[{number}].label", data.name, "a label of its own")
            labels.add(data.name)
            for index, point in enumerate(data.points or []):
                place = f"beside[{number}].points[{index}]"
                for letter, value in zip("xy", point, strict=True):
                    if value < self.least(letter):
                        raise broken_rule(place, point, allowed_on_logarithmic(letter))

    def least(self, axis: str) -> float:
        """Return the least number that can be drawn on the axis ``"x"`` or ``"y"``."""
        return 1 / MAX_MAGNITUDE if axis in self.log else -MAX_MAGNITUDE

    @property
    def keys(self) -> Keys:
        """The keys of its kind."""
        return kinds()[self.kind].keys

    @property
    def keys_of_kind(self) -> tuple[str, ...]:
        """Names of the keys that its kind has besides those of all kinds."""
        return self.keys.every

    @property
    def log_axes(self) -> tuple[str, ...]:
        """Axes that can be logarithmic: where an observable is on one, or no regime."""
        second = [key for key in (self.keys.second,) if key and getattr(self, key)]
        axes = dict.fromkeys((*self.keys.log, *second))
        is_coloured = (self.colour or REGIME) != REGIME
        return tuple(axis for axis in axes if axis != "colour" or is_coloured)

    @property
    def show(self) -> str:
        """Name of the observable that is shown, or ``regime``."""
        key = self.keys.observable
        return (getattr(self, key) or self.keys.usual) if key else ""
