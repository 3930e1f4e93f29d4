"""From a dataset to verdicts: every claim under every protocol and reading with runs."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

from sim.claims.evidence import Evidence
from sim.claims.experiments import run_experiment
from sim.claims.judgement import MODEL, PROTOCOLS, Judgement, Variant
from sim.claims.own import own_claims
from sim.claims.points import Points
from sim.claims.readings import GRID, reading_label, readings_of, readings_with_runs
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
    """Judge the claims, of papers and plug-ins, on systems that the study has runs of."""
    systems = set(results.dataset["system"].values)
    all_claims: list[Claim] = [*claims(), *own_claims()]
    judged_claims = [claim for claim in all_claims if claim.system in systems]
    evidence_by_system = {system: list(_evidence(results, system)) for system in systems}
    return [
        Judgement(
            claim,
            tuple(_variants(claim, evidence_by_system[claim.system])),
            reading_label(claim.system, readings_of(claim.system).headline),
        )
        for claim in judged_claims
    ]


def _evidence(results: Results, system: str) -> Iterator[tuple[dict[str, Any], Evidence]]:
    """Yield each reading with the evidence of each protocol, the headline reading first."""
    points, headline = Points(results), readings_of(system).headline
    others = [
        reading for reading in ({}, *readings_with_runs(results, system)) if reading != headline
    ]
    for reading in (headline, *others):
        runs = {name: value for name, value in reading.items() if name != GRID}
        regridded = replace(results, grid=reading.get(GRID, results.grid))
        for protocol in PROTOCOLS:
            yield reading, Evidence(regridded, protocol, runs, points)


def _variants(
    claim: Claim, evidence_by_reading: Sequence[tuple[Mapping[str, Any], Evidence]]
) -> Iterator[Variant]:
    """Yield the claim at the headline reading, then at readings that change its checks.

    A reading without runs of its own changes nothing: a claim that names the parameters of a
    reading uses the same points under both. Nor does another profile grid, if the claim uses no
    profile.
    """
    paper_readings = readings_of(claim.system)
    if claim.kind == "model":
        for changes in MODEL_READINGS:
            label, checks = reading_label(claim.system, changes), run_experiment(claim, changes)
            yield Variant(MODEL, label, checks, control=paper_readings.control_reason(changes))
        return
    keys = set()
    for reading, evidence in evidence_by_reading:
        if claim.paper == OWN and not evidence.has_runs(claim.system):
            # A protocol without runs is skipped for claims of plug-ins.
            continue
        label = reading_label(claim.system, reading)
        variant = _judge_under(claim, evidence, label, paper_readings.control_reason(reading))
        key = variant.protocol, repr(variant.checks)
        if reading == paper_readings.headline or not (variant.reason or key in keys):
            yield variant
        keys.add(key)


def _judge_under(claim: Claim, evidence: Evidence, reading: str, control: str) -> Variant:
    number = claim.number
    try:
        checks = _run_judge(claim, evidence, (number.headline,) if number else ())
    except Untestable as error:
        return Variant(evidence.protocol, reading, reason=str(error), control=control)
    except ZeroDivisionError:
        reason = "a quantity that the claim divides by is exactly zero"
        return Variant(evidence.protocol, reading, reason=reason, control=control)
    if claim.paper == OWN:
        points = dict.fromkeys(point for check in checks for point in check.points)
        note = evidence.unsteady_note(points)
        return Variant(evidence.protocol, reading, checks, control=control, unsteady=note)
    checks_by_number = {}
    for value in number.values if number else ():
        try:
            checks_by_number[value] = _run_judge(claim, evidence, (value,))
        except (Untestable, ZeroDivisionError):
            continue
    return Variant(
        evidence.protocol, reading, checks, checks_by_number=checks_by_number, control=control
    )


def _run_judge(claim: Claim, evidence: Evidence, number: tuple[float, ...]) -> tuple[Check, ...]:
    checks = tuple(claim.judge_function()(evidence, *number))
    if not checks:
        raise ValueError(f"{claim.id}: the judge checked nothing")
    unknown_parts = {check.part for check in checks if check.has_vote} - set(claim.parts or ("",))
    if unknown_parts:
        raise ValueError(f"{claim.id}: no part {', '.join(sorted(unknown_parts))} in the table")
    return checks
