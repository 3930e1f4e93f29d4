"""Points of a study while they are collected: defaults to overrides, under every reading."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from itertools import product
from typing import Any

from sim.parameters import SYSTEMS, Parameters, parse_point
from sim.study.entries import BoundaryFile, SeriesFile
from sim.study.file import StudyFile


@dataclass
class Draft:
    """Values of one point while they are collected, and where each stands in the file.

    ``other`` are the readings in which it differs from those that the study gives first.
    """

    values: dict[str, Any] = field(default_factory=dict)
    paths: dict[str, str] = field(default_factory=dict)
    other: frozenset[str] = frozenset()

    def with_values(self, values: dict[str, Any], path: str) -> "Draft":
        """Return a copy in which ``values``, given at ``path``, replace earlier ones."""
        paths = {name: f"{path}.{name}" for name in values}
        return replace(self, values=self.values | values, paths=self.paths | paths)

    def with_choice(self, lists: dict[str, list[Any]], chosen: Sequence[int], path: str) -> "Draft":
        """Return a copy with one value of each list at ``path``, those of the numbers chosen."""
        places = dict(zip(lists, chosen, strict=True))
        values = {name: lists[name][number] for name, number in places.items()}
        paths = {name: f"{path}.{name}[{number}]" for name, number in places.items()}
        return replace(self, values=self.values | values, paths=self.paths | paths)


def starts(file: StudyFile, one: SeriesFile | BoundaryFile, path: str) -> Iterator[Draft]:
    """Yield what the points of a series, or the boundaries of an entry, start from.

    Parameters
    ----------
    file : StudyFile
        The study.
    one : SeriesFile or BoundaryFile
        The series or the entry.
    path : str
        Where it stands in the file.
    """
    cases = one.cases if isinstance(one, SeriesFile) else None
    for draft in _bases(file, one, path):
        if one.grid:
            lists = one.grid.given()
            for chosen in _combinations(lists):
                yield draft.with_choice(lists, chosen, f"{path}.grid")
        for index, case in enumerate(cases or []):
            yield draft.with_values(case.given(), f"{path}.cases[{index}]")
        if not one.grid and not cases:
            yield draft


def _bases(file: StudyFile, one: SeriesFile | BoundaryFile, path: str) -> Iterator[Draft]:
    """Yield what all points of a series share under each reading, of a boundary under the first."""
    draft = Draft({"system": one.system}, {"system": f"{path}.system"})
    shared, readings = getattr(file.defaults, one.system), getattr(file.readings, one.system)
    if shared:
        draft = draft.with_values(shared.given(), f"defaults.{one.system}")
    lists = readings.given() if readings else {}
    for chosen in _combinations(lists):
        if any(chosen) and not isinstance(one, SeriesFile):
            return
        read = draft.with_choice(lists, chosen, f"readings.{one.system}")
        base = read.with_values(one.base.given(), f"{path}.base") if one.base else read
        other = (name for name, number in zip(lists, chosen, strict=True) if number)
        yield replace(base, other=frozenset(other))


def every_reading(file: StudyFile) -> dict[str, list[dict[str, Any]]]:
    """Return by system the readings of every series, each as what differs from the defaults."""
    found = {}
    for system, model in SYSTEMS.items():
        lists, usual = getattr(file.readings, system), model()
        if lists:
            given = lists.given()
            every = (dict(zip(given, values, strict=True)) for values in product(*given.values()))
            found[system] = [
                {name: value for name, value in one.items() if value != getattr(usual, name)}
                for one in every
            ]
    return found


def _combinations(lists: dict[str, list[Any]]) -> Iterator[tuple[int, ...]]:
    """Yield the numbers of the values for every combination of some lists, the first ones first."""
    yield from product(*(range(len(values)) for values in lists.values()))


def finished(one: SeriesFile | BoundaryFile, draft: Draft, path: str, source: str) -> Parameters:
    """Apply the overrides whose conditions a point meets, later ones last, and validate it.

    Conditions look at the point as it is before any override, omitted parameters included.

    Raises
    ------
    InputError
        Naming the place in the file and what is allowed.
    """
    before = parse_point(draft.values, source, draft.paths)
    met = [
        (override.set.given(), f"{path}.overrides[{index}].set")
        for index, override in enumerate(one.overrides)
        if all(getattr(before, name) in values for name, values in override.when.given().items())
    ]
    for values, place in met:
        draft = draft.with_values(values, place)
    return parse_point(draft.values, source, draft.paths) if met else before
