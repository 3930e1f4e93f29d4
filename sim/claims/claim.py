"""Claims: what a paper or a study says, and the call that declares how runs decide it."""

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from importlib import import_module
from string import Formatter
from typing import Annotated, Any, Literal, Self

from pydantic import Field, SkipValidation, model_validator

from sim.base.additions import (
    TALUS,
    AdditionError,
    add,
    additions,
    attribute_additions_to,
    error_text,
    plugin_error,
    require_name,
    shipped,
)
from sim.base.errors import InputError, in_short, printable
from sim.base.messages import one_of
from sim.base.plugins import (
    NOT_EMPTY,
    Declared,
    declared,
    one_line,
    require_function,
    require_one_of,
    with_declared_types,
)
from sim.claims.verdict import Ambiguous, Check, Line, Untestable
from sim.parameters import SYSTEMS
from sim.parameters.common import broken_rule
from sim.study.entries import JUDGE
from sim.study.figure_spec import FIGURES
from sim.study.papers import OWN, PAPER, Paper, papers

Amount = int | float

#: What a bound may be: a number, a list of numbers, or a list of pairs.
Bound = Amount | list[Amount] | list[list[Amount]]

#: Numbers written as words, by themselves and as factors.
_WORDS = {0.1: "a tenth", 0.5: "half", 1: "one", 2: "two", 5: "five"}
_FACTORS = {2: "twice"}


class _Text(Formatter):
    """Python's format syntax, with formats of its own.

    ``percent`` writes a share in percent, ``words`` a number as a word, ``times`` a factor. A list
    is written with commas, with ``and`` before its last item if that is its format.
    """

    def format_field(self, value: Any, spec: str) -> str:
        if isinstance(value, list):
            return _join(value, spec)
        match spec:
            case "percent":
                return f"{100 * value:g}"
            case "words":
                return _WORDS.get(value, f"{value:g}")
            case "times":
                return _FACTORS.get(value, f"{value:g} times")
        return format(value, spec or "g").replace("e-0", "e-")


def _join(items: Sequence[Any], spec: str) -> str:
    texts = [f"({_join(item, '')})" if isinstance(item, list) else f"{item:g}" for item in items]
    if spec == "and":
        return f"{', '.join(texts[:-1])} and {texts[-1]}"
    return ", ".join(texts)


def fill(text: str, bounds: Mapping[str, Any]) -> str:
    """Return a text with its bounds filled in.

    >>> fill("{share:percent} % at {angles:and} degrees", {"share": 0.1, "angles": [30, 45, 60]})
    '10 % at 30, 45 and 60 degrees'

    Raises `ValueError` when braces in the text name no bound, or a format does not fit it.
    """
    try:
        return _Text().vformat(text, (), bounds)
    except (LookupError, AttributeError, TypeError, ValueError) as error:
        raise ValueError(f"one that fits each brace of {text!r}: {error}") from None


#: Largest number of characters of each text of a claim.
MAX_TEXT = 2000

#: Judge of a claim: returns at least one check, from the runs of one protocol and reading
#: (`sim.claims.evidence`) and, by their names, the bounds of the criterion.
JudgeFunction = Callable[..., Iterable[Check]]

#: Text on one line, and not empty.
Text = Annotated[str, one_line(MAX_TEXT)]
Words = Annotated[Text, NOT_EMPTY]


class First(Declared):
    """The first verdict on a claim, on the runs published then."""

    verdict: Literal["reproduced", "not reproduced", "inconclusive", "untestable"] = Field(
        description="on the first data"
    )
    criterion: Line = Field("", description="the first one, where it was restated")
    why: Line = Field("", description="why it was restated, or why the verdict is another now")


class RoundTwo(Declared):
    """The verdict of the second campaign, and that of a referee on the same runs."""

    verdict: Line = Field(description="under the criteria of the second campaign")
    referee: Line = Field(description="what a referee concluded from the same runs")
    why: Line = Field("", description="why the criterion or the verdict is another now")


class Number(Declared):
    """A bound of a criterion that the paper does not give."""

    bound: str = Field(exclude=True, description="its name in the criterion and for the judge")
    what: Line = Field(min_length=1, description="the number in words")
    values: list[float] = Field(min_length=2, description="those under which it is judged")
    headline: float = Field(description="the one that gives the verdict")
    unit: Line = Field("", description="unit of the values")

    @model_validator(mode="after")
    def _has_headline_value(self) -> Self:
        if self.headline not in self.values:
            raise broken_rule("headline", self.headline, f"one of the values {self.values}")
        return self


class Claim(Declared):
    """One claim and how it is decided; `judge` declares it."""

    id: str = Field(description="its name")
    title: Words = Field(description="a few words")
    statement: Words = Field(description="what is claimed, of a paper in other words")
    place: Line = Field("", description="section or figure of the paper")
    criterion: Words = Field(description="when it holds, filled from the bounds")
    bounds: dict[str, Bound] = Field({}, exclude=True, description="numbers of the criterion")
    reason: Text = Field("", description="why the criterion is what it is")
    needs: Text = Field("", description="runs that decide it")
    instead: Text = Field("", description="what happens instead, where it does not simply hold")
    kind: Literal["model", "check", "flow"] = Field(
        "flow", description="on the model, judged by itself; so from runs; or a statement on flows"
    )
    figures: list[str] = Field([], description="figures that show it")
    first: First | None = Field(None, description="how it was judged first")
    round_two: RoundTwo | None = Field(None, description="how it was judged in the second round")
    parts: dict[str, Line] = Field({}, description="what it says, where that is several things")
    contradiction: Line = Field("", description="why its parts cannot both hold")
    condition: Line = Field("", description="what its verdict holds for, where not for everything")
    protocol: Literal["", "published", "converged"] = Field(
        "", description="the protocol that decides it; else converged runs do where there are any"
    )
    number: Number | None = Field(None, description="what the paper does not give")
    alternatives: dict[Line, dict[str, Bound]] = Field(
        {}, exclude=True, description="other readings of this claim alone: other bounds, by words"
    )
    paper: Line = Field(OWN, description="short name of its paper")
    system: str = Field(description="system whose runs decide it")
    judge: SkipValidation[JudgeFunction] = Field(exclude=True, description="its judge")

    @model_validator(mode="after")
    def _names_bounds_and_figures(self) -> Self:
        for name in self.figures:
            if name not in FIGURES:
                raise broken_rule("figures", name, one_of(name, FIGURES))
        for name in {name for changes in self.alternatives.values() for name in changes}:
            if name not in self.bounds:
                raise broken_rule("alternatives", name, f"one of the bounds {[*self.bounds]}")
        try:
            self.texts()
        except ValueError as error:
            raise broken_rule("bounds", self.bounds, str(error)) from None
        return self

    def texts(self) -> dict[str, str]:
        """Return the texts that name bounds, filled from them at the headline number.

        Braces in the texts of a claim without bounds name none.
        """
        bounds = self.bounds_at()
        texts = {"criterion": self.criterion, "reason": self.reason, "needs": self.needs}
        return {key: fill(text, bounds) for key, text in texts.items()} if bounds else texts

    def bounds_at(self, number: float | None = None) -> dict[str, Bound]:
        """Return the arguments of the judge, with a value of the number or its headline."""
        if self.number is None:
            return self.bounds
        return self.bounds | {self.number.bound: self.number.headline if number is None else number}

    def checks_on(
        self, subject: Any, number: float | None = None, alternative: str = ""
    ) -> tuple[Check, ...]:
        """Return the checks of the judge on evidence, or on a reading for a claim on the model.

        The number that the paper does not give has the value ``number``, by default its headline;
        the ``alternative`` is one of the other readings of the claim, by its words. Raises
        `Untestable`, `Ambiguous` or `ZeroDivisionError` when runs are missing or may be either of
        two flows, or a quantity to divide by is zero, and `InputError` for any other error of a
        plug-in's judge, with its line there.
        """
        try:
            bounds = self.bounds_at(number) | self.alternatives.get(alternative, {})
            checks = tuple(self.judge(subject, **bounds))
            if not all(isinstance(check, Check) for check in checks) or not checks:
                raise TypeError("a judge returns checks, one at least")
            checks = tuple(map(_usable, checks))
            parts = {check.part for check in checks if check.has_vote}
            if unknown := parts - set(self.parts or ("",)):
                raise ValueError(f"{self.id} has no part {', '.join(sorted(unknown))}")
            if self.kind != "model":
                subject.require_points({*check.points, *check.short} for check in checks)
            return checks
        except (Untestable, Ambiguous) as error:
            raise type(error)(printable(str(error))) from None
        except ZeroDivisionError:
            raise
        except (Exception, SystemExit) as error:
            if self.id not in additions(JUDGE):
                raise
            raise plugin_error(JUDGE, self.id, error) from None


def _usable(check: Check) -> Check:
    """Return a check with plain values, whose texts have no control characters."""
    label = f"check {in_short(check.what)}"
    check = with_declared_types(label, check)
    if not check.low <= check.high:
        raise AdditionError(f"{label}.low: got {in_short(check.low)}; allowed: a number <= high")
    return check


def judge(name: str, *, system: str, **fields: Any) -> Callable[[JudgeFunction], JudgeFunction]:
    """Declare a claim on the runs of a study; the decorated function judges it.

    The function takes the evidence of one protocol and reading (`sim.claims.evidence`), and the
    bounds by their names. It returns checks (`sim.claims.checks`), all of which must hold. It
    raises `Untestable` where runs are missing.

    Parameters
    ----------
    name : str
        Name of the claim.
    system : str
        A system of `sim.parameters.SYSTEMS`, ``chute`` or ``belt`` for instance.
    **fields
        Other fields of `Claim`: it needs ``title``, ``statement`` and ``criterion``. ``bounds`` has
        the numbers of the criterion by name: ``{name}`` in ``criterion``, ``reason`` and ``needs``
        is filled from it.
    """
    require_name(JUDGE, name)
    require_one_of(f"judge {name}: system", system, SYSTEMS)

    def register(function: JudgeFunction) -> JudgeFunction:
        claim = declared(Claim, f"judge {name}", id=name, judge=function, system=system, **fields)
        require_function(f"judge {name}", function, takes=1, named=claim.bounds_at())
        add(JUDGE, name, claim)
        return function

    return register


def declare_claims(paper: Paper) -> None:
    """Declare the claims of a paper by `judge`, once, from its ``claims.yaml`` if it has one.

    Each claim there has the arguments of `judge`, its name as ``id`` and its function as ``judge``,
    such as ``judges.onset`` of a module ``judges`` beside the file. Raises `InputError` for a file
    that is not readable, and for the first wrong claim.
    """
    if paper.name in {claim.paper for claim in _registered()}:
        return
    path = paper.folder / "claims.yaml"
    of_plugin = additions(PAPER).get(paper.name)
    try:
        with attribute_additions_to(of_plugin.plugin if of_plugin else TALUS):
            for number, claim in enumerate(paper.claims):
                words = dict(claim)
                name, place = words.pop("id"), words.pop("judge")
                function = _find_judge(paper, f"claims[{number}].judge", place)
                judge(name, **words, paper=paper.name, system=paper.system)(function)
    except InputError:
        raise
    except Exception as error:
        # Judges of plug-ins are anybody's code.
        raise InputError(f"{path}: {error_text(error, paper.folder)}") from None


def _find_judge(paper: Paper, key: str, place: Any) -> JudgeFunction:
    """Return the function that is named as ``judges.onset``."""
    path, module = paper.folder / "claims.yaml", str(place).rpartition(".")[0]
    file = paper.folder / module.replace(".", "/")
    if not module or not (file.is_dir() or file.with_name(f"{file.name}.py").is_file()):
        allowed = "a function of a module beside this file, as judges.onset"
        raise InputError.of_value(path, key, place, allowed)
    held = vars(import_module(f"{paper.package}.{module}"))
    names = {f"{module}.{name}": name for name, one in held.items() if callable(one)}
    if place not in names:
        own = [
            one for one in names if getattr(held[names[one]], "__module__", "") == held["__name__"]
        ]
        raise InputError.of_value(path, key, place, one_of(place, own))
    function: JudgeFunction = held[names[place]]
    return function


def claims(systems: Collection[str] = tuple(SYSTEMS)) -> list[Claim]:
    """Return the claims on systems: those of the papers that ship, then those of plug-ins.

    Judges of papers on other systems are not loaded: some of them load the engine.
    """
    every = papers()
    for paper in every.values():
        if paper.system in systems:
            declare_claims(paper)
    order = {name: number for number, name in enumerate(every)}
    of_systems = [claim for claim in _registered() if claim.system in systems]
    return sorted(of_systems, key=lambda claim: order.get(claim.paper, len(order)))


def _registered() -> list[Claim]:
    of_plugins = (addition.value for addition in additions(JUDGE).values())
    return [*shipped(JUDGE).values(), *of_plugins]
