"""Points of a study while they are collected: defaults, base, grid or cases, overrides."""

import itertools
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

from sim.parameters import Parameters, parse_point
from sim.study.entries import BoundaryFile, SeriesFile
from sim.study.file import StudyFile


@dataclass
class Draft:
    """Values of one point while they are collected, and where each stands in the file."""

    values: dict[str, Any] = field(default_factory=dict)
    paths: dict[str, str] = field(default_factory=dict)

    def with_values(self, values: dict[str, Any], path: str) -> "Draft":
        """Return a copy in which ``values``, given at ``path``, replace earlier ones."""
        paths = {name: f"{path}.{name}" for name in values}
        return Draft(self.values | values, self.paths | paths)


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
    draft = _base(file, one, path)
    cases = one.cases if isinstance(one, SeriesFile) else None
    if one.grid:
        yield from _combinations(one, draft, path)
    for index, case in enumerate(cases or []):
        yield draft.with_values(case.given(), f"{path}.cases[{index}]")
    if not one.grid and not cases:
        yield draft


def _base(file: StudyFile, one: SeriesFile | BoundaryFile, path: str) -> Draft:
    """Return what all points of a series or boundary share."""
    draft = Draft({"system": one.system}, {"system": f"{path}.system"})
    shared = getattr(file.defaults, one.system)
    if shared:
        draft = draft.with_values(shared.given(), f"defaults.{one.system}")
    return draft.with_values(one.base.given(), f"{path}.base") if one.base else draft


def _combinations(one: SeriesFile | BoundaryFile, draft: Draft, path: str) -> Iterator[Draft]:
    """Yield a draft for every combination of a grid."""
    lists = one.grid.given()
    for chosen in itertools.product(*(enumerate(values) for values in lists.values())):
        places = dict(zip(lists, chosen, strict=True))
        yield Draft(
            draft.values | {name: value for name, (_, value) in places.items()},
            draft.paths | {name: f"{path}.grid.{name}[{i}]" for name, (i, _) in places.items()},
        )


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
