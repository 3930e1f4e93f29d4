"""Check the run files that points of a study start from, before anything is run."""

from functools import cache
from pathlib import Path

from sim.base.errors import InputError
from sim.engine.stored_run import read_parameters
from sim.parameters import RUN_FILE, Parameters, require_compatible_source
from sim.study.model import Study


def require_start_files(study: Study) -> None:
    """Refuse a run file that a point of a study cannot start from.

    Points that start from other points of the study were checked when the study was loaded.

    Raises
    ------
    InputError
        When it is damaged or no run file, or a flow of the point cannot go on from its flow.
    """

    @cache
    def read_start(start: str) -> Parameters:
        try:
            return read_parameters(Path(start))
        except InputError as error:
            raise InputError(f"{study.path}: start_from: {error}") from None

    for point in study.points.values():
        if (start := point.parameters.start_from).endswith(RUN_FILE):
            require_compatible_source(point.parameters, read_start(start), str(study.path))
