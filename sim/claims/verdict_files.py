"""Verdicts as files: JSON with all evidence, a table of checks, and one of verdicts by reading."""

import hashlib
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import fields, replace
from math import nan
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from sim.base.files import atomic_write
from sim.base.seals import to_sealed_json
from sim.claims.claim import OWN
from sim.claims.judge import judge
from sim.claims.judgement import Judgement, Variant
from sim.claims.verdict import UNTESTABLE, Check, plan
from sim.dataset.results import load_current
from sim.study.load import load_study

#: Fields of a check that judges and `decide` use and the files do not hold.
_INTERNAL_FIELDS = {"tested", "short", "coarse", "open_points"}


def build(study_path: str | Path, results: str | Path = "results") -> Path:
    """Write ``claims.json``, ``claims.csv`` and ``verdicts.csv`` into ``results/<study>``.

    They are made from the dataset of the study. Returns the path of the JSON file. Each file
    appears complete or not at all, the JSON file last. Raises `InputError` when the dataset is
    missing or damaged, naming it, or the study has changed since the dataset was made.
    """
    study = load_study(study_path, results)
    folder = Path(results) / study.name
    return write(judge(load_current(study, folder), study.paper), study.name, folder)


def write(judgements: list[Judgement], study: str, folder: Path) -> Path:
    """Write the verdicts on a study into a folder; return the JSON file.

    The JSON file holds the checksums of the tables.
    """
    checksums = {}
    for name, rows in ("claims", as_table(judgements)), ("verdicts", by_variant(judgements)):
        table = rows.to_csv(index=False, float_format="%.6g").encode()
        with atomic_write(folder / f"{name}.csv") as temporary:
            temporary.write_bytes(table)
        checksums[f"{name}.csv"] = hashlib.sha256(table).hexdigest()
    output = folder / "claims.json"
    text = to_sealed_json(_name_points_once(as_mapping(judgements, study)) | checksums)
    with atomic_write(output) as temporary:
        temporary.write_text(text, encoding="utf-8")
    return output


def as_mapping(judgements: list[Judgement], study: str) -> dict[str, Any]:
    """Return the content of the JSON file; infinite numbers and NaN become ``null``."""
    return {
        "study": study,
        "claims": [
            {
                **judgement.claim.model_dump() | judgement.claim.texts(),
                "verdict": judgement.verdict,
                "decided_by": judgement.decided_by,
                "headings": judgement.headings,
                "protocol_dependent": judgement.protocol_dependent,
                "reading_dependent": judgement.reading_dependent,
                "part_verdicts": judgement.part_verdicts,
                "by_number": [
                    {
                        "value": value,
                        "verdict": verdict,
                        # Their runs are those of the headline value.
                        "checks": [
                            _check(replace(check, points=()))
                            for check in _voting_checks(judgement, value)
                        ],
                    }
                    for value, verdict in judgement.by_number.items()
                ],
                "by_reading": {
                    reading: judgement.verdict_under(reading) for reading in judgement.readings
                },
                "variants": [_variant(variant, judgement) for variant in judgement.variants],
            }
            for judgement in judgements
        ],
    }


def _name_points_once(content: dict[str, Any]) -> dict[str, Any]:
    """Return the content with the ids of ``points``, and their places there in each check."""
    places: dict[str, int] = {}
    for check in checks_of(content["claims"]):
        check["points"] = [places.setdefault(point, len(places)) for point in check["points"]]
    return content | {"points": list(places)}


def checks_of(claims: Iterable[Mapping[str, Any]]) -> Iterator[dict[str, Any]]:
    """Return the checks of all variants of claims of the JSON file."""
    return (check for claim in claims for one in claim["variants"] for check in one["checks"])


def _voting_checks(judgement: Judgement, value: float) -> list[Check]:
    voting = []
    for part in judgement.claim.parts or ("",):
        variant = judgement.deciding_variant(judgement.heading(part), part)
        checks = variant.checks_by_number.get(value, ()) if variant else ()
        voting += [check for check in checks if check.has_vote and check.part == part]
    return voting


def _variant(variant: Variant, judgement: Judgement) -> dict[str, Any]:
    return {
        "protocol": variant.protocol,
        "reading": variant.reading,
        "control": variant.control,
        "verdict": variant.verdict(judgement.claim.parts),
        "reason": variant.reason,
        **({"unsteady": variant.unsteady} if variant.unsteady else {}),
        # What is reported beside the votes under other readings is in the table alone.
        "checks": [
            _check(check)
            for check in variant.checks
            if variant.reading in judgement.headings or check.has_vote
        ],
    }


def _check(check: Check) -> dict[str, Any]:
    derived = {
        "bound": check.bound,
        **dict(zip(("p_holds", "p_fails"), _p_of_vote(check), strict=True)),
        "tested": check.tested is not None,
        "verdict": check.verdict,
        "plan": plan(check),
    }
    told = _fields(check, *(() if check.text else ("text",))) | derived
    return {name: _plain(value) for name, value in told.items()}


def _fields(check: Check, *left_out: str) -> dict[str, Any]:
    names = [one.name for one in fields(check) if one.name not in {*left_out, *_INTERNAL_FIELDS}]
    return {name: getattr(check, name) for name in names}


def _plain(value: Any) -> Any:
    """Return a value for JSON: nine digits of a number, none of one that is not finite."""
    if not isinstance(value, float):
        return value
    return float(f"{value:.9g}") if np.isfinite(value) else None


def _p_of_vote(check: Check) -> tuple[float, float]:
    decides = check.has_vote and check.can_decide
    return (check.p_holds, check.p_fails) if decides else (nan, nan)


def as_table(judgements: list[Judgement]) -> pd.DataFrame:
    """Return a table with a row per check, and one row per untestable variant.

    Verdicts on the claim, on the part of a check and by number are those at the headline reading;
    ``verdict`` is that of the variant. The runs behind a check and the first criterion of a claim
    are in the JSON file alone.
    """
    rows: list[dict[str, Any]] = []
    for judgement in judgements:
        claim, parts = judgement.claim, judgement.part_verdicts
        by_number = (f"{value:g}: {verdict}" for value, verdict in judgement.by_number.items())
        about = {
            "claim": claim.id,
            "title": claim.title,
            "first verdict": claim.first.verdict if claim.first else "",
            "verdict on the claim": judgement.verdict,
            "verdict by number": "; ".join(by_number),
        }
        for variant in judgement.variants:
            shared = about | {
                "protocol": variant.protocol,
                "reading": variant.reading,
                "verdict": variant.verdict(claim.parts),
                **({"steadiness": variant.unsteady} if claim.paper == OWN else {}),
            }
            checks = [shared | _row(check, parts) for check in variant.checks]
            rows += checks or [shared | {"reason": variant.reason}]
    return pd.DataFrame(rows)


def _row(check: Check, part_verdicts: dict[str, str]) -> dict[str, Any]:
    p_holds, p_fails = _p_of_vote(check)
    return {
        "part": check.part,
        "verdict on the part": part_verdicts.get(check.part, ""),
        **_fields(check, "part", "points"),
        "p holds": p_holds,
        "p fails": p_fails,
        "verdict on the check": check.verdict,
        "what would decide it": plan(check),
    }


def by_variant(judgements: list[Judgement]) -> pd.DataFrame:
    """Return the verdicts by protocol and reading, a row per claim and per part of a claim.

    ``verdict`` is the headline verdict. Each further column is one protocol under one reading; a
    cell is empty where that has no runs of its own for the claim.
    """
    rows = []
    for judgement in judgements:
        claim, part_verdicts = judgement.claim, judgement.part_verdicts
        for part in ("", *claim.parts):
            row = {
                "claim": claim.id,
                "part": part,
                "says": claim.parts[part] if part else claim.title,
                "verdict": part_verdicts[part] if part else judgement.verdict,
                "condition": claim.condition,
                "instead": "" if part else claim.instead,
            }
            for variant in judgement.variants:
                verdict = variant.verdict((part,) if part else claim.parts)
                if verdict != UNTESTABLE:
                    row[f"{variant.protocol}, {variant.reading}"] = verdict
            rows.append(row)
    return pd.DataFrame(rows)
