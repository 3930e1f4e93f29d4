"""What a workflow prints: a line per point or failed job, and in the end the status of all."""

import logging
import sys
from collections.abc import Container
from dataclasses import replace
from pathlib import Path

from sim.base.errors import InputError
from sim.report.failed_jobs import FailedJobs, is_news
from sim.report.status import survey
from sim.report.status_table import as_text
from sim.report.watch import Watch
from sim.study.model import Study


class Session:
    """Progress of a study while its workflow runs, on standard error.

    Parameters
    ----------
    study : Study
        The study.
    folder : Path
        Its results.
    sources : container of str
        Ids of points that come from adopted datasets, which need no run.
    log : Logger
        Log of Snakemake. Its uninformative messages are left out.
    """

    def __init__(self, study: Study, folder: Path, sources: Container[str], log: logging.Logger):
        self._study, self._results = study, folder.parent
        points = {key: point for key, point in study.points.items() if key not in sources}
        self._watch = Watch(replace(study, points=points), folder)
        self._watch.start()
        log.addFilter(is_news)
        log.addHandler(FailedJobs(self._watch.write))

    def end(self) -> None:
        """Print the final status of the points; an error here must not fail the workflow."""
        self._watch.end()
        try:
            print(f"\n{as_text(survey(self._study, self._results))}\n", file=sys.stderr)
        except (InputError, OSError) as error:
            print(f"no summary: {error}", file=sys.stderr)
