"""The last step from a study file to a study: its questions, and the pictures of their answers."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from sim.study.catalogue import FIGURES
from sim.study.file import StudyFile
from sim.study.model import Study
from sim.study.questions import Question, SurrogateQuestion
from sim.study.surrogate import CalibrationSpec
from sim.study.surrogate_questions import CalibrationQuestion, SensitivityQuestion

#: Keys of study files, with the attribute of a study that holds their questions. Those of
#: surrogates come first, as the others are asked of them.
_KEYS: dict[str, tuple[str, type[Question]]] = {
    "surrogate": ("surrogates", SurrogateQuestion),
    "sensitivity": ("sensitivities", SensitivityQuestion),
    "calibrate": ("calibrations", CalibrationQuestion),
}


def ask(study: Study, files: Sequence[tuple[Path, StudyFile]]) -> Study:
    """Return the study with the questions of its files, and pictures of the answers.

    Measurements are read here, before anything runs.

    Raises
    ------
    InputError
        For a name that is taken; a series, surrogate, observable or parameter that is not there or
        does not fit; and measurements that cannot be used, with file, line and column.
    """
    for key, (attribute, kind) in _KEYS.items():
        specs: dict[str, Any] = {}
        entries, data = dict(study.entries), list(study.data)
        for path, file in files:
            for index, entry in enumerate(getattr(file, key) or []):
                question = kind(study, file, entry, path, f"{key}[{index}]")
                if entry.name.lower() in map(str.lower, specs):
                    raise question.error("name", entry.name, f"a name that no other {key} has")
                spec = specs[entry.name] = question.spec()
                data += [spec.path] if isinstance(spec, CalibrationSpec) else []
                for picture in question.pictures(spec):
                    if picture.name.lower() in (*map(str.lower, entries), *map(str.lower, FIGURES)):
                        allowed = f"a name with which no other figure is called {picture.name}"
                        raise question.error("name", entry.name, allowed)
                    entries[picture.name] = picture
        answered: dict[str, Any] = {attribute: tuple(specs.values())}
        study = replace(study, entries=entries, data=tuple(dict.fromkeys(data)), **answered)
    return study
