"""Load a study: read, validate, expand, feed and ask its file; and its points as a table."""

import re
import warnings
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from sim.base.errors import InputError
from sim.base.files import require_writable
from sim.base.plugins import PATTERN as PLUGIN_NAME
from sim.base.plugins import load
from sim.base.yaml import read_yaml
from sim.parameters import complete_values
from sim.parameters.density import doubts_of
from sim.study.ask import ask
from sim.study.cost import estimate
from sim.study.expand import expand
from sim.study.extra_amounts import read_extra_amounts, with_extra_amounts
from sim.study.feed import feed
from sim.study.file import PART_NAME
from sim.study.model import Boundary, Point, Study
from sim.study.paper_values import paper_values
from sim.study.validate import validate

if TYPE_CHECKING:
    import pandas as pd

__all__ = ["Boundary", "Point", "Study", "load_study", "parse_study", "points"]

#: Study to use if none is named.
DEFAULT_STUDY = Path("config/quick.yaml")


def load_study(path: str | Path, results: str | Path | None = "results") -> Study:
    """Return the study that a study file describes.

    Parameters
    ----------
    path : str or Path
        The study file.
    results : str, Path or None
        Folder of the study's own folder of results, which must be writable. ``None`` if nothing
        will be written.

    Raises
    ------
    InputError
        For any mistake that prevents the study from being run as written.
    """
    return parse_study(read_yaml(path), path, results)


def parse_study(mapping: Any, path: str | Path, results: str | Path | None = "results") -> Study:
    """Return the study that ``mapping``, read from ``path``, describes.

    See `load_study`.
    """
    documents = [(Path(path), mapping), *_parts(mapping, Path(path))]
    loaded = [
        plugin
        for place, contents in documents
        for plugin in load(
            _names(contents, "plugins", PLUGIN_NAME), place.parent, f"{place}: plugins"
        )
    ]
    files = validate(documents)
    study = ask(feed(expand(files), files), files)
    if results is not None:
        folder = Path(results) / study.name
        require_writable(folder, f"{study.path}: study")
        if study.decide:
            extra, judged = read_extra_amounts(folder), study.decide.claims is not None
            study = replace(study, points=with_extra_amounts(study.points, extra, judged))
    return replace(study, plugins=tuple(dict.fromkeys(loaded)))


def _parts(contents: Any, path: Path) -> Iterator[tuple[Path, Any]]:
    """Yield path and contents of each part that a study file names."""
    for index, name in enumerate(_names(contents, "parts", PART_NAME)):
        try:
            yield path.parent / name, read_yaml(path.parent / name)
        except InputError as error:
            raise InputError(f"{path}: parts[{index}]: {error}") from None


def _names(contents: Any, key: str, pattern: str) -> list[str]:
    """Return the names under a key, none if one is malformed, which `validate` refuses then."""
    names = contents.get(key) if isinstance(contents, dict) else None
    if isinstance(names, list) and all(
        isinstance(name, str) and re.match(pattern, name) for name in names
    ):
        return names
    return []


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
        ``figures``. Parameters that the system of a point does not have are missing. The attribute
        ``paper_values`` lists what all points have as a paper has it. Sizes of particles that are
        probably not meant are a warning.

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
    for text in doubts_of(point.parameters for point in validated_study.points.values()):
        warnings.warn(text, stacklevel=2)
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
    table = pd.DataFrame.from_dict(rows, orient="index").rename_axis("point")
    members = [point.parameters for point in validated_study.points.values()]
    table.attrs["paper_values"] = paper_values(members)
    return table
