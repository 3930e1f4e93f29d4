"""Last steps of a study: its points feed figures and plots, and its questions are asked."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from itertools import combinations
from pathlib import Path
from typing import Any, TypeVar

from sim.base.additions import additions
from sim.base.errors import InputError, count_text, upper_first
from sim.base.messages import one_of
from sim.parameters import NUMERICAL, SYSTEMS, Parameters, canonical_number, field_info, roles
from sim.parameters.given import state_of
from sim.study.figure_spec import FIGURES, Answer, FigureSpec, written
from sim.study.file import QUESTIONS, StudyFile
from sim.study.model import Point, Study
from sim.study.plot_contents import (
    PlotContents,
    caption_lead,
    default_title,
    name_in_words,
    parameter_phrase,
    varying_parameters,
)
from sim.study.plot_file import FIT, PlotFile
from sim.study.plottable import PLOT, numbers
from sim.study.questions import CalibrateFile, PropagationFile, SensitivityFile
from sim.study.surrogate import Place, Question, SurrogateFile

_Plot = TypeVar("_Plot", bound=PlotFile)


def feed(study: Study, files: Sequence[tuple[Path, StudyFile]]) -> Study:
    """Return the study with the figures that its points feed, and with the plots of its files.

    Raises ``InputError`` for a figure that is listed but not fed, or fed but not listed, and for
    one that shows none of its points, whose points do not vary its axes or share one position on a
    curve; for plots with clashing names, unknown series, parameters or observables, and parameters
    that do not vary.
    """
    given = (state_of(point.parameters) for point in study.points.values())
    entries, data = _figures(study, files), [one.file for one in given if one and one.file]
    for number, (path, file) in enumerate(files):
        # A part knows its own series alone.
        series = [entry.name for _, entry in file.entries] if number else list(study.series)
        for index, plot in enumerate(file.plots or []):
            plot = _in_units(plot, study)
            names = plot.series or series
            points = [point for point in study.points.values() if set(point.series) & set(names)]
            contents = PlotContents(plot, points, str(path), f"plots[{index}]")
            _require_names(contents, series, entries)
            entries[plot.name] = plot_entry(contents, names)
            data += [path.parent / one.file for one in plot.beside or () if one.file]
    return replace(study, entries=entries, data=tuple(dict.fromkeys(data)))


def _in_units(plot: _Plot, study: Study) -> _Plot:
    """Return a plot in the units of the study, if it names none."""
    is_given = study.units == "si" or "units" in plot.model_fields_set
    return plot if is_given else plot.model_copy(update={"units": study.units})


def _figures(study: Study, files: Sequence[tuple[Path, StudyFile]]) -> dict[str, FigureSpec]:
    feeds: dict[str, tuple[str, str]] = {}
    for path, file in files:
        for key, entry in file.entries:
            for index, name in enumerate(entry.figures):
                feeds.setdefault(name, (str(path), f"{key}.figures[{index}]"))
    path, file = files[0]
    for index, name in enumerate(file.figures or []):
        if name not in feeds:
            allowed = "a figure that a series of the study feeds"
            raise InputError.of_value(path, f"figures[{index}]", name, allowed)
    figures = {name: _in_units(spec, study) for name, spec in FIGURES.items() if name in feeds}
    for name, spec in figures.items():
        if file.figures is not None and name not in file.figures:
            allowed = "a figure that the study lists under figures"
            raise InputError.of_value(*feeds[name], name, allowed)
        points = [point for point in study.points.values() if name in point.figures]
        _require_points_vary(spec, points, *feeds[name])
        _require_own_places(spec, points, *feeds[name])
        if spec.beside:
            contents = PlotContents(spec, points, str(FIGURES.sources[name]), f"figures.{name}")
            figures[name] = spec.model_copy(update={"foreign": contents.beside})
    return figures


def _require_names(contents: PlotContents, series: Sequence[str], entries: Iterable[str]) -> None:
    name = contents.plot.name
    # Some file systems do not tell capitals from small letters.
    if name.lower() in FIGURES:
        raise contents.error("name", name, "a name that no figure of the catalogue has")
    if name.lower() in map(str.lower, entries):
        raise contents.error("name", name, "a name that no other plot has, capitals or not")
    for number, one in enumerate(contents.plot.series or []):
        if one not in series:
            raise contents.error(f"series[{number}]", one, one_of(one, series))


def plot_entry(contents: PlotContents, series: Sequence[str]) -> FigureSpec:
    """Return the figure entry of a plot of some series; raise ``InputError`` as `feed` does."""
    contents.require_drawable()
    follows = {
        "title": contents.plot.title or default_title(contents),
        "lead": caption_lead(contents),
        "named": _caption_parameters(contents.system, contents.parameters),
        "series": list(series),
        "log": contents.log,
        "foreign": contents.beside,
        "scattered": contents.suits_scatter,
        "plugin": plugin_code(contents.plot.kind, contents.plot.fit),
    }
    spec = contents.spec.model_copy(update=follows)
    _require_own_places(spec, contents.points, contents.source, contents.place)
    return spec


def plugin_code(kind: str, fit: str | None) -> str:
    """Return the hashes of the plug-ins of a kind and of a law that is fitted; empty for Talus."""
    own = additions(PLOT).get(kind), additions(FIT).get(fit or "")
    return " ".join(one.plugin.code for one in own if one)


def _require_points_vary(spec: FigureSpec, points: Sequence[Point], source: str, path: str) -> None:
    if not points:
        conditions = ", ".join(f"{key} {values}" for key, values in spec.taken.items())
        raise InputError.of_value(source, path, spec.name, f"series with a point at {conditions}")
    for axis in spec.axes:
        values = {getattr(point.parameters, axis) for point in points}
        if len(values) < 2:
            got = f"{spec.name} with {axis} = {written(values.pop())} alone"
            allowed = f"series that feed {spec.name} and together vary {', '.join(spec.axes)}"
            if axis in spec.taken:
                allowed += f", of which it takes {axis} {spec.taken[axis]} alone"
            raise InputError.of_value(source, path, got, allowed)


def _require_own_places(spec: FigureSpec, points: Sequence[Point], source: str, path: str) -> None:
    if spec.keys.is_map or not spec.axes:
        return
    points_by_place: dict[tuple[Any, ...], Point] = {}
    for point in points:
        other = points_by_place.setdefault(spec.place(point.parameters), point)
        if other is point:
            continue
        at, before = dict(point.parameters), dict(other.parameters)
        names = dict.fromkeys((*spec.axes, *spec.groups))
        settings = ", ".join(f"{name} = {written(at[name])}" for name in names)
        differ = [name for name in at if before[name] != at[name]]
        texts = (f"{name} ({written(before[name])}, {written(at[name])})" for name in differ)
        first, second = other.series[0], point.series[0]
        note = f" (series {first} and {second})" if first != second else ""
        raise InputError(
            f"{source}: {path}: got {spec.name} with two points at {settings} that differ in "
            f"{', '.join(texts)}{note}, which it does not show; allowed: one point at each place "
            "of a curve, the other in a series that does not feed it"
        )


#: Parameters that captions give elsewhere or not at all.
_NOT_IN_CAPTION = {"system", "protocol", "start_from"}


def _caption_parameters(system: str, points: Sequence[Parameters]) -> list[str]:
    """Return the parameters in a caption: part of ids, varied, or different from the default."""
    model = SYSTEMS[system]
    rows, always = field_info(model), {*roles.id_parts(model), "transient", "average"}
    usual = {name: canonical_number(row.default) for name, row in rows.items()}
    unusual = {
        name
        for name in usual.keys() - NUMERICAL
        if usual[name] is not None and any(getattr(one, name) != usual[name] for one in points)
    }
    chosen = always | unusual | set(varying_parameters(points))
    return [name for name in rows if name in chosen - _NOT_IN_CAPTION]


#: Titles of pictures of answers, and the first sentences of their captions.
TITLES = {
    "section": "{what} against {x}",
    "surface": "{what} over {x} and {y}",
    "agreement": "{what} predicted and run",
    "screening": "Screening of what changes the {what}",
    "indices": "What the {what} depends on",
    "interactions": "What acts together on the {what}",
    "spread": "How the {what} is spread",
    "posterior": "Which {names} the measurements allow",
    "predictions": "{what} measured and calibrated",
    "experiment": "The next experiment",
}
LEADS = {
    "section": "{about} against {x_phrase}, as the {source} gives it with its 95 % band.",
    "surface": "{about} over {x_phrase} and {y_phrase}, as the {source} gives it.",
    "agreement": "{about} of each run, against what the {source} predicts from all the others.",
    "screening": "Elementary effects of each parameter on {about}, from the runs of the {source}.",
    "indices": "Sobol' indices of {about}, from the {source}.",
    "interactions": "Second-order Sobol' indices of {about}, from the {source}.",
    "spread": "Distribution of {about}, from the {source}.",
    "posterior": "Posterior of {names} from {count} of {about}, by the {source}.",
    "predictions": "{about}: measurements, and what the calibrated {source} says of each.",
    "experiment": "Where a further measurement of {what} would narrow the posterior of {names}.",
}


def ask(study: Study, files: Sequence[tuple[Path, StudyFile]]) -> Study:
    """Return the study with the questions of its files, and pictures of the answers.

    Measurements are read here, before anything runs. Raises ``InputError`` as
    `sim.study.surrogate.Question.resolve` does, and for a name that is taken.
    """
    entries, names = dict(study.entries), {name.lower() for name in (*study.entries, *FIGURES)}
    for key in QUESTIONS:
        own_names = set[str]()
        for path, file in files:
            families = {one.name: one for _, one in file.entries}
            for index, entry in enumerate(getattr(file, key) or []):
                place = Place(path, f"{key}[{index}]", families)
                if entry.name.lower() in own_names:
                    raise place.error("name", entry.name, f"a name that no other {key} has")
                own_names.add(entry.name.lower())
                question = entry.resolve(study, place)
                study = replace(study, questions=(*study.questions, question))
                for picture in _pictures(question):
                    if picture.name.lower() in names:
                        allowed = f"a name with which no other figure is called {picture.name}"
                        raise place.error("name", entry.name, allowed)
                    names.add(picture.name.lower())
                    entries[picture.name] = picture
    measured = [one.path for one in study.questions if isinstance(one, CalibrateFile)]
    data = tuple(dict.fromkeys((*study.data, *measured)))
    return replace(study, entries=entries, data=data)


def _pictures(question: Question) -> Iterator[FigureSpec]:
    of, design = question.of, getattr(question, "design", None)
    source = f"surrogate {of.name}" if design is None else f"series {of.series}"
    match question:
        case SurrogateFile():
            names = [axis.name for axis in of.axes if axis.is_number]
            yield from (_picture(question, "section", x) for x in names)
            yield from (_picture(question, "surface", *pair) for pair in combinations(names, 2))
            yield _picture(question, "agreement")
        case SensitivityFile() if question.is_screening:
            yield _picture(question, "screening", source=source)
        case PropagationFile():
            yield _picture(question, "spread", source=source)
        case SensitivityFile():
            yield _picture(question, "indices", source=source)
            if design is None and len(of.axes) > 1:
                yield _picture(question, "interactions", source=source)
        case CalibrateFile():
            sought = ", ".join(map(name_in_words, question.parameters))
            words = {"names": sought, "count": count_text(len(question.values), "measurement")}
            yield _picture(question, "posterior", **words)
            yield _picture(question, "predictions", **words)
            if any(len(set(one)) > 1 for one in question.conditions.values()):
                yield _picture(question, "experiment", **words)


def _picture(question: Question, kind: str, x: str = "", y: str = "", **words: str) -> FigureSpec:
    """Return a picture of an answer, against parameters x and y where it has these."""
    of = question.of
    observable = numbers(of.system)[of.observable]
    what, meaning = name_in_words(observable.name), observable.meaning
    words = {"source": f"surrogate {of.name}", **words}
    words |= {"what": what, "about": f"{what} ({meaning})"}
    for key, name in (("x", x), ("y", y)):
        if name:
            words |= {key: name_in_words(name), f"{key}_phrase": parameter_phrase(of.system, name)}
    noun = "surrogate " if isinstance(question, SurrogateFile) else ""
    about = of.observable, observable.unit, of.mean_regimes, question.settings
    return FigureSpec.model_construct(
        name="-".join((question.name, *filter(None, (x, y)))) if x else f"{question.name}-{kind}",
        kind=kind,
        system=of.system,
        title=f"{upper_first(TITLES[kind].format_map(words))}, {noun}{question.name}",
        lead=upper_first(LEADS[kind].format_map(words)),
        series=[of.series],
        answer=Answer(question.file, *about, x, y),
    )
