"""Drafts of the points of a study: from defaults to overrides, under every reading."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from itertools import product
from typing import Any

from sim.parameters import SYSTEMS, Parameters, parse_point
from sim.study.entries import BoundaryFile, SeriesFile
from sim.study.file import StudyFile


@dataclass
class Draft:
    """Values of a point while they are collected, with the key of each in the file.

    ``other_readings`` names the readings that differ from the first one in the study.
    """

    values: dict[str, Any] = field(default_factory=dict)
    paths: dict[str, str] = field(default_factory=dict)
    other_readings: frozenset[str] = frozenset()

    def with_values(self, values: dict[str, Any], path: str) -> "Draft":
        """Return a copy in which ``values``, given at ``path``, replace earlier ones."""
        paths = {name: f"{path}.{name}" for name in values}
        return replace(self, values=self.values | values, paths=self.paths | paths)

    def with_choice(
        self, lists: dict[str, list[Any]], indices: Sequence[int], path: str
    ) -> "Draft":
        """Return a copy with one value of each list at ``path``, by its index in the list."""
        choice = dict(zip(lists, indices, strict=True))
        values = {name: lists[name][index] for name, index in choice.items()}
        paths = {name: f"{path}.{name}[{index}]" for name, index in choice.items()}
        return replace(self, values=self.values | values, paths=self.paths | paths)


def make_drafts(file: StudyFile, entry: SeriesFile | BoundaryFile, path: str) -> Iterator[Draft]:
    """Yield the drafts of the points of a series, or of the boundaries of an entry.

    Parameters
    ----------
    file : StudyFile
        The study.
    entry : SeriesFile or BoundaryFile
        The series, or the entry with boundaries.
    path : str
        Its key in the file.
    """
    cases = entry.cases if isinstance(entry, SeriesFile) else None
    for draft in _base_drafts(file, entry, path):
        if entry.grid:
            lists = entry.grid.explicit_values()
            for indices in _combinations(lists):
                yield draft.with_choice(lists, indices, f"{path}.grid")
        for index, case in enumerate(cases or []):
            yield draft.with_values(case.explicit_values(), f"{path}.cases[{index}]")
        if not entry.grid and not cases:
            yield draft


def _base_drafts(file: StudyFile, entry: SeriesFile | BoundaryFile, path: str) -> Iterator[Draft]:
    """Yield the base of a series under each reading, or of boundaries under the first one."""
    draft = Draft({"system": entry.system}, {"system": f"{path}.system"})
    shared, readings = getattr(file.defaults, entry.system), getattr(file.readings, entry.system)
    if shared:
        draft = draft.with_values(shared.explicit_values(), f"defaults.{entry.system}")
    lists = readings.explicit_values() if readings else {}
    for indices in _combinations(lists):
        if any(indices) and not isinstance(entry, SeriesFile):
            return
        base = draft.with_choice(lists, indices, f"readings.{entry.system}")
        if entry.base:
            base = base.with_values(entry.base.explicit_values(), f"{path}.base")
        other_readings = (name for name, index in zip(lists, indices, strict=True) if index)
        yield replace(base, other_readings=frozenset(other_readings))


def readings_by_system(file: StudyFile) -> dict[str, list[dict[str, Any]]]:
    """Return the readings of all series by system, each as values that differ from the defaults."""
    readings = {}
    for system, model in SYSTEMS.items():
        lists, default = getattr(file.readings, system), model()
        if lists:
            choices = lists.explicit_values()
            combinations = (
                dict(zip(choices, values, strict=True)) for values in product(*choices.values())
            )
            readings[system] = [
                {name: value for name, value in reading.items() if value != getattr(default, name)}
                for reading in combinations
            ]
    return readings


def _combinations(lists: dict[str, list[Any]]) -> Iterator[tuple[int, ...]]:
    """Yield the indices of the values of every combination of some lists, in lexical order."""
    yield from product(*(range(len(values)) for values in lists.values()))


def apply_overrides(
    entry: SeriesFile | BoundaryFile, draft: Draft, path: str, source: str
) -> Parameters:
    """Return the validated parameters of a draft, with the overrides whose conditions it meets.

    Conditions apply to the point before any override, defaults included. Later overrides win.

    Raises
    ------
    InputError
        With the key in the file and the allowed values.
    """
    before = parse_point(draft.values, source, draft.paths)
    changes = [
        (override.set.explicit_values(), f"{path}.overrides[{index}].set")
        for index, override in enumerate(entry.overrides)
        if all(
            getattr(before, name) in values
            for name, values in override.when.explicit_values().items()
        )
    ]
    for values, key in changes:
        draft = draft.with_values(values, key)
    return parse_point(draft.values, source, draft.paths) if changes else before
