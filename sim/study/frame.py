"""The points of a study as a table for further work."""

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from sim.base.errors import InputError
from sim.parameters import complete
from sim.study.cost import estimate
from sim.study.load import load_study, parse_study

if TYPE_CHECKING:
    import pandas as pd


def points(study: str | Path | Mapping[str, Any]) -> "pd.DataFrame":
    """Return the points of a study, a row each with its id, in the order of the study.

    Parameters
    ----------
    study : str, Path or mapping
        The study file, or what such a file would contain.

    Returns
    -------
    pandas.DataFrame
        Columns are all parameters in the units of a study file, ``particles``, ``core_seconds`` as
        estimated for all replicates, ``series`` and ``figures``. What is a parameter of the other
        system alone is missing.

    Raises
    ------
    InputError
        For anything that would keep the study from being run as written.

    Examples
    --------
    >>> series = {"name": "depths", "system": "chute", "grid": {"depth": [1.24, 2.5]}}
    >>> list(points({"study": "mine", "series": [series]}).depth)
    [1.24, 2.5]
    """
    import pandas as pd

    if isinstance(study, Mapping):
        read = parse_study(dict(study), "points", None)
    elif isinstance(study, (str, Path)):
        read = load_study(study, None)
    else:
        raise InputError.of_value("points", "study", study, "the path of a study file or a mapping")
    rows = {
        point.id: complete(point.parameters)
        | {
            "particles": point.parameters.particles,
            "core_seconds": estimate(point.parameters).core_seconds,
            "series": point.series,
            "figures": point.figures,
        }
        for point in read.points.values()
    }
    return pd.DataFrame.from_dict(rows, orient="index").rename_axis("point")
