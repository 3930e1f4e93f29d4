"""The report of a study while it runs: on the points that have ended, and again as more do."""

import os
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

from sim.base.errors import InputError
from sim.base.files import atomic_write
from sim.dataset.build import build
from sim.dataset.results import load_results
from sim.figures.render import render as draw
from sim.report.page import data_uri, render
from sim.study.load import load_study


def write(study_path: Path, results: Path = Path("results")) -> Path:
    """Write ``results/<study>/report.html`` on the points that have ended, without answers.

    It is dated before all else, so that the workflow makes it again. Raises ``InputError`` when no
    point has ended.
    """
    study = load_study(study_path, results)
    folder = results / study.name
    with TemporaryDirectory(prefix=".preview-", dir=folder) as place:
        figures = Path(place) / "figures"
        dataset = build(study_path, results, finished=Path(place) / "dataset.nc")
        entries = {}
        for name, spec in study.entries.items():
            # A figure may have no point yet, or show an answer, which comes last.
            with suppress(InputError):
                draw(spec, dataset, figures)
                entries[name] = spec
        found = load_results(dataset)
        ended = {
            key: study.points[key] for key in found.dataset.point.values if key in study.points
        }
        part = replace(study, points=ended, entries=entries, boundaries=(), questions=())
        page = render(part, found, figures, [], data_uri, len(study.points) - len(ended))
    output = folder / "report.html"
    with atomic_write(output) as temporary:
        temporary.write_text(page, encoding="utf-8")
        os.utime(temporary, (1, 1))
    return output
