"""From a study file and its parts to points, boundaries and figures."""

import re
from dataclasses import replace
from pathlib import Path
from typing import Any

from sim.base.additions import Plugin
from sim.base.errors import InputError
from sim.base.files import require_writable
from sim.base.plugins import PATTERN, load
from sim.base.yaml import read_yaml
from sim.parameters import RUN_FILE, require_alike
from sim.study.catalogue import FigureSpec
from sim.study.cost import Estimate, estimate
from sim.study.extra_amounts import read_extra_amounts, with_extra_amounts
from sim.study.figure_points import points_of_figures
from sim.study.model import Boundary, Point, Study
from sim.study.plots import plots_of, points_shown
from sim.study.points import MAX_POINTS, as_member, collected, require_same
from sim.study.series import every_reading

__all__ = [
    "Boundary",
    "Estimate",
    "Point",
    "Study",
    "as_member",
    "estimate",
    "load_study",
    "parse_study",
]

#: The study that is meant when none is named.
DEFAULT_STUDY = Path("config/quick.yaml")

#: Most points of which each has a page.
MAX_PAGES = 1000


def load_study(
    path: str | Path, results: str | Path | None = "results", plugins: bool = True
) -> Study:
    """Read a study file and work out its points.

    Parameters
    ----------
    path : str or Path
        The study file.
    results : str, Path or None
        Folder that the study's own folder of results is, or will be, in; it must be writable.
        Nothing, where nothing will be written.
    plugins : bool
        Load the plug-ins that it names, which runs their code: not where it is results that name
        the study.

    Raises
    ------
    InputError
        For anything that would keep the study from being run as written.
    """
    return parse_study(read_yaml(path), path, results, plugins)


def parse_study(
    mapping: Any, path: str | Path, results: str | Path | None = "results", plugins: bool = True
) -> Study:
    """Work out the points of the study that ``mapping``, read from ``path``, describes.

    See `load_study`.
    """
    source, folder = str(path), Path(path).parent
    used = _load_plugins(mapping, Path(path)) if plugins else ()
    file, study, fed = collected(mapping, Path(path))
    plots: dict[str, FigureSpec] = {}
    for index, name in enumerate(file.parts or []):
        own = _part(folder / name, source, index)
        used += _load_plugins(own, folder / name) if plugins else ()
        part_file, part, also = collected(own, folder / name)
        study = _with_part(study, part, f"{source}: parts[{index}]")
        plots |= plots_of(part_file, part, str(folder / name), plots)
        fed = also | fed
    if len(study.points) > MAX_POINTS:
        allowed = f"at most {MAX_POINTS:,} points in the study"
        raise InputError.of_value(source, "parts", f"{len(study.points):,} points", allowed)
    if file.pages and len(study.points) > MAX_PAGES:
        allowed = f"false, for more than {MAX_PAGES:,} points"
        raise InputError.of_value(source, "pages", True, allowed)
    _require_starts(study, source)
    figures = points_of_figures(file, study.points.values(), fed, source)
    plots = plots_of(file, study, source, plots) | plots
    figures |= {name: points_shown(spec, study.points.values()) for name, spec in plots.items()}
    if results is not None:
        require_writable(Path(results) / file.study, f"{source}: study")
    points = study.points
    if file.decide and results is not None:
        points = with_extra_amounts(points, read_extra_amounts(Path(results) / file.study))
    return replace(
        study,
        points=points,
        figures=figures,
        plots=plots,
        readings=every_reading(file),
        decide=file.decide,
        pages=file.pages,
        plugins=tuple(dict.fromkeys(used)),
    )


def _load_plugins(mapping: Any, path: Path) -> tuple[Plugin, ...]:
    """Load and return the plug-ins that a study file names, if that key is what it should be.

    What is not is refused with the rest of the file, for which plug-ins must be known.
    """
    names = mapping.get("plugins") if isinstance(mapping, dict) else None
    if isinstance(names, list) and all(
        isinstance(name, str) and re.match(PATTERN, name) for name in names
    ):
        return load(names, path.parent, f"{path}: plugins")
    return ()


def _require_starts(study: Study, source: str) -> None:
    """Refuse a point that starts from what is none of the study's points, nor a run file."""
    for point in study.points.values():
        start = point.parameters.start_from
        if start in study.points:
            require_alike(point.parameters, study.points[start].parameters, source)
        elif start and not (start.endswith(RUN_FILE) and _is_there(Path(start))):
            allowed = "the id of a point of the study, or a run file (*.nc) that is there"
            raise InputError.of_value(source, "start_from", start, allowed)


def _is_there(path: Path) -> bool:
    """Return whether there is a file; a name that is too long is that of none."""
    try:
        return path.is_file()
    except OSError:
        return False


def _part(path: Path, source: str, index: int) -> Any:
    """Return the contents of a part, which has no parts of its own."""
    try:
        mapping = read_yaml(path)
    except InputError as error:
        raise InputError(f"{source}: parts[{index}]: {error}") from None
    if isinstance(mapping, dict) and "parts" in mapping:
        allowed = "a study without parts of its own"
        raise InputError.of_value(source, f"parts[{index}]", path.name, allowed)
    return mapping


def _with_part(study: Study, part: Study, source: str) -> Study:
    """Return a study with the points, series, boundaries and figures of a part as well."""
    for name in part.series:
        if name in study.series:
            allowed = "a part without a series of a name that another has"
            raise InputError.of_value(source, f"series {name}", part.path.name, allowed)
    points = dict(study.points)
    for one in part.points.values():
        for name in one.series:
            points[one.id] = as_member(points, one.parameters, name, one.figures + one.left_out)
        require_same(points[one.id], one.parameters, source)
    return replace(
        study,
        files=study.files + part.files,
        points=points,
        series=study.series | part.series,
        boundaries=study.boundaries + part.boundaries,
    )
