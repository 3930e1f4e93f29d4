"""The questions of a study: its surrogates, and the pictures of their answers."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import combinations
from pathlib import Path
from typing import Any

from sim.base.errors import InputError
from sim.parameters import NUMERICAL
from sim.study.catalogue import FIGURES
from sim.study.design import Axis, Design
from sim.study.figure_spec import FigureSpec
from sim.study.file import StudyFile
from sim.study.model import Point, Study
from sim.study.plot_contents import name_in_words, parameter_phrase
from sim.study.plottable import Observable, find_observable
from sim.study.surrogate import FEWEST_POINTS, MOST_POINTS, SurrogateFile, SurrogateSpec

#: Kinds of design that can go on point by point.
_ENDLESS = ("sobol", "random")


def ask(study: Study, files: Sequence[tuple[Path, StudyFile]]) -> Study:
    """Return the study with the surrogates of its files and their pictures.

    Raises
    ------
    InputError
        For a series or an observable that is not there, a name that is taken, a series without
        parameters that vary, and rounds of a series that no design makes.
    """
    specs: dict[str, SurrogateSpec] = {}
    entries = dict(study.entries)
    for path, file in files:
        for index, entry in enumerate(file.surrogate or []):
            question = _Question(study, file, entry, str(path), f"surrogate[{index}]")
            if entry.name.lower() in map(str.lower, specs):
                raise question.error("name", entry.name, "a name that no other surrogate has")
            spec = specs[entry.name] = question.spec()
            for picture in _pictures(spec, question.observable):
                if picture.name.lower() in (*map(str.lower, entries), *map(str.lower, FIGURES)):
                    allowed = f"a name with which no other figure is called {picture.name}"
                    raise question.error("name", entry.name, allowed)
                entries[picture.name] = picture
    return replace(study, surrogates=tuple(specs.values()), entries=entries)


class _Question:
    """An entry under ``surrogate`` at a ``place`` of the file ``source``."""

    def __init__(
        self, study: Study, file: StudyFile, entry: SurrogateFile, source: str, place: str
    ):
        self.study, self.entry, self.source, self.place = study, entry, source, place
        named = {one.name: one for _, one in file.entries}
        if entry.series not in named:
            raise self.error("series", entry.series, "one of " + ", ".join(named))
        self.family = named[entry.series]
        self.points: list[Point] = [study.points[key] for key in study.series[entry.series]]
        self.system = self.family.system

    def error(self, key: str, value: Any, allowed: str) -> InputError:
        """Return the error of a key of the entry."""
        return InputError.of_value(self.source, f"{self.place}.{key}", value, allowed)

    @property
    def observable(self) -> Observable:
        """What the surrogate is of."""
        name = self.entry.observable
        found = find_observable("curves", "observable", name, self.system, self.error)
        asked = found.asked_by
        if asked and not all(getattr(point.parameters, asked, False) for point in self.points):
            raise self.error(
                "observable", name, f"points with {asked}: true, as runs record it only then"
            )
        return found

    def spec(self) -> SurrogateSpec:
        """Return the surrogate."""
        entry, count = self.entry, len(self.points)
        # Rounds may add what is missing.
        least = 1 if entry.error else FEWEST_POINTS
        if not least <= count <= MOST_POINTS:
            allowed = f"a series of {least} to {MOST_POINTS:,} points"
            raise self.error("series", f"{entry.series} of {count:,} points", allowed)
        self.observable  # noqa: B018  (refuses what is not kept)
        axes = self._axes()
        if not axes:
            allowed = "a series whose points vary a parameter"
            raise self.error("series", entry.series, allowed)
        return SurrogateSpec(
            name=entry.name,
            series=entry.series,
            observable=entry.observable,
            system=self.system,
            axes=axes,
            regimes=tuple(dict.fromkeys(entry.regimes)),
            error=entry.error or 0.0,
            budget=entry.budget or 0.0,
            batch=entry.batch,
            design=self._growing_design() if entry.error else None,
            figures=tuple(self.family.figures),
        )

    def _growing_design(self) -> Design:
        """Return the design of the series, whose further points rounds add."""
        design = self.study.designs.get(self.entry.series)
        # The points of an analysis belong together, so single ones do not go on with it.
        if design is None or design.kind not in _ENDLESS:
            allowed = "with error, a series with a design of kind sobol or random"
            raise self.error("series", self.entry.series, allowed)
        return design

    def _axes(self) -> tuple[Axis, ...]:
        """Return the parameters that vary; of a grid those that flows depend on."""
        axes, series = self.study.axes.get(self.entry.series, ()), self.entry.series
        if len(self.study.readings.get(self.system, ())) > 1:
            allowed = f"a series of a study with one reading of the {self.system}"
            raise self.error("series", series, allowed)
        is_designed = series in self.study.designs
        return tuple(axis for axis in axes if is_designed or axis.name not in NUMERICAL)


def _pictures(spec: SurrogateSpec, observable: Observable) -> Iterator[FigureSpec]:
    """Yield the pictures of a surrogate: sections, maps, and predicted against run."""
    what = name_in_words(spec.observable)
    numbers = [axis.name for axis in spec.axes if axis.is_number]
    for name in numbers:
        phrase = parameter_phrase(spec.system, name)
        title = f"{what.capitalize()} against {name_in_words(name)}, surrogate {spec.name}"
        lead = (
            f"{what.capitalize()} ({observable.meaning}) against {phrase}, as the surrogate "
            f"{spec.name} gives it with its 95 % band."
        )
        yield _picture(spec, "section", name, title, lead, x=name)
    for x, y in combinations(numbers, 2):
        over = f"{name_in_words(x)} and {name_in_words(y)}"
        lead = (
            f"{what.capitalize()} ({observable.meaning}) over {parameter_phrase(spec.system, x)} "
            f"and {parameter_phrase(spec.system, y)}, as the surrogate {spec.name} gives it."
        )
        title = f"{what.capitalize()} over {over}, surrogate {spec.name}"
        yield _picture(spec, "surface", f"{x}-{y}", title, lead, x=x, y=y)
    lead = (
        f"{what.capitalize()} ({observable.meaning}) of each run, against what the surrogate "
        f"{spec.name} predicts from all the others."
    )
    title = f"{what.capitalize()} predicted and run, surrogate {spec.name}"
    yield _picture(spec, "agreement", "agreement", title, lead)


def _picture(
    spec: SurrogateSpec, kind: str, ending: str, title: str, lead: str, **options: Any
) -> FigureSpec:
    return FigureSpec(
        name=f"{spec.name}-{ending}",
        kind=kind,
        paper="",
        system=spec.system,
        title=title,
        lead=lead,
        series=(spec.series,),
        options={"answer": spec.file, "settings": spec.settings, "regimes": spec.regimes} | options,
    )
