"""Add replicates and longer runs where they can decide a question, within a budget."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from math import ceil
from pathlib import Path

import numpy as np
import xarray as xr

from sim.base.errors import InputError, count_text
from sim.claims.evidence import reading_label, readings_of
from sim.claims.judge import judge
from sim.dataset.results import Results, load_current
from sim.study.command import go_to_results, run_with_signals, snakemake_command
from sim.study.load import (
    ExtraAmounts,
    Point,
    Study,
    folder_of_results,
    load_study,
    read_extra_amounts,
    write_extra_amounts,
)

#: Largest factor by which a round multiplies the replicates of a point: few replicates give a poor
#: estimate of the number that is needed.
MOST_FACTOR = 4

#: Factor by which a round lengthens a run that is too short.
LONGER_FACTOR = 2


@dataclass(frozen=True)
class Offer:
    """A question, and the amounts of points that would decide it.

    ``amounts`` are given by id of the point and name of the amount. ``hours`` are the core hours of
    what must still be run.
    """

    question: str
    amounts: Mapping[str, Mapping[str, float]]
    hours: float

    def __str__(self) -> str:
        has_replicates = any("replicates" in amounts for amounts in self.amounts.values())
        noun = "replicates" if has_replicates else "longer runs"
        points = count_text(len(self.amounts), "point")
        return f"{self.question}: {noun} of {points}, {self.hours:.2g} core hours"


def decide(study_path: Path, cores: int | None, results: Path = Path("results")) -> list[str] | int:
    """Buy the amounts of the next round; with ``cores``, run study and rounds until none is left.

    Returns lines on what was bought and spent, or the exit code of the workflow. `InputError` tells
    of a study without a ``decide`` section or without a dataset.
    """
    if cores is None:
        return _round(study_path, results)[0]
    if cores < 1:
        raise InputError.of_value("--cores", "", cores, "an integer >= 1")
    study_path = go_to_results(load_study(study_path, results))
    while True:
        if code := run_with_signals(snakemake_command(study_path, cores)):
            return code
        lines, bought = _round(study_path, results)
        print(*lines, sep="\n", flush=True)
        if not bought:
            return 0


def _round(study_path: Path, results: Path) -> tuple[list[str], bool]:
    """Buy the offers that fit into the budget, cheapest first.

    Returns lines to print, and whether anything was bought.
    """
    study = load_study(study_path, results)
    if study.decide is None:
        raise InputError.of_value(study_path, "decide", None, "claims, precision, or both")
    folder = folder_of_results(study, results) / study.name
    dataset_results = load_current(study, folder)
    extra = read_extra_amounts(folder)
    spent_hours = float(dataset_results.dataset["wall_time"].sum()) / 3600
    hours_before = extra.before if extra.amounts else spent_hours
    remaining = study.decide.budget - (spent_hours - hours_before)
    offers = sorted(_offers(study, dataset_results), key=lambda offer: offer.hours)
    amounts = {point: dict(requested) for point, requested in extra.amounts.items()}
    lines = []
    for offer in offers:
        fits = offer.hours <= remaining
        lines.append(f"{offer}" if fits else f"{offer}: beyond the budget")
        for point, requested in offer.amounts.items() if fits else ():
            point_amounts = amounts.setdefault(point, {})
            point_amounts |= {
                name: max(point_amounts.get(name, 0.0), value) for name, value in requested.items()
            }
        remaining -= offer.hours if fits else 0.0
    bought = amounts != extra.amounts
    if bought:
        rounds = {
            point: extra.rounds.get(point, 0) + (amounts[point] != extra.amounts.get(point))
            for point in amounts
        }
        write_extra_amounts(folder, ExtraAmounts(amounts, hours_before, rounds))
        lines.append("bought; run the study again")
    spent = f"{spent_hours - hours_before:.2g} of {study.decide.budget:g} core hours spent"
    return [*lines, spent if offers else f"nothing is open; {spent}"], bought


def _offers(study: Study, results: Results) -> Iterator[Offer]:
    """Yield an offer for each open question that more or longer runs can decide."""
    assert study.decide is not None, "asked of studies that decide something"
    if study.decide.claims is not None:
        yield from _claim_offers(study, results, study.decide.claims)
    if (precision := study.decide.precision) is not None:
        columns = ("point", "point_regime", "point_velocity", "point_half_width")
        for point, regime, velocity, half_width in zip(
            *(results.dataset[name].values for name in columns), strict=True
        ):
            if regime == "steady" and half_width > precision * abs(velocity):
                times = {point: (half_width / (precision * velocity)) ** 2}
                yield from _replicate_offer(f"{point} to {precision:.2g}", times, study, results)


def _claim_offers(study: Study, results: Results, claim_ids: list[str]) -> Iterator[Offer]:
    """Yield offers under the readings that head a claim, and those of every series of the study."""
    first = load_study(study.path, None).points
    for judged in judge(results, study.paper):
        if judged.claim.id not in claim_ids and "all" not in claim_ids:
            continue
        system = judged.claim.system
        own = (
            reading_label(system, one, readings_of(system, study.paper))
            for one in study.readings.get(system, ())
        )
        for reading in dict.fromkeys([*judged.headings, *own]):
            times: dict[str, float] = {}
            for check in judged.open_checks(reading):
                for point in check.open_points or check.points:
                    # Few samples give no estimate of the factor.
                    needed = check.replicate_factor if check.can_decide else MOST_FACTOR
                    times[point] = max(times.get(point, 1.0), needed)
            name = judged.claim.id + (f" ({reading})" if reading not in judged.headings else "")
            yield from _replicate_offer(name, times, study, results)
            yield from _longer_run_offers(name, judged.short_points(reading), first, study, results)


def _replicate_offer(
    question: str, times: Mapping[str, float], study: Study, results: Results
) -> Iterator[Offer]:
    """Yield an offer to multiply the replicates of points, as far as the study allows.

    ``times`` are the factors by id of the point.
    """
    assert study.decide is not None, "asked of studies that decide something"
    amounts, hours = {}, 0.0
    for point, factor in times.items():
        if point in study.points and study.points[point].parameters.is_alike:
            continue
        wall_times = _wall_times(results.dataset, point)
        number = min(ceil(len(wall_times) * min(factor, MOST_FACTOR)), study.decide.replicates)
        if number > len(wall_times) > 0:
            amounts[point] = {"replicates": float(number)}
            hours += (number - len(wall_times)) * float(wall_times.mean()) / 3600
    if amounts:
        yield Offer(question, amounts, hours)


def _longer_run_offers(
    question: str,
    short: Iterable[str],
    first: Mapping[str, Point],
    study: Study,
    results: Results,
) -> Iterator[Offer]:
    """Yield an offer to run points for longer, as far as the study allows: their runs grow.

    Runs that ended before any limit, because their mean was precise, get more replicates instead.
    ``first`` are the points of the study file, without bought amounts.
    """
    assert study.decide is not None, "asked of studies that decide something"
    amounts, hours = {}, 0.0
    replicate_factors: dict[str, float] = {}
    for point in filter(first.__contains__, short):
        current, original = study.points[point].parameters, first[point].parameters
        name = "limit" if current.protocol == "converged" else "average"
        if name == "limit" and "limit" not in results.dataset["stopped"].sel(point=point).values:
            replicate_factors[point] = float(LONGER_FACTOR)
            continue
        present, allowed = getattr(current, name), study.decide.longer * getattr(original, name)
        requested = min(LONGER_FACTOR * present, allowed)
        if requested > present:
            amounts[point] = {name: requested}
            share = (requested - present) / (
                present if name == "limit" else current.transient + present
            )
            hours += share * float(_wall_times(results.dataset, point).sum()) / 3600
    if amounts:
        yield Offer(question, amounts, hours)
    yield from _replicate_offer(question, replicate_factors, study, results)


def _wall_times(dataset: xr.Dataset, point: str) -> np.ndarray:
    wall_times = dataset["wall_time"].sel(point=point).values
    return wall_times[np.isfinite(wall_times)]
