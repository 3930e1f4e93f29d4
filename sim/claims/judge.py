"""From a dataset to verdicts: every claim under every protocol and reading that was run."""

import json
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from sim.base.files import replacing
from sim.claims.evidence import Evidence
from sim.claims.experiments import experiment
from sim.claims.points import Points
from sim.claims.table import Claim, claims
from sim.claims.verdict import (
    INCONCLUSIVE,
    NOT_REPRODUCED,
    REPRODUCED,
    UNTESTABLE,
    Check,
    Untestable,
    together,
)
from sim.dataset.agreement import require_agreement
from sim.dataset.results import Results, load_results
from sim.parameters import SYSTEMS, roles
from sim.parameters.wording import setting
from sim.study.load import load_study

#: Protocols in the order in which a decided one sets the verdict on a claim.
PROTOCOLS = ("converged", "published")

#: What stands for the protocol of claims that need no runs, and for the papers' own reading.
MODEL, DEFAULT = "model", "default"

#: Readings of the contact law under which claims on the model are judged.
MODEL_READINGS: tuple[dict[str, Any], ...] = (
    {},
    {"overlap_memory": "shrink"},
    {"overlap_memory": "reset"},
    {"friction_cap": "after"},
)


@dataclass(frozen=True)
class Variant:
    """The verdict on a claim under one protocol and one reading.

    ``reason`` says why it is untestable; ``checks`` is then empty.
    """

    protocol: str
    reading: str
    checks: tuple[Check, ...] = ()
    reason: str = ""

    @property
    def verdict(self) -> str:
        """That of all checks together."""
        return UNTESTABLE if self.reason else together(self.checks)


@dataclass(frozen=True)
class Judgement:
    """A claim with its verdicts, those of the default reading first."""

    claim: Claim
    variants: tuple[Variant, ...]

    @property
    def verdict(self) -> str:
        """The first decided verdict at the default reading; else inconclusive or untestable."""
        if self._decided:
            return self._decided[0].verdict
        found = [one.verdict for one in self._default]
        return INCONCLUSIVE if INCONCLUSIVE in found else UNTESTABLE

    @property
    def decided_by(self) -> str:
        """Protocol whose runs give the verdict, empty where none decides."""
        return self._decided[0].protocol if self._decided else ""

    @property
    def _default(self) -> list[Variant]:
        return [one for one in self.variants if one.reading == DEFAULT]

    @property
    def _decided(self) -> list[Variant]:
        return [one for one in self._default if one.verdict in (REPRODUCED, NOT_REPRODUCED)]

    @property
    def protocol_dependent(self) -> bool:
        """Whether two protocols decide it differently at the default reading."""
        return _contradicted(self._default)

    @property
    def reading_dependent(self) -> bool:
        """Whether two readings decide it differently under one protocol."""
        return any(
            _contradicted(one for one in self.variants if one.protocol == protocol)
            for protocol in (*PROTOCOLS, MODEL)
        )


def _contradicted(variants: Iterable[Variant]) -> bool:
    return {one.verdict for one in variants} >= {REPRODUCED, NOT_REPRODUCED}


def build(study_path: str | Path, results: str | Path = "results") -> Path:
    """Write ``results/<study>/claims.json`` and ``claims.csv`` from the dataset of a study.

    Returns
    -------
    Path
        The JSON file. Both appear complete or not at all.

    Raises
    ------
    InputError
        When the dataset is missing or damaged, naming it, or the study has changed since it was
        made.
    """
    study = load_study(study_path, results)
    folder = Path(results) / study.name
    found = load_results(folder / "dataset.nc")
    require_agreement(study, found, folder / "dataset.nc")
    judgements = judge(found)
    with replacing(folder / "claims.csv") as temporary:
        as_table(judgements).to_csv(temporary, index=False, float_format="%.6g")
    output = folder / "claims.json"
    with replacing(output) as temporary:
        mapping = as_mapping(judgements, study.name)
        text = json.dumps(mapping, indent=1, ensure_ascii=False, allow_nan=False)
        temporary.write_text(text + "\n", encoding="utf-8")
    return output


def judge(results: Results) -> list[Judgement]:
    """Judge the claims of the papers whose systems a study has runs of."""
    systems = set(results.dataset["system"].values)
    found = [claim for claim in claims() if claim.system in systems]
    every = {system: list(_evidence(results, system)) for system in systems}
    return [Judgement(claim, tuple(_variants(claim, every[claim.system]))) for claim in found]


def _evidence(results: Results, system: str) -> Iterator[tuple[str, Evidence]]:
    """Yield what each protocol and reading offers, the reading in words, the default one first."""
    points = Points(results)
    for reading in ({}, *readings(results, system)):
        for protocol in PROTOCOLS:
            yield _in_words(system, reading), Evidence(results, protocol, reading, points)


def _in_words(system: str, reading: Mapping[str, Any]) -> str:
    return "; ".join(setting(system, name, value) for name, value in reading.items()) or DEFAULT


def _variants(claim: Claim, every: list[tuple[str, Evidence]]) -> Iterator[Variant]:
    """Yield the verdicts at the default reading, then those of readings that have the runs."""
    if claim.kind == "model":
        for changes in MODEL_READINGS:
            words = _in_words(claim.system, changes)
            yield Variant(MODEL, words, experiment(claim, changes))
        return
    for reading, evidence in every:
        variant = _judged(claim, evidence, reading)
        if reading == DEFAULT or not variant.reason:
            yield variant


def _judged(claim: Claim, evidence: Evidence, reading: str) -> Variant:
    try:
        checks = tuple(claim.judging()(evidence))
    except Untestable as error:
        return Variant(evidence.protocol, reading, reason=str(error))
    except ZeroDivisionError:
        reason = "a quantity that the claim divides by is exactly zero"
        return Variant(evidence.protocol, reading, reason=reason)
    if not checks:
        raise ValueError(f"{claim.id}: the judge checked nothing")
    return Variant(evidence.protocol, reading, checks)


def readings(results: Results, system: str) -> list[dict[str, Any]]:
    """Return the readings other than the default that some points of a system have."""
    model = SYSTEMS[system]
    usual = model()
    points = results.dataset.isel(point=np.flatnonzero(results.dataset["system"] == system))
    columns = {name: points[name].values.tolist() for name in roles.readings(model)}
    found = {}
    for values in zip(*columns.values(), strict=True):
        named = zip(columns, values, strict=True)
        unusual = {name: value for name, value in named if value != getattr(usual, name)}
        if unusual:
            found[tuple(unusual.items())] = unusual
    return list(found.values())


def as_mapping(judgements: list[Judgement], study: str) -> dict[str, Any]:
    """Return the verdicts as what the JSON file holds; endless numbers become ``null``."""
    return {
        "study": study,
        "claims": [
            {
                **one.claim.model_dump(exclude={"judge"}),
                "paper": one.claim.paper,
                "verdict": one.verdict,
                "decided_by": one.decided_by,
                "protocol_dependent": one.protocol_dependent,
                "reading_dependent": one.reading_dependent,
                "variants": [
                    {
                        "protocol": variant.protocol,
                        "reading": variant.reading,
                        "verdict": variant.verdict,
                        "reason": variant.reason,
                        "checks": [_check(check) for check in variant.checks],
                    }
                    for variant in one.variants
                ],
            }
            for one in judgements
        ],
    }


def _check(check: Check) -> dict[str, Any]:
    return {
        name: None if isinstance(value, float) and not np.isfinite(value) else value
        for name, value in (asdict(check) | {"verdict": check.verdict}).items()
    }


def as_table(judgements: list[Judgement]) -> pd.DataFrame:
    """Return one row per check, and one for each variant that is untestable."""
    rows = []
    for one in judgements:
        for variant in one.variants:
            shared: dict[str, Any] = {
                "claim": one.claim.id,
                "title": one.claim.title,
                "verdict on the claim": one.verdict,
                "protocol": variant.protocol,
                "reading": variant.reading,
                "verdict": variant.verdict,
            }
            for check in variant.checks:
                values = {name: value for name, value in asdict(check).items() if name != "points"}
                shown = {"points": " ".join(check.points), "verdict on the check": check.verdict}
                rows.append(shared | values | shown)
            if not variant.checks:
                rows.append(shared | {"reason": variant.reason})
    return pd.DataFrame(rows)
