"""The points of a study as a table for further work."""

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from sim.base.errors import InputError
from sim.parameters import complete_values
from sim.study.cost import estimate
from sim.study.load import load_study, parse_study

if TYPE_CHECKING:
    import pandas as pd


def points(study: str | Path | Mapping[str, Any]) -> "pd.DataFrame":
    """Return the points of a study as a table: one row per point, in the order of the study.

    Parameters
    ----------
    study : str, Path or mapping
        The study file, or a mapping with the contents of one.

    Returns
    -------
    pandas.DataFrame
        The index holds the ids of the points. Columns are all parameters in the units of a study
        file, ``particles``, ``core_seconds`` (an estimate for all replicates), ``series`` and
        ``figures``. Parameters that the system of a point does not have are missing.

    Raises
    ------
    InputError
        For any mistake that prevents the study from being run as written.

    Examples
    --------
    >>> series = {"name": "depths", "system": "chute", "grid": {"depth": [1.24, 2.5]}}
    >>> list(points({"study": "mine", "series": [series]}).depth)
    [1.24, 2.5]
    """
    import pandas as pd

    if isinstance(study, Mapping):
        validated_study = parse_study(dict(study), "points", None)
    elif isinstance(study, (str, Path)):
        validated_study = load_study(study, None)
    else:
        raise InputError.of_value("points", "study", study, "the path of a study file or a mapping")
    rows = {
        point.id: complete_values(point.parameters)
        | {
            "particles": point.parameters.particles,
            "core_seconds": estimate(point.parameters).core_seconds,
            "series": point.series,
            "figures": point.figures,
        }
        for point in validated_study.points.values()
    }
    return pd.DataFrame.from_dict(rows, orient="index").rename_axis("point")
