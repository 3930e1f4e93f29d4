"""Load a study: read, validate, expand, feed and ask its file; and its points as a table."""

import os
import re
import warnings
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from sim.base.additions import Plugin, plain_name, plugin_options
from sim.base.errors import InputError
from sim.base.files import atomic_write, require_writable
from sim.base.numbers import plain
from sim.base.plugins import PATTERN as PLUGIN_NAME
from sim.base.plugins import load
from sim.base.seals import checked_read, parse_sealed_json, to_sealed_json
from sim.base.yaml import read_yaml
from sim.parameters import Parameters, complete_values, parse_point, with_larger_amounts
from sim.parameters.doubts import doubts_of
from sim.parameters.laws import ENGINE
from sim.study.entries import ends_left_out
from sim.study.expand import expand
from sim.study.feed import ask, feed
from sim.study.file import PART_NAME
from sim.study.model import Boundary, Point, Study, estimate
from sim.study.papers import paper_values
from sim.study.validate import validate

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True)
class ExtraAmounts:
    """Amounts beyond those of the study file, which rounds of decisions have added.

    ``amounts`` are by id of the point and name of the amount, ``rounds`` says in how many rounds
    they were added, by id, and ``before`` how many core hours the study had taken before the first.
    """

    amounts: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    before: float = 0.0
    rounds: Mapping[str, int] = field(default_factory=dict)


def extra_amounts_file(folder: Path) -> Path:
    """Return the path of the extra amounts of a study whose results are in ``folder``."""
    return folder / "bought.json"


def read_extra_amounts(folder: Path) -> ExtraAmounts:
    """Return the extra amounts of a study, none without a file; a damaged one is renamed."""
    path = extra_amounts_file(folder)
    if not os.path.lexists(path):
        return ExtraAmounts()
    with checked_read(path, "list of what was bought", replaceable=True):
        document = parse_sealed_json(path.read_text(encoding="utf-8"))
        amounts = document["amounts"]
        # Files from before rounds were counted name none: there was one at least.
        rounds = dict.fromkeys(amounts, 1) | document.get("rounds", {})
        return ExtraAmounts(amounts, float(document["before"]), rounds)


def write_extra_amounts(folder: Path, extra: ExtraAmounts) -> None:
    """Write the extra amounts of a study; the file is complete or does not appear."""
    document = {"before": extra.before, "amounts": extra.amounts, "rounds": extra.rounds}
    with atomic_write(extra_amounts_file(folder)) as temporary:
        temporary.write_text(to_sealed_json(document), encoding="utf-8")


def with_extra_amounts(
    points: Mapping[str, Point], extra: ExtraAmounts, judged: bool = False
) -> dict[str, Point]:
    """Return points with their extra amounts, and with their looks where verdicts ask for them.

    A point that others start from gets at least as many replicates as they have. ``judged`` says
    whether runs are bought for open claims.
    """
    new_points = {}
    for name, point in points.items():
        larger = with_larger_amounts(point.parameters, extra.amounts.get(name, {}))
        looks = 1 + extra.rounds.get(name, 0) if judged else 0
        new_points[name] = replace(point, parameters=larger, looks=looks)
    for point in list(new_points.values()):
        name, wanted = point.parameters.start_from, {"replicates": point.parameters.replicates}
        while name in new_points:
            source = new_points[name]
            larger = with_larger_amounts(source.parameters, wanted)
            new_points[name] = replace(source, parameters=larger)
            name = source.parameters.start_from
    return new_points


#: The engine of this program; a second opinion compares it with another one.
OWN = ENGINE.usual[0]


def other_engines() -> Mapping[str, str]:
    """Return the engines besides that of this program as points name them, by plain name."""
    names = (*ENGINE.usual[1:], *plugin_options(ENGINE.name))
    return {plain_name(name): name for name in names}


def twin_of(parameters: Parameters, other: str) -> Parameters | None:
    """Return a point of one engine, ours or the other, by the second; None where it refuses it."""
    engine = getattr(parameters, ENGINE.name, "")
    if engine not in (OWN, other):
        return None
    option, fields = parameters.option(ENGINE.name), type(parameters).model_fields
    names = ("threads", *option.owns, *option.parameters)
    values = {name: fields[name].default for name in names}
    values[ENGINE.name] = other if engine == OWN else OWN
    twin: Any = parameters.model_copy(update=values)
    return None if twin.refusals else twin


def twins(study: Study, other: str) -> dict[str, Parameters]:
    """Return the points by the second of our engine and another, by the ids of those of a study."""
    every = {key: twin_of(point.parameters, other) for key, point in study.points.items()}
    return {key: twin for key, twin in every.items() if twin is not None}


__all__ = ["Boundary", "Point", "Study", "load_study", "parse_study", "points"]

#: Study to use if none is named.
DEFAULT_STUDY = Path("config/quick.yaml")


def load_study(path: str | Path, results: str | Path | None = "results") -> Study:
    """Return the study that a study file describes.

    Its folder in the folder ``results`` must be writable; ``None`` if nothing will be written.
    Raises ``InputError`` for any mistake that prevents the study from being run as written.
    """
    return parse_study(read_yaml(path), path, results)


def parse_study(mapping: Any, path: str | Path, results: str | Path | None = "results") -> Study:
    """Return the study that ``mapping``, read from ``path``, describes, as `load_study` does."""
    documents = [(Path(path), mapping), *_parts(mapping, Path(path))]
    loaded = list[Plugin]()
    for place, contents in documents:
        names = _names(contents, "plugins", PLUGIN_NAME)
        loaded += load(names, place.parent, f"{place}: plugins")
    files = validate(documents)
    study = ask(feed(expand(files), files), files)
    if results is not None:
        folder = folder_of_results(study, Path(results)) / study.name
        require_writable(folder, f"{study.path}: study")
        if study.decide:
            extra, judged = read_extra_amounts(folder), study.decide.claims is not None
            study = replace(study, points=with_extra_amounts(study.points, extra, judged))
    return replace(study, plugins=tuple(dict.fromkeys(loaded)))


def folder_of_results(study: Study, results: Path) -> Path:
    """Return the folder of all results that has those of a study.

    It is ``results``; but where this has none of the study, and a folder of its name beside the
    study file has, it is that one.
    """
    beside = study.path.parent / results
    is_beside = not (results / study.name).is_dir() and (beside / study.name).is_dir()
    return beside if is_beside else results


def as_study(contents: Any, path: Path) -> Any:
    """Return the contents of a study file; those of a point file become a study of one point."""
    if not isinstance(contents, dict) or "system" not in contents or "series" in contents:
        return contents
    # Its mistakes are told as those of a point.
    point = parse_point(contents, path)
    base = {name: value for name, value in contents.items() if name != "system"}
    series = {"name": "point", "system": point.system, "base": base}
    return {"study": "point", "series": [series]}


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
    texts = names if isinstance(names, list) else []
    is_right = all(isinstance(one, str) and re.match(pattern, one) for one in texts)
    return texts if is_right else []


def points(study: str | Path | Mapping[str, Any]) -> "pd.DataFrame":
    """Return the points of a study as a table: one row per point, in the order of the study.

    Parameters
    ----------
    study : str, Path or mapping
        The study file, or a mapping with its contents.

    Returns
    -------
    pandas.DataFrame
        The index holds the ids of the points. Columns are all parameters in the units of a study
        file, ``particles``, ``core_seconds`` (an estimate for all replicates), ``series`` and
        ``figures``. Parameters that the system of a point does not have are missing. The attribute
        ``paper_values`` lists what all points have as a paper has it. What is probably not meant is
        a warning: sizes, angles, ranges that end before their ``stop``.

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
        validated_study = parse_study(plain(study), "points", None)
    elif isinstance(study, (str, Path)):
        validated_study = load_study(study, None)
    else:
        raise InputError.of_value("points", "study", study, "the path of a study file or a mapping")
    members = [point.parameters for point in validated_study.points.values()]
    doubts = doubts_of(members) if validated_study.units == "si" else []
    contents = study if isinstance(study, Mapping) else read_yaml(study)
    for text in (*ends_left_out(contents), *doubts):
        warnings.warn(text, stacklevel=2)
    rows = {}
    for point in validated_study.points.values():
        cost = estimate(point.parameters)
        rows[point.id] = complete_values(point.parameters) | {
            **{"particles": cost.particles, "core_seconds": cost.core_seconds},
            **{"series": point.series, "figures": point.figures},
        }
    table = pd.DataFrame.from_dict(rows, orient="index").rename_axis("point")
    table.attrs["paper_values"] = paper_values(members, validated_study.paper)
    return table
