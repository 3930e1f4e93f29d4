"""Run files that points of a study start from: read before anything is run."""

from functools import cache
from pathlib import Path

from sim.base.errors import InputError
from sim.engine.stored_run import read_parameters
from sim.parameters import RUN_FILE, Parameters, require_alike
from sim.study.model import Study


def require_start_files(study: Study) -> None:
    """Refuse a run file that a point of a study cannot start from.

    Of points of the study that others start from, loading it has seen to that.

    Raises
    ------
    InputError
        When it is damaged, no run file, or its flow cannot turn into that of the point.
    """

    @cache
    def held(start: str) -> Parameters:
        try:
            return read_parameters(Path(start))
        except InputError as error:
            raise InputError(f"{study.path}: start_from: {error}") from None

    for point in study.points.values():
        if (start := point.parameters.start_from).endswith(RUN_FILE):
            require_alike(point.parameters, held(start), str(study.path))
