"""Verdicts as files: JSON with all evidence, CSV with a row per check."""

import hashlib
from dataclasses import asdict
from math import nan
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from sim.base.files import replacing
from sim.base.sealed_json import as_sealed
from sim.claims.judge import judge
from sim.claims.judgement import Judgement, Variant
from sim.claims.table import OWN
from sim.claims.verdict import Check, plan
from sim.dataset.agreement import require_agreement
from sim.dataset.results import load_results
from sim.study.load import load_study

#: What a check has for those who judge and decide, not for readers.
_UNTOLD = {"tested", "short", "coarse"}


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
    return write(judge(found), study.name, folder)


def write(judgements: list[Judgement], study: str, folder: Path) -> Path:
    """Write the verdicts on a study into a folder; return the JSON file.

    That has the checksums of both.
    """
    table = as_table(judgements).to_csv(index=False, float_format="%.6g").encode()
    with replacing(folder / "claims.csv") as temporary:
        temporary.write_bytes(table)
    output = folder / "claims.json"
    with replacing(output) as temporary:
        told = {"claims.csv": hashlib.sha256(table).hexdigest()}
        temporary.write_text(as_sealed(as_mapping(judgements, study) | told), encoding="utf-8")
    return output


def as_mapping(judgements: list[Judgement], study: str) -> dict[str, Any]:
    """Return the verdicts as what the JSON file holds; endless numbers become ``null``."""
    return {
        "study": study,
        "claims": [
            {
                **one.claim.model_dump(exclude={"judge"}),
                "paper": one.claim.paper,
                "system": one.claim.system,
                "verdict": one.verdict,
                "decided_by": one.decided_by,
                "headline": one.headline,
                "protocol_dependent": one.protocol_dependent,
                "reading_dependent": one.reading_dependent,
                "part_verdicts": one.of_parts,
                "by_number": [
                    {
                        "value": value,
                        "verdict": verdict,
                        "checks": [_check(check) for check in _voting(one, value)],
                    }
                    for value, verdict in one.by_number.items()
                ],
                "by_reading": {reading: one.under(reading) for reading in one.readings},
                "variants": [_variant(variant, one) for variant in one.variants],
            }
            for one in judgements
        ],
    }


def _voting(one: Judgement, value: float) -> list[Check]:
    """Return the checks that give the verdict with a value of the number."""
    found = []
    for part in one.claim.parts or ("",):
        variant = one.deciding(one.headline, part)
        checks = variant.others.get(value, ()) if variant else ()
        found += [check for check in checks if check.deciding and check.part == part]
    return found


def _variant(variant: Variant, one: Judgement) -> dict[str, Any]:
    return {
        "protocol": variant.protocol,
        "reading": variant.reading,
        "control": variant.control,
        "verdict": variant.verdict(one.claim.parts),
        "reason": variant.reason,
        **({"unsteady": variant.unsteady} if variant.unsteady else {}),
        "checks": [_check(check) for check in variant.checks],
    }


def _check(check: Check) -> dict[str, Any]:
    held = {name: value for name, value in asdict(check).items() if name not in _UNTOLD}
    shown = {
        "bound": check.bound,
        "p_holds": _told(check, check.holding),
        "p_fails": _told(check, check.failing),
        "tested": check.tested is not None,
        "verdict": check.verdict,
        "plan": plan(check),
    }
    return {
        name: None if isinstance(value, float) and not np.isfinite(value) else value
        for name, value in (held | shown).items()
    }


def _told(check: Check, chance: float) -> float:
    """Return a p-value of a check that decides, not-a-number of others."""
    return chance if check.deciding and check.known else nan


def as_table(judgements: list[Judgement]) -> pd.DataFrame:
    """Return one row per check, and one for each variant that is untestable.

    Verdicts on the claim, on the part that a check is of and by number are those at the headline
    reading; ``verdict`` is that of the variant. The runs behind a check and the first criterion of
    a claim stand in the JSON file alone.
    """
    rows = []
    for one in judgements:
        first = one.claim.first
        for variant in one.variants:
            shared: dict[str, Any] = {
                "claim": one.claim.id,
                "title": one.claim.title,
                "first verdict": first.verdict if first else "",
                "verdict on the claim": one.verdict,
                "verdict by number": _by_number(one),
                "protocol": variant.protocol,
                "reading": variant.reading,
                "verdict": variant.verdict(one.claim.parts),
            }
            if one.claim.paper == OWN:
                shared["steadiness"] = variant.unsteady
            for check in variant.checks:
                values = {
                    name: value
                    for name, value in asdict(check).items()
                    if name not in {"part", "points"} | _UNTOLD
                }
                shown = {
                    "p holds": _told(check, check.holding),
                    "p fails": _told(check, check.failing),
                    "verdict on the check": check.verdict,
                    "what would decide it": plan(check),
                }
                part = {"part": check.part, "verdict on the part": one.of_parts.get(check.part, "")}
                rows.append(shared | part | values | shown)
            if not variant.checks:
                rows.append(shared | {"reason": variant.reason})
    return pd.DataFrame(rows)


def _by_number(one: Judgement) -> str:
    """Return the verdict with each value of the number that the paper does not give, in words."""
    return "; ".join(f"{value:g}: {verdict}" for value, verdict in one.by_number.items())
