"""A figure as it is drawn: the keys of its file, and what follows from its points."""

from collections import UserDict
from collections.abc import Iterable, Mapping
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any, Literal, NamedTuple

from pydantic import AfterValidator, Field

from sim.base.additions import on_change
from sim.base.errors import InputError
from sim.base.yaml import read_yaml
from sim.parameters import NUMERICAL, SYSTEMS, Parameters
from sim.parameters.common import broken_rule
from sim.study.entries import Strict, Text, read_into
from sim.study.papers import Paper, papers
from sim.study.plot_file import PlotFile, require_kind
from sim.study.plottable import (
    CREEP,
    LARGEST_PORTION,
    SHARE,
    TALLEST,
    Keys,
    find_observable,
    kinds,
    require_parameter,
)

#: Data beside a plot: label; points (x, y), or (x, y, error of y), in the units of the plot;
#: whether a line joins them.
DataSet = tuple[str, tuple[tuple[float, ...], ...], bool]


class Answer(NamedTuple):
    """The answer that a figure shows: its file, and the observable with its unit.

    ``regimes`` are those that count, ``settings`` those of the question, and ``x`` and ``y`` the
    parameters on the axes.
    """

    file: str = ""
    observable: str = ""
    unit: str = ""
    regimes: tuple[str, ...] = ()
    settings: tuple[Any, ...] = ()
    x: str = ""
    y: str = ""


def _one_or_tuple(value: Any) -> Any:
    values = value if isinstance(value, list) else [value]
    if not all(isinstance(one, bool | int | float | str) for one in values):
        raise broken_rule("", value, "a value of a parameter, or a list of values")
    return tuple(values) if isinstance(value, list) else value


_Values = Annotated[Any, AfterValidator(_one_or_tuple)]


class _Look(Strict):
    """Look of a curve, by the names of `sim.figures.style`; a measure may leave it open."""

    colour: Literal["black", "blue", "red", "green", "pink", "orange"] | None = Field(
        None, description="black, blue, red, green, pink or orange"
    )
    dashes: Literal["solid", "short_dash", "long_dash", "dash_dot", "dotted", "none"] | None = (
        Field(None, description="solid, short_dash, long_dash, dash_dot, dotted or none")
    )
    marker: str = Field("o", description="marker, as matplotlib names it")
    entry: Text = Field("", description="its entry in the legend, or a measure's part of entries")


class Style(_Look):
    """Look of the curve that has the values ``at`` of ``curves``, in their order."""

    at: _Values = Field(description="values of `curves`, in their order")


class Measure(_Look):
    """A measure of the dataset that a figure shows."""

    name: str = Field(description="its name in the dataset")
    over: str = Field("", description="parameter that it is divided by")
    label: Text = Field(description="what it is, for headings, with its unit in brackets")


class FigureSpec(PlotFile):
    """A figure: the keys of a plot, those of papers' figures, and what follows from its points.

    What follows is no key: ``paper`` is the figure of the paper it reproduces, or what it is about
    in it, and empty for a study's own plot; ``foreign`` are the data beside it; ``scattered`` is
    whether points hardly share curves, as those of a design; ``answer`` is the answer that it
    shows; and ``plugin`` is the code hash of the plug-in that adds its kind.
    """

    about: Text = Field("", description="figure of the paper, or what of the paper it is about")
    vary: list[str] = Field([], description="parameters, on no axis, that the points must vary")
    labels: dict[Literal["x", "y", "right"], Text] = Field({}, description="labels of the axes")
    widest: float = Field(0, description="largest relative interval that a line joins, 0 for any")
    joins_open: bool = Field(
        False, description="whether a thin line joins points that are not steady, too"
    )
    levels: list[float] = Field([], description="values to compare with")
    level: Text = Field("", description="their entry in the legend")
    quantities: list[Measure] = Field([], description="measures that it shows, each with a look")
    alike: list[str] = Field([], description="parameters that do not tell curves apart")
    relative: bool = Field(
        False, description="whether velocity and frequency of the belt become shares of its own"
    )
    styles: list[Style] = Field([], description="looks of curves, by the values of `curves`")
    entry: Text = Field("", description="pattern of the entries in the legend")
    flat: bool = Field(False, description="whether profiles have the height along x")
    theory: Literal["", "least_friction", "largest_angle", "lift_off"] = Field(
        "", description="line of theory on a map of regimes"
    )
    creep: bool = Field(False, description="whether flows that creep have a marker of their own")
    point: Literal["", "slowest", "none"] = Field(
        "", description="which of several points is shown; of a map of regimes maybe `none`"
    )
    where: dict[str, _Values] = Field({}, description="values that a point must have to be drawn")
    words: dict[str, Text] = Field(
        {}, description="texts for the braces, besides those of the file"
    )
    lead: Text = Field("", description="first sentence of the caption: what is drawn")
    named: list[str] = Field([], description="parameters whose values the details give")
    says: Text = Field("", description="sentence of the caption: what the paper says")
    details: Text = Field("", description="first sentences of the details: definitions, methods")

    paper: str = ""
    foreign: tuple[DataSet, ...] = ()
    scattered: bool = False
    answer: Answer = Answer()
    plugin: str = ""

    @property
    def axes(self) -> tuple[str, ...]:
        """Parameters that must take at least two values; curves are drawn along the first."""
        if self.keys.several:
            return tuple(self.parameters)
        # At a second key, an axis may show an observable.
        named = () if self.second else (getattr(self, key) for key in self.keys.axes)
        return (*named, *self.vary)

    @property
    def by(self) -> tuple[str, ...]:
        """Parameters that the key ``curves`` names."""
        return tuple(self.curves or ())

    @property
    def groups(self) -> tuple[str, ...]:
        """Parameters that tell curves and panels apart; a study may vary them or not."""
        names = (*self.by, *filter(None, (self.panels,)))
        return tuple(name for name in names if name not in self.vary)

    @property
    def second(self) -> str:
        """The second observable, where no parameter is on its axis; else empty."""
        keys = self.keys
        name = getattr(self, keys.second) if keys.second else None
        is_observable = keys.second not in keys.axes or name in keys.shows(self.system)
        return name if name and is_observable else ""

    @property
    def animated(self) -> bool:
        """Whether it moves: a GIF with a poster instead of a picture."""
        return self.keys.animated

    @property
    def taken(self) -> dict[str, str]:
        """Values in ``where`` in words, by parameter."""
        return {name: ", ".join(map(written, _tuple(value))) for name, value in self.where.items()}

    def shows(self, parameters: Parameters) -> bool:
        """True for the parameters of a point that is drawn."""
        return all(self.takes(name, parameters) for name in self.where)

    def is_fed_by(self, system: str, series: Iterable[str]) -> bool:
        """True for the system and series of a point that a study's own plot shows."""
        return system == self.system and not set(series).isdisjoint(self.series or ())

    def takes(self, name: str, parameters: Parameters) -> bool:
        """True where a point has a value that ``where`` takes of the parameter ``name``."""
        return getattr(parameters, name) in _tuple(self.where[name])

    def place(self, parameters: Parameters) -> tuple[Any, ...]:
        """Return the values that place a point on the curves; points of the same lie on each other.

        Parameters that set how a point is computed do so only where the figure is about them.
        """
        others = {*NUMERICAL, *self.alike} - {*self.axes, *self.groups}
        return tuple(value for name, value in parameters if name not in others)

    @property
    def suffixes(self) -> tuple[str, str, str, str]:
        """Of its files: picture, picture that scales or moves, data behind it, caption."""
        return ".png", ".gif" if self.animated else ".svg", ".csv", ".caption.txt"


def _tuple(value: Any) -> tuple[Any, ...]:
    return value if isinstance(value, tuple) else (value,)


def written(value: Any) -> str:
    """Write a value of a parameter for people."""
    if isinstance(value, bool):
        return str(value).lower()
    return value if isinstance(value, str) else f"{value:g}"


#: Keys of the figures of all kinds.
KEYS_OF_ALL = (
    *("name", "kind", "system", "about", "title"),
    *("where", "words", "lead", "named", "says", "details"),
)

#: Limits that words in braces can name, as they are written there.
_LIMITS = {"creep": CREEP, "largest_portion": LARGEST_PORTION, "share": 100 * SHARE}
_LIMIT_WORDS = {name: f"{value:g}" for name, value in (_LIMITS | {"tallest": TALLEST}).items()}


def keys_of_papers(keys: Keys) -> tuple[str, ...]:
    """Return all keys of a paper's figure of a kind, besides those of all kinds."""
    return tuple(dict.fromkeys((*keys.every, "log", *keys.of_papers.split())))


class FigureFile(FigureSpec):
    """A figure of a paper, as its file has it. Words in braces in its texts are filled in."""

    kind: Annotated[str, AfterValidator(lambda kind: require_kind(kind, kinds()))] = "curves"

    def require_rules(self) -> None:
        super().require_rules()
        systems = self.keys.systems or SYSTEMS
        allowed = f"a kind of the {self.system}; this is one of the {', '.join(systems)}"
        self.require("kind", self.system in systems, allowed)
        for key in ("title", "about", "lead", "named", "says"):
            if key not in self.model_fields_set:
                raise broken_rule(key, None, "text")
        for key in sorted(self.model_fields_set - {*self.keys_of_kind}):
            allowed = f"a key of {self.kind}: {', '.join(self.keys_of_kind)}"
            raise broken_rule(key, getattr(self, key), allowed)
        shown = self.keys.observable
        if shown and shown in self.model_fields_set:
            find_observable(self.kind, shown, self.show, self.system, broken_rule)
        for one in (*self.keys.axes, "curves", "panels", "vary", "where", "named", "alike"):
            value = getattr(self, one) or ()
            for name in [value] if isinstance(value, str) else value:
                require_parameter(one, name, self.system, (), broken_rule)
        for number, measure in enumerate(self.quantities):
            place = f"quantities[{number}]"
            find_observable(self.kind, f"{place}.name", measure.name, self.system, broken_rule)
            if measure.over:
                require_parameter(f"{place}.over", measure.over, self.system, (), broken_rule)

    @property
    def keys_of_kind(self) -> tuple[str, ...]:
        """Names of all its keys."""
        return *KEYS_OF_ALL, *keys_of_papers(self.keys)


class PaperFigures(Strict):
    """The figures of a paper."""

    words: dict[str, Text] = Field({}, description="texts for the braces of all figures")
    figures: list[FigureFile]


def read_figures(paper: Paper) -> list[FigureSpec]:
    """Read ``figures.yaml`` of a paper; a paper without this file has none.

    Raises ``InputError`` for the first wrong or unknown key, kind or name.
    """
    path = paper.folder / "figures.yaml"
    if not path.exists():
        return []
    source, contents = str(path), read_yaml(path)
    match contents:
        case {"figures": [*figures]}:
            for one in figures:
                if isinstance(one, dict):
                    one.setdefault("system", paper.system)
    file = read_into(PaperFigures, contents, source)
    shared = _LIMIT_WORDS | _fill(file.words, _LIMIT_WORDS, source, "words")
    specs = list[FigureSpec]()
    for number, figure in enumerate(file.figures):
        words = {**shared, **figure.words, **figure.where}
        texts = figure.model_dump(include={"title", "lead", "says", "details"})
        follows = {
            **_fill(texts, words, source, f"figures[{number}]"),
            "paper": f"{paper.quote}, {figure.about}",
            "vary": [*filter(None, (figure.panels,)), *figure.vary],
        }
        specs.append(figure.model_copy(update=follows))
    return specs


def _fill(texts: dict[str, str], words: Mapping[str, Any], source: str, key: str) -> dict[str, str]:
    filled = {}
    for name, text in texts.items():
        try:
            filled[name] = text.format(**words)
        except (KeyError, IndexError, TypeError, ValueError) as error:
            got = error.args[0] if isinstance(error, KeyError) else str(error)
            allowed = f"in braces one of {', '.join(words)}"
            raise InputError.of_value(source, f"{key}.{name}", got, allowed) from None
    return filled


class Catalogue(UserDict[str, FigureSpec]):
    """The figures of all papers by name, read when the first of them is asked for.

    ``sources`` are their files, by the names of the figures.
    """

    def __init__(self) -> None:
        """Read nothing yet: many commands need no figure."""

    @cached_property
    def data(self) -> dict[str, FigureSpec]:  # type: ignore[override]
        """The figures; animations come last."""
        figures: dict[str, FigureSpec] = {}
        self.sources: dict[str, Path] = {}
        for paper in papers().values():
            for spec in read_figures(paper):
                if spec.name in figures:
                    path, allowed = paper.folder / "figures.yaml", "a name that no other figure has"
                    raise InputError.of_value(path, "name", spec.name, allowed)
                figures[spec.name] = spec
                self.sources[spec.name] = paper.folder / "figures.yaml"
        return dict(sorted(figures.items(), key=lambda item: item[1].animated))


FIGURES = Catalogue()

# A plug-in may add a paper.
on_change(lambda: FIGURES.__dict__.pop("data", None))
