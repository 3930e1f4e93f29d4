"""Questions of a study, those for surrogates in full, and the pictures of the answers."""

from collections.abc import Iterator
from functools import cached_property, partial
from itertools import combinations
from pathlib import Path
from typing import Any

from sim.base.errors import Allowed, InputError
from sim.parameters import NUMERICAL
from sim.parameters.forms import require_observables
from sim.study.design import Axis, Design
from sim.study.file import BoundaryFile, SeriesFile, StudyFile
from sim.study.model import Point, Study
from sim.study.plot_contents import name_in_words, parameter_phrase
from sim.study.plot_kinds import Answer, FigureSpec
from sim.study.plottable import Observable, find_observable, numbers, require_stored
from sim.study.surrogate import MOST_POINTS, SurrogateFile, SurrogateSpec, fewest_points

#: Kinds of design that can go on point by point.
_ENDLESS = ("sobol", "random")


class Question:
    """An entry at a ``place`` of a study file, to be asked of a study."""

    entry: Any

    #: What comes before the name of the answer in titles.
    noun = ""

    def __init__(self, study: Study, file: StudyFile, entry: Any, path: Path, place: str):
        self.study, self.file, self.entry, self.path, self.place = study, file, entry, path, place

    def error(self, key: str, value: Any, allowed: str | Allowed) -> InputError:
        """Return the error of a key of the entry."""
        return InputError.of_value(self.path, f"{self.place}.{key}", value, allowed)

    def spec(self) -> Any:
        """Return what the study knows of the question."""
        raise NotImplementedError

    def pictures(self, spec: Any) -> Iterator[FigureSpec]:
        """Yield the pictures of the answer."""
        raise NotImplementedError

    def picture(
        self,
        spec: Any,
        of: SurrogateSpec,
        kind: str,
        title: str,
        lead: str,
        ending: str = "",
        x: str = "",
        y: str = "",
    ) -> FigureSpec:
        """Return a picture of the answer; ``of`` is the surrogate, or what one would be of."""
        return FigureSpec(
            name=f"{spec.name}-{ending or kind}",
            kind=kind,
            paper="",
            system=of.system,
            title=f"{title}, {self.noun}{spec.name}",
            lead=lead,
            series=(of.series,),
            answer=Answer(
                spec.file,
                of.observable,
                numbers(of.system)[of.observable].unit,
                of.regimes,
                spec.settings,
                x,
                y,
            ),
        )


class SurrogateQuestion(Question):
    """An entry under ``surrogate``."""

    entry: SurrogateFile
    noun = "surrogate "

    @cached_property
    def family(self) -> SeriesFile | BoundaryFile:
        """The series that the surrogate goes through."""
        named = {one.name: one for _, one in self.file.entries}
        if self.entry.series not in named:
            raise self.error("series", self.entry.series, "one of " + ", ".join(named))
        return named[self.entry.series]

    @property
    def points(self) -> list[Point]:
        """The points of the series."""
        return [self.study.points[key] for key in self.study.series[self.family.name]]

    @property
    def system(self) -> str:
        """System of the series."""
        return self.family.system

    @property
    def observable(self) -> Observable:
        """What the surrogate is of."""
        name = self.entry.observable
        observable = find_observable("curves", "observable", name, self.system, self.error)
        require_stored(observable, self.points, partial(self.error, "observable", name))
        return observable

    def spec(self) -> SurrogateSpec:
        """Return the surrogate."""
        entry, count = self.entry, len(self.points)
        # Rounds may add what is missing.
        axes = self._axes()
        least = 1 if entry.error else fewest_points(len(axes))
        if not least <= count <= MOST_POINTS:
            allowed = f"a series of {least} to {MOST_POINTS:,} points"
            raise self.error("series", f"{entry.series} of {count:,} points", allowed)
        self.observable  # noqa: B018  (refuses what is not kept)
        require_observables(self.system, numbers(self.system))
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

    def pictures(self, spec: SurrogateSpec) -> Iterator[FigureSpec]:
        """Yield sections, maps, and predicted against run."""
        what, meaning = name_in_words(spec.observable), self.observable.meaning
        numeric = [axis.name for axis in spec.axes if axis.is_number]
        source = f"the surrogate {spec.name}"
        for name in numeric:
            title = f"{what.capitalize()} against {name_in_words(name)}"
            lead = (
                f"{what.capitalize()} ({meaning}) against {parameter_phrase(spec.system, name)}, "
                f"as {source} gives it with its 95 % band."
            )
            yield self.picture(spec, spec, "section", title, lead, name, x=name)
        for x, y in combinations(numeric, 2):
            title = f"{what.capitalize()} over {name_in_words(x)} and {name_in_words(y)}"
            lead = (
                f"{what.capitalize()} ({meaning}) over {parameter_phrase(spec.system, x)} and "
                f"{parameter_phrase(spec.system, y)}, as {source} gives it."
            )
            yield self.picture(spec, spec, "surface", title, lead, f"{x}-{y}", x=x, y=y)
        lead = (
            f"{what.capitalize()} ({meaning}) of each run, against what {source} predicts from all "
            "the others."
        )
        title = f"{what.capitalize()} predicted and run"
        yield self.picture(spec, spec, "agreement", title, lead)
