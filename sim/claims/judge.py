"""From a dataset to verdicts: every claim under every protocol and reading that was run."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

from sim.claims.evidence import Evidence
from sim.claims.experiments import experiment
from sim.claims.judgement import MODEL, PROTOCOLS, Judgement, Variant
from sim.claims.own import own_claims
from sim.claims.points import Points
from sim.claims.readings import GRID, in_words, readings_of, readings_run
from sim.claims.table import OWN, Claim, claims
from sim.claims.verdict import Check, Untestable
from sim.dataset.results import Results

#: Readings of the contact law under which claims on the model are judged.
MODEL_READINGS: tuple[dict[str, Any], ...] = (
    {},
    {"overlap_memory": "shrink"},
    {"overlap_memory": "reset"},
    {"friction_cap": "after"},
    {"sliding_direction": "slip"},
)


def judge(results: Results) -> list[Judgement]:
    """Judge the claims of papers and plug-ins on whose systems a study has runs."""
    systems = set(results.dataset["system"].values)
    every_claim: list[Claim] = [*claims(), *own_claims()]
    found = [claim for claim in every_claim if claim.system in systems]
    every = {system: list(_evidence(results, system)) for system in systems}
    return [
        Judgement(
            claim,
            tuple(_variants(claim, every[claim.system])),
            in_words(claim.system, readings_of(claim.system).headline),
        )
        for claim in found
    ]


def _evidence(results: Results, system: str) -> Iterator[tuple[dict[str, Any], Evidence]]:
    """Yield each reading with what each protocol offers under it, the headline first."""
    points, first = Points(results), readings_of(system).headline
    others = [one for one in ({}, *readings_run(results, system)) if one != first]
    for reading in (first, *others):
        runs = {name: value for name, value in reading.items() if name != GRID}
        looked_at = replace(results, grid=reading.get(GRID, results.grid))
        for protocol in PROTOCOLS:
            yield reading, Evidence(looked_at, protocol, runs, points)


def _variants(
    claim: Claim, every: Sequence[tuple[Mapping[str, Any], Evidence]]
) -> Iterator[Variant]:
    """Yield the claim at the headline reading, then at readings under which it is another matter.

    It is not where they have no runs of their own, as a claim that names what a reading changes
    looks at the same points under both; nor where it looks at no profile that another grid changes.
    """
    declared = readings_of(claim.system)
    if claim.kind == "model":
        for changes in MODEL_READINGS:
            words, checks = in_words(claim.system, changes), experiment(claim, changes)
            yield Variant(MODEL, words, checks, control=declared.is_control(changes))
        return
    seen = set()
    for reading, evidence in every:
        if claim.paper == OWN and not evidence.has_runs(claim.system):
            # Nothing is said of a protocol that the study has not chosen.
            continue
        words = in_words(claim.system, reading)
        variant = _judged(claim, evidence, words, declared.is_control(reading))
        found = variant.protocol, repr(variant.checks)
        if reading == declared.headline or not (variant.reason or found in seen):
            yield variant
        seen.add(found)


def _judged(claim: Claim, evidence: Evidence, reading: str, control: str) -> Variant:
    number = claim.number
    try:
        checks = _checked(claim, evidence, (number.headline,) if number else ())
    except Untestable as error:
        return Variant(evidence.protocol, reading, reason=str(error), control=control)
    except ZeroDivisionError:
        reason = "a quantity that the claim divides by is exactly zero"
        return Variant(evidence.protocol, reading, reason=reason, control=control)
    if claim.paper == OWN:
        used = dict.fromkeys(point for check in checks for point in check.points)
        unsteady = evidence.unsteady(used)
        return Variant(evidence.protocol, reading, checks, control=control, unsteady=unsteady)
    others = {}
    for value in number.values if number else ():
        try:
            others[value] = _checked(claim, evidence, (value,))
        except (Untestable, ZeroDivisionError):
            continue
    return Variant(evidence.protocol, reading, checks, others=others, control=control)


def _checked(claim: Claim, evidence: Evidence, number: tuple[float, ...]) -> tuple[Check, ...]:
    checks = tuple(claim.judging()(evidence, *number))
    if not checks:
        raise ValueError(f"{claim.id}: the judge checked nothing")
    unknown = {check.part for check in checks if check.deciding} - set(claim.parts or ("",))
    if unknown:
        raise ValueError(f"{claim.id}: no part {', '.join(sorted(unknown))} in the table")
    return checks
