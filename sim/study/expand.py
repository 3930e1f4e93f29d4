"""Third step of a study: expand its validated files to points, series and boundaries."""

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from itertools import product
from os.path import isfile
from pathlib import Path
from typing import Any

from sim.base.errors import InputError
from sim.base.messages import number_and_unit
from sim.parameters import (
    RUN_FILE,
    SYSTEMS,
    Parameters,
    amounts,
    parse_point,
    point_id,
    require_compatible_source,
    roles,
    with_larger_amounts,
)
from sim.parameters.common import PREVIOUS
from sim.parameters.in_place import given_by, plain_numbers, plain_values, rivals, scales
from sim.study.design import Axis
from sim.study.design_file import DesignFile
from sim.study.entries import NATURAL
from sim.study.figure_spec import FIGURES
from sim.study.file import MAX_POINTS, BoundaryFile, SeriesFile, StudyFile
from sim.study.model import Boundary, Point, Study, divide_range
from sim.study.papers import papers

#: Number of last letters of an id that tell it apart, from the hyphen before its hash on.
_HASH = 9


def expand(files: Sequence[tuple[Path, StudyFile]]) -> Study:
    """Return the study that a file and its parts, with their paths, describe, without its figures.

    Raises ``InputError`` for a point that is not valid, a start from a point or file that is not
    there, and too many points.
    """
    points, series, boundaries = dict[str, Point](), dict[str, tuple[str, ...]](), list[Boundary]()
    axes, designs = dict[str, tuple[Axis, ...]](), dict[str, DesignFile]()
    for path, file in files:
        for key, entry in file.entries:
            family = _Family(file, entry, key, str(path))
            boundaries += (own := list(family.boundaries()))
            series[entry.name] = ids = family.add_to(points, own)
            if isinstance(entry, SeriesFile):
                axes[entry.name] = entry.axes([points[one].parameters for one in ids])
            if family.design:
                designs[entry.name] = family.design
    path, file = files[0]
    _require_valid_points(points, str(path))
    paths, vary = tuple(path for path, _ in files), (tuple(boundaries), axes, designs)
    rest: dict[str, Any] = {"readings": _readings_by_system(file), "decide": file.decide}
    rest |= {"paper": file.paper or "", "units": "natural" if file.is_natural else "si"}
    return Study(file.study, file.title, paths, points, series, *vary, **rest)


@dataclass(frozen=True)
class _Draft:
    """Values of a point while they are collected, with the key of each in the file.

    ``other_readings`` names the readings that differ from the first one in the study,
    ``of_paper`` the values that are the paper's, which holds them for its own law alone;
    ``follows`` is whether another point of its list or cases comes before.
    """

    values: dict[str, Any] = field(default_factory=dict)
    paths: dict[str, str] = field(default_factory=dict)
    other_readings: frozenset[str] = frozenset()
    of_paper: frozenset[str] = frozenset()
    follows: bool = False

    def with_values(self, values: dict[str, Any], path: str) -> "_Draft":
        """Return a copy in which ``values``, given at ``path``, replace earlier ones."""
        return self._replaced(values, {name: f"{path}.{name}" for name in values})

    def _replaced(self, values: dict[str, Any], paths: dict[str, str]) -> "_Draft":
        gone = set().union(*map(rivals, values)) - values.keys()
        earlier = {name: value for name, value in self.values.items() if name not in gone}
        left = self.of_paper - values.keys()
        return replace(self, values=earlier | values, paths=self.paths | paths, of_paper=left)

    def with_whole_start(self, points: Collection[str]) -> "_Draft":
        """Return a copy that starts from the one point whose id ends as that given, its hash."""
        start = str(self.values.get("start_from", ""))
        ends = [one for one in points if one.endswith(start[-_HASH:])]
        if not start or start in points or len(ends) != 1:
            return self
        return replace(self, values=self.values | {"start_from": ends[0]})

    def point(self, source: str) -> Parameters:
        """Return the parameters of the point, without values of the paper for another law."""
        model = SYSTEMS[self.values["system"]]
        gone = self.of_paper & model.without_effect(self.values) if self.of_paper else ()
        values = {name: value for name, value in self.values.items() if name not in gone}
        return parse_point(values, source, self.paths)

    def after(self, previous: str) -> "_Draft":
        """Return a copy in which the start from the point before is its id."""
        if self.values.get("start_from") != PREVIOUS:
            return self
        start = previous if self.follows else ""
        return replace(self, values=self.values | {"start_from": start})

    def combinations(
        self, lists: dict[str, list[Any]], path: str
    ) -> Iterator[tuple[set[str], "_Draft"]]:
        """Yield a copy for each combination of values of lists at ``path``, in lexical order.

        Beside it stand the names whose value is not the first of its list.
        """
        for indices in product(*(range(len(values)) for values in lists.values())):
            choice = dict(zip(lists, indices, strict=True))
            values = {name: lists[name][index] for name, index in choice.items()}
            paths = {name: f"{path}.{name}[{index}]" for name, index in choice.items()}
            draft = self._replaced(values, paths)
            yield {name for name, index in choice.items() if index}, draft


@dataclass(frozen=True)
class _Family:
    """The points of a series, or the boundaries of an ``entry``, at ``key`` of a study file."""

    file: StudyFile
    entry: SeriesFile | BoundaryFile
    key: str
    source: str

    def add_to(self, points: dict[str, Point], boundaries: Iterable[Boundary]) -> tuple[str, ...]:
        """Add the points to others, or those of the first round of boundaries; return their ids."""
        ids = {}
        for parameters, figures in self._members(boundaries, points):
            profiles = isinstance(self.entry, BoundaryFile) or self.entry.profiles
            self._require_units(parameters)
            point = point_with_membership(points, parameters, self.entry.name, figures, profiles)
            self._require_same_point(point, parameters)
            ids[point.id] = points[point.id] = point
        return tuple(ids)

    @cached_property
    def design(self) -> DesignFile | None:
        """The design of a series, if it has one; its points are those under the first reading."""
        if not isinstance(self.entry, SeriesFile) or not self.entry.design:
            return None
        place = self.source, f"{self.key}.design"
        added = {"parameters_at": self._parameters_in_design, "place": place}
        return self.entry.design.model_copy(update=added)

    def boundaries(self) -> Iterator[Boundary]:
        """Yield the boundaries, after validating both ends of their ranges; none of a series."""
        if isinstance(self.entry, SeriesFile):
            return
        for draft in self._drafts():
            for index, value in enumerate(self.entry.range):
                self._parameters_along(draft, value, f"range[{index}]")
            model = SYSTEMS[self.entry.system]
            plain = plain_values(draft.values, model, self.source, draft.paths)
            names = (name for key in self.entry.grid_lists for name in given_by(model, key))
            grid = {name: plain[name] for name in names}
            named = self.entry.model_dump(include={"name", "of", "along", "tolerance"})
            named |= {"low": self.entry.range[0], "high": self.entry.range[1], "grid": grid}
            at, figures = partial(self._parameters_along, draft), tuple(self.entry.figures)
            yield Boundary(**named, figures=figures, parameters_at=at)

    def _members(
        self, boundaries: Iterable[Boundary], points: Collection[str]
    ) -> Iterator[tuple[Parameters, Iterable[str]]]:
        """Yield each point and its figures; under another reading those with a curve for that.

        Of the ids of ``points``, those of earlier entries and points, a start names any by its end.
        """
        for boundary in boundaries:
            for value in divide_range(boundary.low, boundary.high):
                yield boundary.parameters_at(value), boundary.figures
        previous = ""
        for draft in self._drafts() if isinstance(self.entry, SeriesFile) else ():
            others = draft.other_readings
            figures = [one for one in self.entry.figures if others <= set(FIGURES[one].groups)]
            parameters = self._parameters(draft.after(previous).with_whole_start(points))
            previous = point_id(parameters)
            yield parameters, figures

    def _drafts(self) -> Iterator[_Draft]:
        cases = self.entry.cases if isinstance(self.entry, SeriesFile) else None
        rows = self.design.rows(self.design.size) if self.design else []
        for base in self._bases():
            for row in rows:
                yield base.with_values(row, f"{self.key}.design.over")
            if self.entry.grid:
                lists = self.entry.grid_lists
                last = next((n for n in map(len, reversed(lists.values())) if n > 1), 1)
                drafts = base.combinations(lists, f"{self.key}.grid")
                for index, (_, draft) in enumerate(drafts):
                    yield replace(draft, follows=index % last > 0)
            for index, case in enumerate(cases or []):
                draft = base.with_values(case.explicit_values(), f"{self.key}.cases[{index}]")
                yield replace(draft, follows=index > 0)
            if not self.entry.grid and not cases and not rows:
                yield base

    def _bases(self) -> Iterator[_Draft]:
        """Yield the base of a series under each reading, or of boundaries under the first one."""
        system = self.entry.system
        draft = _Draft({"system": system}, {"system": f"{self.key}.system"})
        if self.file.is_natural:
            draft = draft.with_values(NATURAL, "units")
        if own := papers()[self.file.paper].values.get(system) if self.file.paper else None:
            draft = draft.with_values(own, f"paper.{self.file.paper}")
            draft = replace(draft, of_paper=frozenset(own))
        if shared := getattr(self.file.defaults, system):
            draft = draft.with_values(shared.explicit_values(), f"defaults.{system}")
        lists = self.file.reading_lists(system)
        for others, base in draft.combinations(lists, f"readings.{system}"):
            if others and not isinstance(self.entry, SeriesFile):
                return
            if self.entry.base:
                base = base.with_values(self.entry.base.explicit_values(), f"{self.key}.base")
            yield replace(base, other_readings=frozenset(others))

    def _parameters_in_design(self, row: Mapping[str, Any]) -> Parameters:
        base = next(self._bases())
        return self._parameters(base.with_values(dict(row), f"{self.key}.design.over"))

    def _parameters_along(self, draft: _Draft, value: float, key: str = "range") -> Parameters:
        assert isinstance(self.entry, BoundaryFile)
        along, flowing = self.entry.along, self.entry.range[1]
        values: dict[str, Any] = {along: value}
        paths = draft.paths | {along: f"{self.key}.{key}"}
        if self.entry.kind == "stop" and value != flowing:
            values["start_from"] = point_id(self._parameters_along(draft, flowing, "range[1]"))
        return self._parameters(replace(draft, values=draft.values | values, paths=paths))

    def _parameters(self, draft: _Draft) -> Parameters:
        """Return the parameters of a draft, with the overrides whose conditions it meets.

        They apply to the point before any override, defaults included. Later overrides win.
        """
        for name, value in draft.values.items() if self.file.is_natural else ():
            if number_and_unit(value):
                allowed = "a number without a unit, of which units: natural has none"
                raise InputError.of_value(self.source, draft.paths[name], value, allowed)
        before = draft.point(self.source)
        new = draft
        for index, override in enumerate(self.entry.overrides):
            conditions = override.when.explicit_values()
            conditions = plain_numbers(conditions, type(before), scales(vars(before)))
            if all(getattr(before, name) in values for name, values in conditions.items()):
                path = f"{self.key}.overrides[{index}].set"
                new = new.with_values(override.set.explicit_values(), path)
        return before if new is draft else new.point(self.source)

    def _require_units(self, parameters: Parameters) -> None:
        for name, value in NATURAL.items() if self.file.is_natural else ():
            if getattr(parameters, name) != value:
                got = f"natural with {name} = {getattr(parameters, name):g}"
                allowed = f"{name} of 1 in natural units, or units: si"
                raise InputError.of_value(self.source, "units", got, allowed)

    def _require_same_point(self, point: Point, parameters: Parameters) -> None:
        """Raise `InputError` if parameters of the same id differ in more than amounts."""
        names = roles.amount_parameters(type(parameters))
        same_amounts = {name: getattr(point.parameters, name) for name in names}
        if parameters.model_copy(update=same_amounts) != point.parameters:
            what = f"two different points have the id {point.id}; change either's seed"
            raise InputError(f"{self.source}: {what}")


def point_with_membership(
    points: dict[str, Point],
    parameters: Parameters,
    series: str,
    figures: Iterable[str],
    profiles: bool = True,
) -> Point:
    """Return the point of ``parameters``, old or new, as a member of a series and of figures.

    Its amounts are the larger of the old and the new ones. It joins the figures that show it; the
    others leave it out. The dataset has its profiles if any of its series says so.
    """
    key = point_id(parameters)
    point = points.get(key, Point(key, parameters, (), (), profiles=False))
    names = dict.fromkeys((*point.figures, *point.left_out, *figures))
    shows = {name: FIGURES[name].shows(parameters) for name in names}
    return replace(
        point,
        parameters=with_larger_amounts(point.parameters, amounts(parameters)),
        series=tuple(dict.fromkeys((*point.series, series))),
        figures=tuple(name for name in names if shows[name]),
        left_out=tuple(name for name in names if not shows[name]),
        profiles=point.profiles or profiles,
    )


def _readings_by_system(file: StudyFile) -> dict[str, list[dict[str, Any]]]:
    """Return the readings of all series by system, each as values that differ from the defaults."""
    readings = {}
    for system, model in SYSTEMS.items():
        if lists := file.reading_lists(system):
            one = papers()[file.paper] if file.paper else None
            usual = dict(model()) | (one.usual(system, {}) if one else {})
            every = [draft.values for _, draft in _Draft().combinations(lists, "")]
            readings[system] = [
                {name: value for name, value in one.items() if value != usual[name]}
                for one in every
            ]
    return readings


def _require_valid_points(points: dict[str, Point], source: str) -> None:
    """Refuse too many points, and a start that is neither a point of the study nor a run file."""
    if len(points) > MAX_POINTS:
        allowed = f"at most {MAX_POINTS:,} points in the study"
        raise InputError.of_value(source, "parts", f"{len(points):,} points", allowed)
    for point in points.values():
        start = point.parameters.start_from
        if start in points:
            require_compatible_source(point.parameters, points[start].parameters, source)
        # isfile: to it, a name that is too long is no file.
        elif start and not (start.endswith(RUN_FILE) and isfile(start)):  # noqa: PTH113
            allowed = "the id of a point of the study, or a run file (*.nc) that is there"
            raise InputError.of_value(source, "start_from", start, allowed)
