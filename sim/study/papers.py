"""Papers: what one says of itself, and the call that adds one.

A paper is a package with ``paper.yaml``, and where it has them ``figures.yaml``
(`sim.study.figure_spec`) and ``claims.yaml`` with the functions that judge them.
"""

import sys
from collections.abc import Iterable, Mapping
from functools import cached_property
from importlib import import_module
from itertools import chain
from pathlib import Path
from typing import Any, Literal

from pydantic import Field

from sim.base.additions import add, additions, shipped
from sim.base.errors import InputError
from sim.base.plugins import module_names, require_one_of
from sim.base.yaml import read_yaml
from sim.parameters import SYSTEMS, Parameters, default_of, field_info, parse_point
from sim.parameters.in_place import given_by
from sim.parameters.laws import LAW
from sim.parameters.words import quantity, setting
from sim.study.entries import NATURAL, Strict, Text, read_into

#: Kind of the additions that are papers; and what stands for one of a study's own claims.
PAPER, OWN = "paper", "own"

#: Package of the papers that ship; nothing imports it by a statement.
SHIPPED = "sim.papers"


class Control(Strict):
    """Values of parameters that are no reading of the paper, and why."""

    values: dict[str, Any] = Field(min_length=1)
    why: Text = Field(min_length=1)


class Readings(Strict):
    """How a paper is read."""

    headline: dict[str, Any] = Field({}, description="what differs from the defaults")
    why: Text = Field("nothing in the paper is open", description="why it gives the verdicts")
    open: dict[str, Text] = Field({}, description="by parameter, the words that leave it open")
    rows: dict[str, list[float]] = Field(
        {}, description="by parameter of the grid, values of base rows that are readings as well"
    )
    grids: dict[str, Text] = Field(
        {}, description="by grid of the profiles other than the usual one, what it is"
    )
    model: list[dict[str, Any]] = Field(
        [{}], description="those under which claims on the model itself are judged"
    )
    controls: list[Control] = Field([], description="what is no reading")

    def control_reason(self, reading: Mapping[str, Any]) -> str:
        """Return why a reading is not one of the paper's, empty where it is one."""
        if LAW.is_own(reading.get("law", "")):
            return "the law of a plug-in"
        for control in self.controls:
            if control.values.items() <= reading.items():
                return control.why
        return ""

    def sentences(self, reading: Mapping[str, Any]) -> list[str]:
        """Return the words of the paper that leave a reading open."""
        return [self.open[name] for name in reading if name in self.open]


class Paper(Strict):
    """A paper, by its file ``paper.yaml``; ``package`` has its judges, ``folder`` its files."""

    name: Text = Field(description="short name, by which figures and verdicts name it")
    author: Text = Field(min_length=1, description="who wrote it, for headings")
    quote: Text = Field(min_length=1, description="how captions quote it, such as Walton (1993)")
    system: str = Field(description="system whose runs draw its figures and decide its claims")
    headline: list[Text] = Field([], description="its figures on the first screen of a report")
    defaults: dict[str, dict[str, Any]] = Field(
        {}, description="its own values of parameters, by system, as in a study file"
    )
    units: Literal["si", "natural"] = Field(
        "si", description="`natural`: diameter, mass and gravity are 1, as in a study file"
    )
    readings: Readings = Field(Readings(), description="how it is read")
    folder: Path = Field(exclude=True)
    package: str = Field(exclude=True)

    @cached_property
    def values(self) -> dict[str, dict[str, Any]]:
        """Its own values by system, valid together and in canonical form."""
        found, units = {}, NATURAL if self.units == "natural" else {}
        for system in {*self.defaults, *([self.system] if units else [])}:
            given = units | self.defaults.get(system, {})
            paths = {name: f"defaults.{system}.{name}" for name in (*given, "system")}
            point = parse_point({**given, "system": system}, self.folder / "paper.yaml", paths)
            names = chain(*(given_by(type(point), name) for name in given))
            found[system] = {name: getattr(point, name) for name in names}
        return found

    def usual(self, system: str, row: Mapping[str, Any]) -> dict[str, Any]:
        """Return its own values for points like ``row``: not those of another law or motion."""
        own = self.values.get(system, {})
        unused = SYSTEMS[system].without_effect(own | dict(row)) if own else ()
        return {name: value for name, value in own.items() if name not in unused}

    @cached_property
    def claims(self) -> list[dict[str, Any]]:
        """Its claims as ``claims.yaml`` has them, empty without this file."""
        path = self.folder / "claims.yaml"
        contents = read_yaml(path) if path.exists() else {"claims": []}
        match contents:
            case {"claims": [*claims]} if len(contents) == 1:
                for number, claim in enumerate(claims):
                    if not (isinstance(claim, dict) and {"id", "judge"} <= claim.keys()):
                        allowed = "a mapping with id, judge and the words of a claim"
                        raise InputError.of_value(str(path), f"claims[{number}]", claim, allowed)
                    if claim["id"] in [one["id"] for one in claims[:number]]:
                        key, allowed = f"claims[{number}].id", "a name that no other claim has"
                        raise InputError.of_value(str(path), key, claim["id"], allowed)
                return claims
        raise InputError.of_value(str(path), "", contents, "claims, a list, and nothing else")


def paper(package: str) -> None:
    """Declare a paper, from the files beside the module that calls this.

    Parameters
    ----------
    package : str
        ``__name__`` of the package of the paper.
    """
    folder = Path(str(sys.modules[package].__file__)).parent
    path = folder / "paper.yaml"
    contents, place = read_yaml(path), {"folder": folder, "package": package}
    contents = contents | place if isinstance(contents, dict) else contents
    one = read_into(Paper, contents, str(path))
    require_one_of(f"{path}: system", one.system, SYSTEMS)
    # Papers that ship are imported after plug-ins, but their names are taken.
    add(PAPER, one.name, one, reserved=(*module_names("sim.papers"), OWN))


def papers() -> dict[str, Paper]:
    """Return all papers by name: those that ship, then those of plug-ins.

    Of those that ship the ones whose values Talus has come first, then they go by their systems.
    """
    import_module(SHIPPED)
    order = list(SYSTEMS)
    every = sorted(
        shipped(PAPER).values(), key=lambda one: (bool(one.defaults), order.index(one.system))
    )
    every += [addition.value for addition in additions(PAPER).values()]
    return {one.name: one for one in every}


def foreign_papers(study: str) -> set[str]:
    """Return the papers that ship and whose values points of a study lack.

    ``study`` is the paper that the study names. If that has values of its own, these are all
    others, else those with values of their own.
    """
    own = papers().get(study)
    others = (one for one in shipped(PAPER).values() if one.name != study)
    return {one.name for one in others if one.defaults or (own and own.defaults)}


def default_in(one: Paper | None, system: str, name: str, row: Mapping[str, Any]) -> Any:
    """Return a paper's value of a parameter for points like ``row``, else the usual default."""
    own = one.usual(system, row) if one and name in one.values.get(system, {}) else {}
    return own[name] if name in own else default_of(SYSTEMS[system], name, row)


def paper_values(points: Iterable[Parameters], paper: str = "") -> dict[str, list[str]]:
    """Return what points have as a paper has it, by paper and system: ``Walton (1993), chute``.

    That are the own values of the study's ``paper``, if it names one, and numbers of the physics
    that a source in a paper is declared for, but for those that are zero and so without effect.
    """
    by_system: dict[str, list[Parameters]] = {}
    for point in points:
        by_system.setdefault(point.system, []).append(point)
    values: dict[str, list[str]] = {}
    for system, members in by_system.items():
        unused = set.intersection(*(one.without_effect(vars(one)) for one in members))
        if one := papers().get(paper):
            own = one.usual(system, vars(members[0]))
            kept = [name for name in own if {vars(one)[name] for one in members} == {own[name]}]
            texts = [setting(system, name, own[name]) for name in kept]
            values |= {f"{one.quote}, {system}": texts} if kept else {}
            unused |= {*kept}
        for name, row in field_info(members[0]).items():
            is_number = type(row.default) in (int, float) and row.default != 0
            if row.role != "physics" or not is_number or name in unused:
                continue
            is_left = all(getattr(point, name) == row.default for point in members)
            for source in papers().values() if is_left else ():
                if row.equation.startswith(source.author.split()[0]):
                    texts = values.setdefault(f"{source.quote}, {system}", [])
                    texts.append(quantity(system, name, [row.default]))
    return values


def paper_value_lines(points: Iterable[Parameters], paper: str) -> list[str]:
    """Return a line for each paper and system."""
    values = paper_values(points, paper).items()
    return [f"left as in {heading}: {', '.join(texts)}" for heading, texts in values]
