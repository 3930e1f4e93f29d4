"""Read a study file and its parts, and expand them to points, boundaries and figures."""

import re
from dataclasses import replace
from pathlib import Path
from typing import Any

from sim.base.additions import Plugin
from sim.base.errors import InputError
from sim.base.files import require_writable
from sim.base.plugins import PATTERN, load
from sim.base.yaml import read_yaml
from sim.parameters import RUN_FILE, require_compatible_source
from sim.study.cost import Estimate, estimate
from sim.study.extra_amounts import read_extra_amounts, with_extra_amounts
from sim.study.figure_points import points_of_figures
from sim.study.figure_spec import FigureSpec
from sim.study.model import Boundary, Point, Study
from sim.study.plots import plot_specs, points_of_plot
from sim.study.points import (
    MAX_POINTS,
    expand_study_file,
    point_with_membership,
    require_same_point,
)
from sim.study.series import readings_by_system

__all__ = [
    "Boundary",
    "Estimate",
    "Point",
    "Study",
    "estimate",
    "load_study",
    "parse_study",
    "point_with_membership",
]

#: Study to use if none is named.
DEFAULT_STUDY = Path("config/quick.yaml")

#: Maximum number of points of a study with a page for each point.
MAX_PAGES = 1000


def load_study(
    path: str | Path, results: str | Path | None = "results", plugins: bool = True
) -> Study:
    """Return the study that a study file describes.

    Parameters
    ----------
    path : str or Path
        The study file.
    results : str, Path or None
        Folder of the study's own folder of results, which must be writable. ``None`` if nothing
        will be written.
    plugins : bool
        Whether to load the plug-ins that the study names, which runs their code. It should be false
        if the path of the study comes from a folder of results.

    Raises
    ------
    InputError
        For any mistake that prevents the study from being run as written.
    """
    return parse_study(read_yaml(path), path, results, plugins)


def parse_study(
    mapping: Any, path: str | Path, results: str | Path | None = "results", plugins: bool = True
) -> Study:
    """Return the study that ``mapping``, read from ``path``, describes.

    See `load_study`.
    """
    source, folder = str(path), Path(path).parent
    loaded_plugins = _load_plugins(mapping, Path(path)) if plugins else ()
    file, study, feeds = expand_study_file(mapping, Path(path))
    plots: dict[str, FigureSpec] = {}
    for index, name in enumerate(file.parts or []):
        part_mapping = _read_part(folder / name, source, index)
        loaded_plugins += _load_plugins(part_mapping, folder / name) if plugins else ()
        part_file, part, part_feeds = expand_study_file(part_mapping, folder / name)
        study = _merge_part(study, part, f"{source}: parts[{index}]")
        plots |= plot_specs(part_file, part, str(folder / name), plots)
        feeds = part_feeds | feeds
    if len(study.points) > MAX_POINTS:
        allowed = f"at most {MAX_POINTS:,} points in the study"
        raise InputError.of_value(source, "parts", f"{len(study.points):,} points", allowed)
    if file.pages and len(study.points) > MAX_PAGES:
        allowed = f"false, for more than {MAX_PAGES:,} points"
        raise InputError.of_value(source, "pages", True, allowed)
    _require_valid_starts(study, source)
    figures = points_of_figures(file, study.points.values(), feeds, source)
    plots = plot_specs(file, study, source, plots) | plots
    figures |= {name: points_of_plot(spec, study.points.values()) for name, spec in plots.items()}
    if results is not None:
        require_writable(Path(results) / file.study, f"{source}: study")
    points = study.points
    if file.decide and results is not None:
        extra = read_extra_amounts(Path(results) / file.study)
        points = with_extra_amounts(points, extra, judged=file.decide.claims is not None)
    return replace(
        study,
        points=points,
        figures=figures,
        plots=plots,
        readings=readings_by_system(file),
        decide=file.decide,
        pages=file.pages,
        plugins=tuple(dict.fromkeys(loaded_plugins)),
    )


def _load_plugins(mapping: Any, path: Path) -> tuple[Plugin, ...]:
    """Load and return the plug-ins that a study file names; none if the key is malformed.

    The rest of the file can only be validated once plug-ins are loaded, so a malformed key is
    refused then.
    """
    names = mapping.get("plugins") if isinstance(mapping, dict) else None
    if isinstance(names, list) and all(
        isinstance(name, str) and re.match(PATTERN, name) for name in names
    ):
        return load(names, path.parent, f"{path}: plugins")
    return ()


def _require_valid_starts(study: Study, source: str) -> None:
    """Raise ``InputError`` if a point starts from neither a point of the study nor a run file."""
    for point in study.points.values():
        start = point.parameters.start_from
        if start in study.points:
            require_compatible_source(point.parameters, study.points[start].parameters, source)
        elif start and not (start.endswith(RUN_FILE) and _is_file(Path(start))):
            allowed = "the id of a point of the study, or a run file (*.nc) that is there"
            raise InputError.of_value(source, "start_from", start, allowed)


def _is_file(path: Path) -> bool:
    """True where ``path`` is a file; a name that is too long is none."""
    try:
        return path.is_file()
    except OSError:
        return False


def _read_part(path: Path, source: str, index: int) -> Any:
    """Return the contents of a part; raise ``InputError`` if it has parts of its own."""
    try:
        mapping = read_yaml(path)
    except InputError as error:
        raise InputError(f"{source}: parts[{index}]: {error}") from None
    if isinstance(mapping, dict) and "parts" in mapping:
        allowed = "a study without parts of its own"
        raise InputError.of_value(source, f"parts[{index}]", path.name, allowed)
    return mapping


def _merge_part(study: Study, part: Study, source: str) -> Study:
    """Return a study with the points, series and boundaries of a part added."""
    for name in part.series:
        if name in study.series:
            allowed = "a part without a series of a name that another has"
            raise InputError.of_value(source, f"series {name}", part.path.name, allowed)
    points = dict(study.points)
    for point in part.points.values():
        figures = point.figures + point.left_out
        for name in point.series:
            points[point.id] = point_with_membership(points, point.parameters, name, figures)
        require_same_point(points[point.id], point.parameters, source)
    return replace(
        study,
        files=study.files + part.files,
        points=points,
        series=study.series | part.series,
        boundaries=study.boundaries + part.boundaries,
    )
