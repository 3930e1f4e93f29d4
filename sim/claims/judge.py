"""From a dataset to verdicts: every claim under every protocol and reading with runs."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

from sim.claims.claim import OWN, Claim, claims
from sim.claims.evidence import (
    DEFAULT,
    GRID,
    Evidence,
    combined_readings,
    is_regridded,
    model_readings,
    paper_of,
    reading_label,
)
from sim.claims.experiments import run_experiment
from sim.claims.judgement import MODEL, PROTOCOLS, Judgement, Variant
from sim.claims.place import Points
from sim.claims.verdict import Ambiguous, Check, Untestable
from sim.dataset.results import Results
from sim.study.papers import Paper, Readings, foreign_papers


def judge(results: Results, paper: str = "") -> list[Judgement]:
    """Judge the claims, of papers and plug-ins, on systems that the study has runs of.

    ``paper`` is that of the study, whose values hold for its own claims, too. Papers that ship with
    values of their own are judged by studies that name them alone.
    """
    systems, judgements = set(results.dataset["system"].values), []
    points, foreign = dict[str, Points](), foreign_papers(paper)
    evidence_by_paper: dict[tuple[str, str], list[tuple[dict[str, Any], Evidence]]] = {}
    for claim in claims(systems):
        if claim.paper in foreign:
            continue
        one = paper_of(claim.system, paper if claim.paper == OWN else claim.paper)
        key = claim.system, one.name
        if key not in evidence_by_paper:
            # Papers without values of their own share what has been looked up.
            own = one.name if one.defaults else ""
            of_values = points[own] = points.get(own) or Points(results, one)
            evidence_by_paper[key] = list(_evidence(results, of_values, claim.system, one))
        if claim.kind == "model":
            variants = tuple(_experiments(results, claim, one))
        else:
            variants = tuple(_variants(claim, one.readings, evidence_by_paper[key]))
        headline = reading_label(claim.system, one.readings.headline, one.readings)
        judgements.append(Judgement(claim, variants, headline))
    return judgements


def _evidence(
    results: Results, points: Points, system: str, one: Paper
) -> Iterator[tuple[dict[str, Any], Evidence]]:
    for reading in combined_readings(results, system, one):
        runs = {name: value for name, value in reading.items() if name != GRID}
        regridded = replace(results, grid=reading.get(GRID, results.grid))
        for protocol in PROTOCOLS:
            yield reading, Evidence(regridded, protocol, runs, points)


def _experiments(results: Results, claim: Claim, one: Paper) -> Iterator[Variant]:
    for changes in model_readings(results, claim.system, one):
        label = reading_label(claim.system, changes, one.readings)
        checks = run_experiment(claim, changes)
        yield Variant(MODEL, label, checks, control=one.readings.control_reason(changes))


def _variants(
    claim: Claim,
    readings: Readings,
    evidence_by_reading: Sequence[tuple[Mapping[str, Any], Evidence]],
) -> Iterator[Variant]:
    """Yield the claim at the first reading, which heads it, then where another changes its checks.

    A reading without runs of its own changes nothing: a claim that names the parameters of a
    reading uses the same points under both. Nor does another profile grid, if the claim uses no
    profile. Alternatives of the claim are judged under each reading of the runs.
    """
    keys: set[tuple[Any, ...]] = set()
    grids = set()
    first = evidence_by_reading[0][0]
    for reading, evidence in evidence_by_reading:
        grid, regridded = reading.get(GRID), is_regridded(reading, first)
        if regridded and grid not in grids:
            # Where a grid changes nothing at the first reading, the claim uses no profile.
            continue
        if claim.paper == OWN and not evidence.has_runs(claim.system):
            # A protocol without runs is skipped for a study's own claims.
            continue
        label = reading_label(claim.system, reading, readings)
        variant = _judge_under(claim, evidence, label, readings.control_reason(reading))
        if regridded:
            variant = replace(variant, checks=_votes(variant))
        key = variant.protocol, tuple(map(_rounded, variant.checks))
        if reading == first or not (variant.reason or key in keys):
            yield variant
            grids.add(grid)
        keys.add(key)
        usual = tuple(map(_rounded, _votes(variant)))
        for words in claim.alternatives if grid is None else ():
            both = words if label == DEFAULT else f"{label}; {words}"
            other = _judge_under(claim, evidence, both, variant.control, words)
            votes = _votes(other)
            rounded = tuple(map(_rounded, votes))
            # What an alternative does not change is the reading of the runs itself.
            if votes and rounded != usual and (other.protocol, words, rounded) not in keys:
                yield replace(other, checks=votes)
            keys.add((other.protocol, words, rounded))


def _votes(variant: Variant) -> tuple[Check, ...]:
    return tuple(check for check in variant.checks if check.has_vote)


def _rounded(check: Check) -> tuple[Any, ...]:
    """Return what tells one check from another; equal sums may differ in their last digits."""
    sizes = check.value, check.half_width, check.low, check.high, check.samples
    numbers = *sizes, *(check.tested or ())
    rest = check.what, check.part, check.votes, check.withheld, check.points
    return *(f"{number:.9g}" for number in numbers), *rest


def _judge_under(
    claim: Claim, evidence: Evidence, reading: str, control: str, alternative: str = ""
) -> Variant:
    try:
        checks = claim.checks_on(evidence, alternative=alternative)
    except (Untestable, Ambiguous, ZeroDivisionError) as error:
        is_zero = isinstance(error, ZeroDivisionError)
        reason = "a quantity that the claim divides by is exactly zero" if is_zero else str(error)
        return Variant(evidence.protocol, reading, reason=reason, control=control)
    checks_by_number = {}
    for value in claim.number.values if claim.number else ():
        try:
            checks_by_number[value] = claim.checks_on(evidence, value, alternative)
        except (Untestable, Ambiguous, ZeroDivisionError):
            continue
    # Judges of a study's own claims need not test whether flows are steady.
    points = dict.fromkeys(point for check in checks for point in check.points)
    unsteady = evidence.unsteady_note(points) if claim.paper == OWN else ""
    return Variant(evidence.protocol, reading, checks, "", checks_by_number, control, unsteady)
