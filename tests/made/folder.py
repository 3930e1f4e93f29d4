"""A study without results, and ways to give it some."""

import os
import socket
from datetime import UTC, datetime, timedelta
from pathlib import Path

from sim.engine.progress import Progress, progress_file
from sim.report.status import StudyStatus, survey
from sim.study.load import load_study
from tests.made.runs import write_run

STUDY = """\
study: made
title: A made-up study
series:
  - {name: flows, system: chute, grid: {depth: [1, 2, 3]}}
  - {name: beds, system: belt, grid: {frequency: [20, 30]}}
"""
NOW = datetime.now(UTC)
EARLIER = NOW - timedelta(days=400)
LATER = NOW + timedelta(days=400)

#: A study with rounds of refinement.
BOUNDED = (
    "study: made\nboundaries: [{name: b, system: chute, of: flow, along: friction, "
    "range: [0.3, 0.8], tolerance: 0.05}]"
)


class Folder:
    """A study without results, and ways to give it some."""

    def __init__(self, root: Path, text: str = STUDY):
        self.file = root / "made.yaml"
        self.file.write_text(text)
        self.results = root / "results"
        self.runs = self.results / "made" / "runs"
        self.study = load_study(self.file, self.results)
        self.ids = list(self.study.points)

    def finish(self, key: str, **how) -> Path:
        return write_run(self.runs, self.study.points[key].parameters, **how)

    def write_progress(self, key: str, **changes) -> Path:
        """Write the progress file of a run of this process that is halfway."""
        values = {"point": key, "done": 500, "total": 1000, "at_most": False, "particles": 100}
        values |= {"rate": 5e3, "elapsed": 10.0, "updated": datetime.now(UTC)}
        values |= {"pid": os.getpid(), "host": socket.gethostname()}
        self.runs.mkdir(parents=True, exist_ok=True)
        path = progress_file(self.runs / f"{key}.nc")
        path.write_text(Progress(**values | changes).model_dump_json())
        return path

    def survey(self) -> StudyStatus:
        return survey(self.study, self.results)

    def state(self, key: str) -> str:
        return self.survey().points[key].state
