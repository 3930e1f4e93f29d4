"""The papers' figures: entries of YAML files in `sim/papers`, read into what each figure is.

An entry has the keys of a study's own plot where they mean the same (`sim.study.plot_file`), and
further ones. `FigureEntry` describes them, and `KEYS` says which of them a kind of plot knows.
"""

from collections import UserDict
from collections.abc import Iterable, Mapping
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, ValidationError

from sim.base.errors import InputError
from sim.base.messages import did_you_mean, input_error
from sim.base.program import PACKAGE
from sim.base.yaml import read_yaml
from sim.parameters import SYSTEMS
from sim.study.figure_spec import (
    CREEP,
    LARGEST_PORTION,
    SHARE,
    TALLEST,
    WIDEST_INTERVAL,
    FigureSpec,
)

#: Files of the papers, in the order of figures in tables and reports.
FILES = tuple(PACKAGE / "papers" / paper / "figures.yaml" for paper in ("walton", "gallas"))

#: Keys that the entries of a kind of plot can have, besides those of all kinds.
KEYS: dict[str, set[str]] = {
    "belt_acceleration": {"x", "curves", "levels", "styles", "entry"},
    "belt_animation": set(),
    "belt_curves": {"x", "curves", "panels", "log", "look", "styles", "markers", "entry"},
    "belt_measures": {"x", "curves", "axis", "levels", "quantities", "styles", "entry"},
    "belt_onset": {"x", "y", "curves"},
    "belt_paths": set(),
    "belt_profiles": {"x", "curves", "vary", "look", "styles", "fast_start", "entry"},
    "belt_snapshots": set(),
    "chute_animation": {"point"},
    "chute_curves": {"x", "curves"},
    "chute_measures": {"x", "curves", "axis", "log", "levels", "quantities"},
    "chute_row": set(),
    "regimes": {"x", "y"},
}
_KEYS_OF_ALL = {"name", "kind", "about", "title", "where", "words", "lead", "named", "says"}

#: Axis that can be logarithmic, of kinds that have one.
_LOG_AXIS = {"belt_curves": "x", "chute_measures": "y"}

#: Kinds whose ``x`` is not a parameter but an observable.
_PROFILES = ("belt_profiles",)

#: Colours of Okabe and Ito, told apart by colour-blind readers.
COLOURS = {
    "black": "#000000",
    "blue": "#0072b2",
    "red": "#d55e00",
    "green": "#009e73",
    "pink": "#cc79a7",
    "orange": "#e69f00",
}

#: Limits that texts can name in braces, as they are written there.
_LIMITS = {
    "creep": f"{CREEP:g}",
    "largest_portion": f"{LARGEST_PORTION:g}",
    "share": f"{100 * SHARE:g}",
    "tallest": f"{TALLEST:g}",
    "widest_interval": f"{100 * WIDEST_INTERVAL:g}",
}


def _as_list(value: Any) -> Any:
    return value if isinstance(value, list) else [value]


#: Value of a parameter.
_Value = bool | int | float | str
_Names = Annotated[list[str], BeforeValidator(_as_list)]
_Values = Annotated[list[_Value], BeforeValidator(_as_list)]


class _Strict(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", strict=True, allow_inf_nan=False)


class Style(_Strict):
    """Style of a curve, and the values of ``curves``, in their order, that name it."""

    at: _Values = []
    colour: Literal[tuple(COLOURS)]  # type: ignore[valid-type]
    dashes: Literal["solid", "short_dash", "long_dash", "dash_dot", "dotted", "none"]
    marker: str = ""
    entry: str = Field("", description="its entry in the legend, instead of the figure's pattern")

    @property
    def place(self) -> Any:
        """The value of ``at``, or a tuple of several."""
        return self.at[0] if len(self.at) == 1 else tuple(self.at)

    @property
    def look(self) -> tuple[str, ...]:
        """Colour, dashes and, if it has one, marker."""
        return (COLOURS[self.colour], self.dashes, *filter(None, [self.marker]))


class MeasureEntry(_Strict):
    """A measure of the dataset that a figure shows."""

    name: str
    over: str = Field("", description="parameter that it is divided by")
    label: str = Field(description="what it is, for headings, with its unit in brackets")
    dashes: str = ""
    entry: str = Field("", description="its part of the entries in the legend")
    style: Style | None = None


class FigureEntry(_Strict):
    """A figure of a paper. Words in braces in ``title``, ``lead`` and ``says`` are filled in."""

    name: str = Field(pattern="^[a-z0-9_]+$", description="name in study files and of its files")
    kind: Literal[tuple(KEYS)]  # type: ignore[valid-type]
    about: str = Field(description="figure of the paper, or what of the paper it is about")
    title: str
    x: str = Field("", description="parameter on the horizontal axis; of profiles the observable")
    y: str = Field("", description="parameter on the vertical axis")
    curves: _Names = Field([], description="parameters that tell curves apart")
    panels: str = Field("", description="parameter that tells panels apart")
    vary: _Names = Field([], description="parameters, on no axis, that the points must vary")
    log: list[Literal["x", "y"]] = Field([], description="axes that are logarithmic")
    axis: str = Field("", description="label of the vertical axis")
    levels: list[float] = Field([], description="values to compare with")
    quantities: list[MeasureEntry] = []
    look: str = Field("", description="function of `sim.figures.looks` that styles the curves")
    styles: list[Style] = []
    markers: list[Style] = Field([], description="styles of curves that are points alone")
    fast_start: Style | None = Field(None, description="style of beads that start fast")
    entry: str = Field("", description="pattern of the entries in the legend")
    point: Literal["", "slowest"] = Field("", description="which of several points is shown")
    where: dict[str, _Values] = Field({}, description="values that a point must have to be drawn")
    words: dict[str, str] = Field({}, description="texts for the braces, besides those of all")
    lead: str = Field(description="first sentences of the caption: what is drawn")
    named: list[str] = Field(description="parameters whose values the caption gives")
    says: str = Field(description="last sentences of the caption: what the paper says")

    @property
    def axes(self) -> tuple[str, ...]:
        """Parameters on the axes, or that the points must vary."""
        x = "" if self.kind in _PROFILES else self.x
        return (*filter(None, (x, self.y, self.panels)), *self.vary)

    @property
    def values(self) -> dict[str, Any]:
        """Value, or tuple of values, of each parameter under ``where``."""
        return {
            name: values[0] if len(values) == 1 else tuple(values)
            for name, values in self.where.items()
        }

    @property
    def options(self) -> dict[str, Any]:
        """What the kind of plot leaves open, by the names of `sim.figures`; empty ones left out."""
        is_profile = self.kind in _PROFILES
        options = {
            "quantity": self.x if is_profile else "",
            "look": self.look,
            "keys": tuple(self.curves) if is_profile else (),
            "axis": self.axis,
            "scale": "log" if self.log else "",
            "levels": tuple(self.levels),
            "quantities": tuple(map(_measure, self.quantities)),
            "styles": {style.place: style.look for style in self.styles},
            "markers": {style.place: style.look for style in self.markers},
            "fast_start": self.fast_start.look if self.fast_start else (),
            "entry": self.entry,
            "entries": {style.place: style.entry for style in self.styles if style.entry},
            "point": self.point,
        }
        return {name: value for name, value in options.items() if value}


class PaperFile(_Strict):
    """The figures of a paper, all of one system."""

    paper: str = Field(description="how figures quote the paper")
    system: Literal[tuple(SYSTEMS)]  # type: ignore[valid-type]
    words: dict[str, str] = Field({}, description="texts for the braces of all figures")
    figures: list[FigureEntry]


def _measure(measure: MeasureEntry) -> dict[str, Any]:
    """Return a measure as an option of a figure."""
    values = {name: value for name, value in measure if value}
    return values | ({"style": measure.style.look} if measure.style else {})


def read_figures(path: Path) -> list[FigureSpec]:
    """Read the figures of a paper.

    Raises
    ------
    InputError
        For a file that is not readable, and for the first wrong or unknown key, kind or parameter.
    """
    contents = read_yaml(path)
    try:
        file = PaperFile.model_validate(contents)
    except ValidationError as error:
        raise input_error(error, PaperFile, str(path)) from None
    words = {
        name: _filled(text, _LIMITS, str(path), f"words.{name}")
        for name, text in file.words.items()
    }
    return [
        _spec(file, entry, _LIMITS | words, str(path), f"figures[{number}]")
        for number, entry in enumerate(file.figures)
    ]


def _spec(
    file: PaperFile, entry: FigureEntry, words: Mapping[str, str], source: str, key: str
) -> FigureSpec:
    """Return the figure of an entry, which is at ``key`` of a file."""
    _require_keys_of_kind(entry, source, key)
    _require_parameters(entry, file.system, source, key)
    words = {**words, **entry.words, **entry.values}
    return FigureSpec(
        name=entry.name,
        kind=entry.kind,
        paper=f"{file.paper}, {entry.about}",
        system=file.system,
        title=_filled(entry.title, words, source, f"{key}.title"),
        axes=entry.axes,
        curves=tuple(name for name in entry.curves if name not in entry.vary),
        where=entry.values,
        lead=_filled(entry.lead, words, source, f"{key}.lead"),
        named=tuple(entry.named),
        says=_filled(entry.says, words, source, f"{key}.says"),
        options=entry.options,
    )


def _require_keys_of_kind(entry: FigureEntry, source: str, path: str) -> None:
    """Raise ``InputError`` for a key, or an axis under ``log``, that a kind does not know."""
    keys = _KEYS_OF_ALL | KEYS[entry.kind]
    for key, value in entry:
        if key in entry.model_fields_set and key not in keys:
            allowed = f"a key of {entry.kind}: {', '.join(sorted(keys))}"
            raise InputError.of_value(source, f"{path}.{key}", value, allowed)
    if entry.log and entry.log != [_LOG_AXIS[entry.kind]]:
        allowed = f"[{_LOG_AXIS[entry.kind]}] of {entry.kind}"
        raise InputError.of_value(source, f"{path}.log", entry.log, allowed)


def _require_parameters(entry: FigureEntry, system: str, source: str, path: str) -> None:
    """Raise ``InputError`` for a name that is no parameter of the system."""
    known = SYSTEMS[system].model_fields
    names: dict[str, Iterable[str]] = {
        "x": [] if entry.kind in _PROFILES else [entry.x],
        "y": [entry.y],
        "panels": [entry.panels],
        "curves": entry.curves,
        "vary": entry.vary,
        "where": entry.where,
        "named": entry.named,
    }
    for key, values in names.items():
        for name in values:
            if name and name not in known:
                allowed = f"{did_you_mean(name, known)}a parameter of the {system}"
                raise InputError.of_value(source, f"{path}.{key}", name, allowed)


def _filled(text: str, words: Mapping[str, Any], source: str, key: str) -> str:
    """Return a text with the words for its braces."""
    try:
        return text.format(**words)
    except (KeyError, IndexError, TypeError, ValueError) as error:
        allowed = f"in braces one of {', '.join(words)}"
        got = error.args[0] if isinstance(error, KeyError) else str(error)
        raise InputError.of_value(source, key, got, allowed) from None


class Catalogue(UserDict[str, FigureSpec]):
    """The figures of all papers by name, read when the first of them is asked for."""

    def __init__(self) -> None:
        """Read nothing yet: many commands need no figure."""

    @cached_property
    def data(self) -> dict[str, FigureSpec]:  # type: ignore[override]
        """The figures; animations come last."""
        figures: dict[str, FigureSpec] = {}
        for path in FILES:
            for spec in read_figures(path):
                if spec.name in figures:
                    allowed = "a name that no other figure has"
                    raise InputError.of_value(path, "name", spec.name, allowed)
                figures[spec.name] = spec
        return dict(sorted(figures.items(), key=lambda item: item[1].animated))


FIGURES = Catalogue()
