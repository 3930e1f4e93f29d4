"""From a dataset to verdicts: every claim under every protocol and reading with runs."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

from sim.claims.claim import OWN, Claim, claims
from sim.claims.evidence import Evidence
from sim.claims.experiments import run_experiment
from sim.claims.judgement import MODEL, PROTOCOLS, Judgement, Variant
from sim.claims.points import Points
from sim.claims.readings import GRID, reading_label, readings_of, readings_with_runs
from sim.claims.verdict import Untestable
from sim.dataset.results import Results


def judge(results: Results) -> list[Judgement]:
    """Judge the claims, of papers and plug-ins, on systems that the study has runs of."""
    systems = set(results.dataset["system"].values)
    evidence_by_system = {system: list(_evidence(results, system)) for system in systems}
    return [
        Judgement(
            claim,
            tuple(_variants(claim, evidence_by_system[claim.system])),
            reading_label(claim.system, readings_of(claim.system).headline),
        )
        for claim in claims()
        if claim.system in systems
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
        for changes in paper_readings.model:
            label, checks = reading_label(claim.system, changes), run_experiment(claim, changes)
            yield Variant(MODEL, label, checks, control=paper_readings.control_reason(changes))
        return
    keys = set()
    for reading, evidence in evidence_by_reading:
        if claim.paper == OWN and not evidence.has_runs(claim.system):
            # A protocol without runs is skipped for a study's own claims.
            continue
        label = reading_label(claim.system, reading)
        variant = _judge_under(claim, evidence, label, paper_readings.control_reason(reading))
        key = variant.protocol, repr(variant.checks)
        if reading == paper_readings.headline or not (variant.reason or key in keys):
            yield variant
        keys.add(key)


def _judge_under(claim: Claim, evidence: Evidence, reading: str, control: str) -> Variant:
    try:
        checks = claim.checks_on(evidence)
    except Untestable as error:
        return Variant(evidence.protocol, reading, reason=str(error), control=control)
    except ZeroDivisionError:
        reason = "a quantity that the claim divides by is exactly zero"
        return Variant(evidence.protocol, reading, reason=reason, control=control)
    checks_by_number = {}
    for value in claim.number.values if claim.number else ():
        try:
            checks_by_number[value] = claim.checks_on(evidence, value)
        except (Untestable, ZeroDivisionError):
            continue
    # Judges of a study's own claims need not test whether flows are steady.
    points = dict.fromkeys(point for check in checks for point in check.points)
    unsteady = evidence.unsteady_note(points) if claim.paper == OWN else ""
    return Variant(evidence.protocol, reading, checks, "", checks_by_number, control, unsteady)
