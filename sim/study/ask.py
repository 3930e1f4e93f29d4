"""The last step from a study file to a study: its questions, and the pictures of their answers."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import combinations
from pathlib import Path
from typing import Any

from sim.base.errors import count_text
from sim.study.calibration import CalibrateFile
from sim.study.catalogue import FIGURES
from sim.study.figure_spec import Answer, FigureSpec
from sim.study.file import StudyFile
from sim.study.model import Study
from sim.study.plot_contents import name_in_words, parameter_phrase
from sim.study.plottable import numbers
from sim.study.sensitivity import SensitivityFile
from sim.study.surrogate import Place, SurrogateFile

#: Keys of study files, with the attribute of a study that holds their questions. Those of
#: surrogates come first, as the others are asked of them.
_KEYS = {"surrogate": "surrogates", "sensitivity": "sensitivities", "calibrate": "calibrations"}


def ask(study: Study, files: Sequence[tuple[Path, StudyFile]]) -> Study:
    """Return the study with the questions of its files, and pictures of the answers.

    Measurements are read here, before anything runs.

    Raises
    ------
    InputError
        See `sim.study.surrogate.Question.resolve`; for a name that is taken.
    """
    for key, attribute in _KEYS.items():
        asked: dict[str, Any] = {}
        entries, data = dict(study.entries), list(study.data)
        for path, file in files:
            families = {one.name: one for _, one in file.entries}
            for index, entry in enumerate(getattr(file, key) or []):
                place = Place(path, f"{key}[{index}]", families)
                if entry.name.lower() in map(str.lower, asked):
                    raise place.error("name", entry.name, f"a name that no other {key} has")
                question = asked[entry.name] = entry.resolve(study, place)
                data += [question.path] if isinstance(question, CalibrateFile) else []
                for picture in _pictures(question):
                    if picture.name.lower() in (*map(str.lower, entries), *map(str.lower, FIGURES)):
                        allowed = f"a name with which no other figure is called {picture.name}"
                        raise place.error("name", entry.name, allowed)
                    entries[picture.name] = picture
        answered: dict[str, Any] = {attribute: tuple(asked.values())}
        study = replace(study, entries=entries, data=tuple(dict.fromkeys(data)), **answered)
    return study


def _pictures(question: SurrogateFile | SensitivityFile | CalibrateFile) -> Iterator[FigureSpec]:
    observable = numbers(question.of.system)[question.of.observable]
    what = name_in_words(observable.name), observable.meaning
    match question:
        case SurrogateFile():
            return _of_surrogate(question, *what)
        case SensitivityFile():
            return _of_sensitivity(question, *what)
        case CalibrateFile():
            return _of_calibration(question, *what)


def _picture(
    question: SurrogateFile | SensitivityFile | CalibrateFile,
    kind: str,
    title: str,
    lead: str,
    ending: str = "",
    x: str = "",
    y: str = "",
) -> FigureSpec:
    of: Any = question.of
    noun = "surrogate " if isinstance(question, SurrogateFile) else ""
    return FigureSpec.model_construct(
        name=f"{question.name}-{ending or kind}",
        kind=kind,
        system=of.system,
        title=f"{title}, {noun}{question.name}",
        lead=lead,
        series=[of.series],
        answer=Answer(
            question.file,
            of.observable,
            numbers(of.system)[of.observable].unit,
            of.mean_regimes,
            question.settings,
            x,
            y,
        ),
    )


def _of_surrogate(question: SurrogateFile, what: str, meaning: str) -> Iterator[FigureSpec]:
    """Yield sections, maps, and predicted against run."""
    numeric = [axis.name for axis in question.axes if axis.is_number]
    phrases = {name: parameter_phrase(question.system, name) for name in numeric}
    subject, source = f"{what.capitalize()} ({meaning})", f"the surrogate {question.name}"
    for name in numeric:
        title = f"{what.capitalize()} against {name_in_words(name)}"
        lead = f"{subject} against {phrases[name]}, as {source} gives it with its 95 % band."
        yield _picture(question, "section", title, lead, name, x=name)
    for x, y in combinations(numeric, 2):
        title = f"{what.capitalize()} over {name_in_words(x)} and {name_in_words(y)}"
        lead = f"{subject} over {phrases[x]} and {phrases[y]}, as {source} gives it."
        yield _picture(question, "surface", title, lead, f"{x}-{y}", x=x, y=y)
    lead = f"{subject} of each run, against what {source} predicts from all the others."
    yield _picture(question, "agreement", f"{what.capitalize()} predicted and run", lead)


def _of_sensitivity(question: SensitivityFile, what: str, meaning: str) -> Iterator[FigureSpec]:
    of, design = question.of, question.design
    source = f"surrogate {of.name}" if design is None else f"series {of.series}"
    if question.is_screening:
        lead = f"Elementary effects of each parameter on {what} ({meaning}), from the runs of the "
        title = f"Screening of what changes the {what}"
        yield _picture(question, "screening", title, f"{lead}{source}.")
        return
    lead = f"Sobol' indices of {what} ({meaning}), from the {source}."
    yield _picture(question, "indices", f"What the {what} depends on", lead)
    if design is None and len(of.axes) > 1:
        title = f"What acts together on the {what}"
        yield _picture(question, "interactions", title, f"Second-order {lead}")


def _of_calibration(question: CalibrateFile, what: str, meaning: str) -> Iterator[FigureSpec]:
    source = f"surrogate {question.of.name}"
    names = ", ".join(name_in_words(name) for name in question.parameters)
    count = count_text(len(question.values), "measurement")
    lead = f"Posterior of {names} from {count} of {what} ({meaning}), by the {source}."
    yield _picture(question, "posterior", f"Which {names} the measurements allow", lead)
    lead = (
        f"{what.capitalize()} ({meaning}): measurements, and what the calibrated {source} says of "
        "each."
    )
    yield _picture(question, "predictions", f"{what.capitalize()} measured and calibrated", lead)
    if any(len(set(one)) > 1 for one in question.conditions.values()):
        lead = f"Where a further measurement of {what} would narrow the posterior of {names}."
        yield _picture(question, "experiment", "The next experiment", lead)
