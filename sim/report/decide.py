"""More replicates and longer runs where they decide something, until the budget is spent."""

import subprocess
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from math import ceil
from pathlib import Path

import numpy as np
import xarray as xr

from sim.base.errors import InputError
from sim.claims.judge import judge
from sim.claims.judgement import Judgement
from sim.claims.readings import in_words
from sim.dataset.agreement import require_agreement
from sim.dataset.results import Results, load_results
from sim.study.command import snakemake
from sim.study.extra_amounts import ExtraAmounts, read_extra_amounts, write_extra_amounts
from sim.study.load import Point, Study, load_study

#: A round makes a point at most so many times as long as it is: what few replicates say of how many
#: it takes is not to be trusted far.
MOST = 4

#: Times as long that a round makes a run that is too short.
TIMES = 2


@dataclass(frozen=True)
class Offer:
    """A question, and how much of which points would decide it.

    ``amounts`` by id of the point and name of the amount; ``hours`` are the core hours that what is
    still to be run will take.
    """

    question: str
    amounts: Mapping[str, Mapping[str, float]]
    hours: float

    def __str__(self) -> str:
        many = len(self.amounts)
        points = f"{many} point" + "s" * (many > 1)
        more = any("replicates" in wanted for wanted in self.amounts.values())
        what = "replicates" if more else "longer runs"
        return f"{self.question}: {what} of {points}, {self.hours:.2g} core hours"


def decide(study_path: Path, results: Path, cores: int | None) -> list[str] | int:
    """Buy the replicates of the next round; with ``cores``, run study and rounds to their end.

    Returns
    -------
    list of str or int
        What was bought, and what the budget has left; or the exit code of a workflow that failed.

    Raises
    ------
    InputError
        When the study does not say what is to be decided, or its dataset is not there.
    """
    if cores is None:
        return _round(study_path, results)[0]
    if cores < 1:
        raise InputError.of_value("--cores", "", cores, "an integer >= 1")
    while True:
        done = subprocess.run(snakemake(study_path, cores))
        if done.returncode:
            return done.returncode
        lines, bought = _round(study_path, results)
        print(*lines, sep="\n", flush=True)
        if not bought:
            return 0


def _round(study_path: Path, results: Path) -> tuple[list[str], bool]:
    """Buy what fits into the budget, the cheapest answers first; return lines and whether any."""
    study = load_study(study_path, results)
    if study.decide is None:
        raise InputError.of_value(study_path, "decide", None, "what is to be decided")
    folder = results / study.name
    found = load_results(folder / "dataset.nc")
    require_agreement(study, found, folder / "dataset.nc")
    held, taken = read_extra_amounts(folder), _hours(found.dataset)
    before = held.before if held.amounts else taken
    left = study.decide.budget - (taken - before)
    offers = sorted(_offers(study, found), key=lambda offer: offer.hours)
    amounts = {point: dict(wanted) for point, wanted in held.amounts.items()}
    lines = []
    for offer in offers:
        fits = offer.hours <= left
        lines.append(f"{offer}" if fits else f"{offer}: beyond the budget")
        for point, wanted in offer.amounts.items() if fits else ():
            known = amounts.setdefault(point, {})
            known |= {name: max(known.get(name, 0.0), value) for name, value in wanted.items()}
        left -= offer.hours if fits else 0.0
    bought = amounts != held.amounts
    if bought:
        write_extra_amounts(folder, ExtraAmounts(amounts, before))
        lines.append("bought; run the study again")
    spent = f"{taken - before:.2g} of {study.decide.budget:g} core hours spent"
    return [*lines, spent if offers else f"nothing is open; {spent}"], bought


def _hours(dataset: xr.Dataset) -> float:
    return float(dataset["wall_time"].sum()) / 3600


def _offers(study: Study, results: Results) -> Iterator[Offer]:
    """Yield what is open of what the study wants decided, and can be by more or longer runs."""
    assert study.decide is not None, "asked of studies that decide something"
    if study.decide.claims is not None:
        yield from _of_claims(study, results, study.decide.claims)
    if study.decide.precision is not None:
        yield from _of_precision(study, results, study.decide.precision)


def _of_claims(study: Study, results: Results, wanted: list[str]) -> Iterator[Offer]:
    first = load_study(study.path, None).points
    for one in judge(results):
        if one.claim.id not in wanted and "all" not in wanted:
            continue
        for reading in _readings(study, one):
            times: dict[str, float] = {}
            for check in one.open(reading):
                for point in check.points:
                    # Too few samples to tell how many it takes.
                    needed = check.times if check.known else MOST
                    times[point] = max(times.get(point, 1.0), needed)
            name = one.claim.id + (f" ({reading})" if reading != one.headline else "")
            yield from _offer(name, times, study, results)
            yield from _longer(name, one.short(reading), first, study, results)


def _readings(study: Study, judged: Judgement) -> list[str]:
    """Return the headline reading, and those under which the study runs every series."""
    system = judged.claim.system
    under = (in_words(system, reading) for reading in study.readings.get(system, ()))
    return list(dict.fromkeys([judged.headline, *under]))


def _of_precision(study: Study, results: Results, precision: float) -> Iterator[Offer]:
    """Yield an offer for each steady flow whose mean is not known well enough."""
    dataset = results.dataset
    columns = ("point", "point_regime", "point_velocity", "point_half_width")
    for point, regime, velocity, half_width in zip(
        *(dataset[name].values for name in columns), strict=True
    ):
        if regime == "steady" and half_width > precision * abs(velocity):
            times = (half_width / (precision * velocity)) ** 2
            yield from _offer(f"{point} to {precision:.2g}", {point: times}, study, results)


def _offer(
    question: str, times: Mapping[str, float], study: Study, results: Results
) -> Iterator[Offer]:
    """Yield the offer to make points so many times as large, if the study may."""
    assert study.decide is not None, "asked of studies that decide something"
    amounts, hours = {}, 0.0
    for point, factor in times.items():
        took = _took(results.dataset, point)
        number = min(ceil(len(took) * min(factor, MOST)), study.decide.replicates)
        if number > len(took) > 0:
            amounts[point] = {"replicates": float(number)}
            hours += (number - len(took)) * float(took.mean()) / 3600
    if amounts:
        yield Offer(question, amounts, hours)


def _longer(
    question: str,
    short: Iterable[str],
    first: Mapping[str, Point],
    study: Study,
    results: Results,
) -> Iterator[Offer]:
    """Yield the offer to run points for longer, if the study may: what a run has of them grows.

    Where runs end because their mean is known, before any limit, there are more of them instead.
    ``first`` are the points as the study file has them, without what was bought.
    """
    assert study.decide is not None, "asked of studies that decide something"
    amounts, hours = {}, 0.0
    more: dict[str, float] = {}
    for point in filter(first.__contains__, short):
        now, own = study.points[point].parameters, first[point].parameters
        name = "limit" if now.protocol == "converged" else "average"
        if name == "limit" and "limit" not in results.dataset["stopped"].sel(point=point).values:
            more[point] = float(TIMES)
            continue
        had, most = getattr(now, name), study.decide.longer * getattr(own, name)
        wanted = min(TIMES * had, most)
        if wanted > had:
            amounts[point] = {name: wanted}
            share = (wanted - had) / (had if name == "limit" else now.transient + had)
            hours += share * float(_took(results.dataset, point).sum()) / 3600
    if amounts:
        yield Offer(question, amounts, hours)
    yield from _offer(question, more, study, results)


def _took(dataset: xr.Dataset, point: str) -> np.ndarray:
    """Return the wall time (s) of each replicate of a point."""
    took = dataset["wall_time"].sel(point=point).values
    return took[np.isfinite(took)]
