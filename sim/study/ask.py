"""The last step from a study file to a study: its questions, and the pictures of their answers."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import combinations
from pathlib import Path

from sim.base.errors import count_text
from sim.study.calibration import CalibrateFile
from sim.study.catalogue import FIGURES
from sim.study.figure_spec import Answer, FigureSpec
from sim.study.file import StudyFile
from sim.study.model import Study
from sim.study.plot_contents import name_in_words, parameter_phrase
from sim.study.plottable import numbers
from sim.study.sensitivity import SensitivityFile
from sim.study.surrogate import Place, Question, SurrogateFile

#: Keys of study files with questions. Surrogates come first, as the others are asked of them.
KEYS = ("surrogate", "sensitivity", "calibrate")

#: Title and lead of each kind of picture.
PICTURES = {
    "section": (
        "{What} against {x}",
        "{What} ({meaning}) against {x_phrase}, as the {source} gives it with its 95 % band.",
    ),
    "surface": (
        "{What} over {x} and {y}",
        "{What} ({meaning}) over {x_phrase} and {y_phrase}, as the {source} gives it.",
    ),
    "agreement": (
        "{What} predicted and run",
        "{What} ({meaning}) of each run, against what the {source} predicts from all the others.",
    ),
    "screening": (
        "Screening of what changes the {what}",
        "Elementary effects of each parameter on {what} ({meaning}), from the runs of the "
        "{source}.",
    ),
    "indices": (
        "What the {what} depends on",
        "Sobol' indices of {what} ({meaning}), from the {source}.",
    ),
    "interactions": (
        "What acts together on the {what}",
        "Second-order Sobol' indices of {what} ({meaning}), from the {source}.",
    ),
    "posterior": (
        "Which {names} the measurements allow",
        "Posterior of {names} from {count} of {what} ({meaning}), by the {source}.",
    ),
    "predictions": (
        "{What} measured and calibrated",
        "{What} ({meaning}): measurements, and what the calibrated {source} says of each.",
    ),
    "experiment": (
        "The next experiment",
        "Where a further measurement of {what} would narrow the posterior of {names}.",
    ),
}


def ask(study: Study, files: Sequence[tuple[Path, StudyFile]]) -> Study:
    """Return the study with the questions of its files, and pictures of the answers.

    Measurements are read here, before anything runs.

    Raises
    ------
    InputError
        See `sim.study.surrogate.Question.resolve`; for a name that is taken.
    """
    entries, names = dict(study.entries), {name.lower() for name in (*study.entries, *FIGURES)}
    for key in KEYS:
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
    """Yield the pictures of an answer."""
    of, design = question.of, getattr(question, "design", None)
    match question:
        case SurrogateFile():
            names = [axis.name for axis in of.axes if axis.is_number]
            yield from (_picture(question, "section", x) for x in names)
            yield from (_picture(question, "surface", *pair) for pair in combinations(names, 2))
            yield _picture(question, "agreement")
        case SensitivityFile() if question.is_screening:
            yield _picture(question, "screening", source=f"series {of.series}")
        case SensitivityFile():
            source = f"surrogate {of.name}" if design is None else f"series {of.series}"
            yield _picture(question, "indices", source=source)
            if design is None and len(of.axes) > 1:
                yield _picture(question, "interactions", source=source)
        case CalibrateFile():
            words = {
                "names": ", ".join(map(name_in_words, question.parameters)),
                "count": count_text(len(question.values), "measurement"),
            }
            yield _picture(question, "posterior", **words)
            yield _picture(question, "predictions", **words)
            if any(len(set(one)) > 1 for one in question.conditions.values()):
                yield _picture(question, "experiment", **words)


def _picture(question: Question, kind: str, x: str = "", y: str = "", **words: str) -> FigureSpec:
    """Return a picture of an answer, against parameters x and y where it has these."""
    of = question.of
    observable = numbers(of.system)[of.observable]
    what = name_in_words(observable.name)
    words = {"source": f"surrogate {of.name}", "meaning": observable.meaning, **words}
    words |= {"what": what, "What": what.capitalize()}
    for key, name in (("x", x), ("y", y)):
        if name:
            words[key] = name_in_words(name)
            words[f"{key}_phrase"] = parameter_phrase(of.system, name)
    title, lead = (text.format_map(words) for text in PICTURES[kind])
    noun = "surrogate " if isinstance(question, SurrogateFile) else ""
    return FigureSpec.model_construct(
        name="-".join((question.name, *filter(None, (x, y)))) if x else f"{question.name}-{kind}",
        kind=kind,
        system=of.system,
        title=f"{title}, {noun}{question.name}",
        lead=lead,
        series=[of.series],
        answer=Answer(
            question.file, of.observable, observable.unit, of.mean_regimes, question.settings, x, y
        ),
    )
