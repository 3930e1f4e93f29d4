"""Amounts of points that rounds of decisions have added to a study, kept in ``bought.json``."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

from sim.base.damage import checked_read
from sim.base.files import replacing
from sim.base.sealed_json import as_sealed, read_sealed
from sim.parameters import AMOUNTS, Parameters, more
from sim.study.model import Point


@dataclass(frozen=True)
class ExtraAmounts:
    """How much is wanted beyond the study file.

    ``amounts`` by id of the point and name of the amount; ``before`` are the core hours that the
    study had taken when the first round was bought.
    """

    amounts: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    before: float = 0.0


def extra_amounts_file(folder: Path) -> Path:
    """Return the path of the extra amounts of a study with its results in a folder."""
    return folder / "bought.json"


def read_extra_amounts(folder: Path) -> ExtraAmounts:
    """Return the extra amounts of a study, none without a file; a damaged one is set aside.

    Raises ``InputError`` when it cannot be read.
    """
    path = extra_amounts_file(folder)
    if not path.exists():
        return ExtraAmounts()
    with checked_read(path, "list of what was bought", replaceable=True):
        held = read_sealed(path.read_text(encoding="utf-8"))
        amounts = {
            point: {name: _usable(name, value) for name, value in wanted.items()}
            for point, wanted in held["amounts"].items()
        }
        return ExtraAmounts(amounts, float(held["before"]))


def _usable(name: str, value: float) -> float:
    """Return an amount that a point may have; raise ``ValueError`` for any other."""
    most = 1000 if name == "replicates" else 1e12
    if name not in AMOUNTS or not 0 < float(value) <= most:
        raise ValueError(f"{name}: {value} is no amount of a run")
    return float(value)


def write_extra_amounts(folder: Path, extra: ExtraAmounts) -> None:
    """Write the extra amounts of a study, complete or not at all."""
    document = {"before": extra.before, "amounts": extra.amounts}
    with replacing(extra_amounts_file(folder)) as temporary:
        temporary.write_text(as_sealed(document), encoding="utf-8")


def with_extra_amounts(points: Mapping[str, Point], extra: ExtraAmounts) -> dict[str, Point]:
    """Return points with their extra amounts.

    What points start from has as many replicates as they have.
    """
    grown = {
        name: replace(point, parameters=_grown(point.parameters, extra.amounts.get(name, {})))
        for name, point in points.items()
    }
    for point in list(grown.values()):
        name, wanted = point.parameters.start_from, {"replicates": point.parameters.replicates}
        while name in grown:
            source = grown[name]
            grown[name] = replace(source, parameters=more(source.parameters, wanted))
            name = source.parameters.start_from
    return grown


def _grown(parameters: Parameters, wanted: Mapping[str, float]) -> Parameters:
    return more(parameters, wanted) if wanted else parameters
