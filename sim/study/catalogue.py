"""The papers' figures: entries of YAML files, which are plots of a study file with further keys."""

from collections import UserDict
from collections.abc import Mapping
from functools import cached_property
from typing import Annotated, Any, Self

from pydantic import AfterValidator, Field, ValidationError, model_validator

from sim.base.additions import on_change
from sim.base.errors import InputError
from sim.base.messages import input_error, one_of
from sim.base.yaml import read_yaml
from sim.parameters import SYSTEMS
from sim.parameters.common import broken_rule
from sim.study.entries import Strict, Text
from sim.study.figure_spec import FigureSpec
from sim.study.papers import Paper, papers
from sim.study.plot_kinds import CREEP, LARGEST_PORTION, SHARE, TALLEST, kinds
from sim.study.plottable import find_observable, require_parameter

#: Keys of the figures of all kinds.
KEYS_OF_ALL = (
    *("name", "kind", "system", "about", "title"),
    *("where", "words", "lead", "named", "says", "details"),
)

#: Limits that words in braces can name, as they are written there.
_LIMITS = {
    "creep": f"{CREEP:g}",
    "largest_portion": f"{LARGEST_PORTION:g}",
    "share": f"{100 * SHARE:g}",
    "tallest": f"{TALLEST:g}",
}


def _require_kind(kind: str) -> str:
    if kind not in kinds():
        raise broken_rule("", kind, one_of(kind, kinds()))
    return kind


class FigureFile(FigureSpec):
    """A figure of a paper, as its file has it. Words in braces in its texts are filled in."""

    kind: Annotated[str, AfterValidator(_require_kind)] = "curves"

    @model_validator(mode="after")
    def _require_keys_of_figures(self) -> Self:
        systems = self.keys.systems or SYSTEMS
        if self.system not in systems:
            allowed = f"a kind of the {self.system}; this is one of the {', '.join(systems)}"
            raise broken_rule("kind", self.kind, allowed)
        for key in ("title", "about", "lead", "named", "says"):
            if key not in self.model_fields_set:
                raise broken_rule(key, None, "text")
        for key in sorted(self.model_fields_set - {*self.keys_of_kind}):
            allowed = f"a key of {self.kind}: {', '.join(self.keys_of_kind)}"
            raise broken_rule(key, getattr(self, key), allowed)
        return self

    @model_validator(mode="after")
    def _require_parameters(self) -> Self:
        shown = self.keys.observable
        if shown and shown in self.model_fields_set:
            find_observable(self.kind, shown, self.observable, self.system, broken_rule)
        key: str
        for key in (*self.keys.axes, "curves", "panels", "vary", "where", "named", "alike"):
            value = getattr(self, key) or ()
            for name in [value] if isinstance(value, str) else value:
                require_parameter(key, name, self.system, (), broken_rule)
        for number, measure in enumerate(self.quantities):
            key = f"quantities[{number}]"
            find_observable(self.kind, f"{key}.name", measure.name, self.system, broken_rule)
            if measure.over:
                require_parameter(f"{key}.over", measure.over, self.system, (), broken_rule)
        return self

    @property
    def keys_of_kind(self) -> tuple[str, ...]:
        """Names of all its keys."""
        return *KEYS_OF_ALL, *(self.keys.of_papers.split() or (*self.keys.every, "log"))


class PaperFigures(Strict):
    """The figures of a paper."""

    words: dict[str, Text] = Field({}, description="texts for the braces of all figures")
    figures: list[FigureFile]


def _give_system(contents: Any, system: str) -> Any:
    """Return contents of a file whose figures are of a system, but where they name another."""
    match contents:
        case {"figures": [*figures]}:
            figures = [
                {"system": system, **one} if isinstance(one, dict) else one for one in figures
            ]
            return contents | {"figures": figures}
    return contents


def read_figures(paper: Paper) -> list[FigureSpec]:
    """Read ``figures.yaml`` of a paper; a paper without this file has none.

    Raises
    ------
    InputError
        For a file that is not readable, and for the first wrong or unknown key, kind or name.
    """
    path = paper.folder / "figures.yaml"
    if not path.exists():
        return []
    source = str(path)
    try:
        file = PaperFigures.model_validate(_give_system(read_yaml(path), paper.system))
    except ValidationError as error:
        raise input_error(error, PaperFigures, source) from None
    words = _LIMITS | _fill(file.words, _LIMITS, source, "words")
    return [
        _spec(paper, figure, words, source, f"figures[{number}]")
        for number, figure in enumerate(file.figures)
    ]


def _spec(
    paper: Paper, figure: FigureFile, words: Mapping[str, str], source: str, key: str
) -> FigureSpec:
    words = {**words, **figure.words, **figure.where}
    texts = _fill(
        figure.model_dump(include={"title", "lead", "says", "details"}), words, source, key
    )
    return figure.model_copy(
        update={
            **texts,
            "paper": f"{paper.quote}, {figure.about}",
            "vary": [*filter(None, (figure.panels,)), *figure.vary],
        }
    )


def _fill(
    texts: Mapping[str, str], words: Mapping[str, Any], source: str, key: str
) -> dict[str, str]:
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
    """The figures of all papers by name, read when the first of them is asked for."""

    def __init__(self) -> None:
        """Read nothing yet: many commands need no figure."""

    @cached_property
    def data(self) -> dict[str, FigureSpec]:  # type: ignore[override]
        """The figures; animations come last."""
        figures: dict[str, FigureSpec] = {}
        for paper in papers().values():
            for spec in read_figures(paper):
                if spec.name in figures:
                    allowed = "a name that no other figure has"
                    raise InputError.of_value(
                        str(paper.folder / "figures.yaml"), "name", spec.name, allowed
                    )
                figures[spec.name] = spec
        return dict(sorted(figures.items(), key=lambda item: item[1].animated))


FIGURES = Catalogue()

# A plug-in may add a paper.
on_change(lambda: FIGURES.__dict__.pop("data", None))
