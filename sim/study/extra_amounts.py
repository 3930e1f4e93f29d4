"""Amounts that rounds of decisions have added to points, saved in ``bought.json``."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from sim.base.additions import plain_name, plugin_options
from sim.base.files import atomic_write
from sim.base.seals import checked_read, parse_sealed_json, to_sealed_json
from sim.parameters import Parameters, with_larger_amounts
from sim.parameters.laws import ENGINE
from sim.study.model import Point, Study


@dataclass(frozen=True)
class ExtraAmounts:
    """Amounts beyond those of the study file.

    Attributes
    ----------
    amounts : mapping
        Amounts by id of the point and name of the amount.
    before : float
        Core hours that the study had taken before the first round was added.
    rounds : mapping
        In how many rounds amounts were added, by id of the point.
    """

    amounts: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    before: float = 0.0
    rounds: Mapping[str, int] = field(default_factory=dict)


def extra_amounts_file(folder: Path) -> Path:
    """Return the path of the extra amounts of a study whose results are in ``folder``."""
    return folder / "bought.json"


def read_extra_amounts(folder: Path) -> ExtraAmounts:
    """Return the extra amounts of a study; there are none without a file.

    A damaged file is renamed. Raises ``InputError`` if it cannot be read.
    """
    path = extra_amounts_file(folder)
    try:
        path.lstat()
    except FileNotFoundError:
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
    new_points = {
        name: replace(
            point,
            parameters=with_larger_amounts(point.parameters, extra.amounts.get(name, {})),
            looks=1 + extra.rounds.get(name, 0) if judged else 0,
        )
        for name, point in points.items()
    }
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
    option = parameters.option(ENGINE.name)
    values = {
        name: type(parameters).model_fields[name].default
        for name in ("threads", *option.owns, *option.parameters)
    }
    values[ENGINE.name] = other if engine == OWN else OWN
    twin: Any = parameters.model_copy(update=values)
    return None if twin.refusals else twin


def twins(study: Study, other: str) -> dict[str, Parameters]:
    """Return the points by the second of our engine and another, by the ids of those of a study."""
    every = {key: twin_of(point.parameters, other) for key, point in study.points.items()}
    return {key: twin for key, twin in every.items() if twin is not None}
