"""Claims and the evidence for their verdicts as the report shows them."""

import hashlib
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from sim.base.damage import checked_read
from sim.base.sealed_json import read_sealed
from sim.parameters.words import PROTOCOLS
from sim.report.numbers import bounds, measured, strip, threshold, with_chance
from sim.study.catalogue import FIGURES

#: Verdicts from the best, each with its tone and its sign.
VERDICTS = {
    "reproduced": ("good", "✓"),
    "reproduced in part": ("part-good", "◐"),
    "not reproduced": ("bad", "✗"),
    "depends on the reading": ("torn", "⇄"),
    "paper inconsistent": ("torn-paper", "≠"),
    "inconclusive": ("open", "?"),
    "untestable": ("none", "–"),
}

#: What a check may be besides.
REPORTED = {"reported": ("none", "i")}

PAPERS = {"walton": "Walton", "gallas": "Gallas et al."}

#: System whose runs decide the claims of a paper.
SYSTEM = {"walton": "chute", "gallas": "belt"}

_MODEL = "Experiments on the model itself"


def read_claims(path: Path, replaceable: bool = True) -> list[dict[str, Any]]:
    """Return the claims that `sim.claims.written` has written; none where there is no such file.

    A damaged file is set aside if it is ``replaceable``, as the workflow makes it again.

    Raises
    ------
    DamagedError
        When it cannot be read.
    """
    return _read(path, replaceable)["claims"] if path.is_file() else []


def require_table(folder: Path) -> None:
    """Refuse a table of verdicts, ``claims.csv``, that is not the one written with the claims.

    Raises
    ------
    InputError
        Where it, or ``claims.json``, is missing.
    DamagedError
        When it has changed since, or ``claims.json`` cannot be read.
    """
    table = folder / "claims.csv"
    with checked_read(table, "table of verdicts", replaceable=True):
        told = _read(folder / "claims.json")[table.name]
        if hashlib.sha256(table.read_bytes()).hexdigest() != told:
            raise ValueError("the checksum is wrong")


def _read(path: Path, replaceable: bool = True) -> dict[str, Any]:
    with checked_read(path, "table of verdicts", replaceable=replaceable):
        return read_sealed(path.read_text(encoding="utf-8"))


def counts(claims: Sequence[Mapping[str, Any]]) -> dict[str, dict[str, int]]:
    """Return how many claims of each paper have each verdict, by the short name of the paper."""
    return {
        paper: {
            verdict: sum(one["paper"] == paper and one["verdict"] == verdict for one in claims)
            for verdict in VERDICTS
        }
        for paper in PAPERS
        if any(one["paper"] == paper for one in claims)
    }


def judged_by_runs(claims: Iterable[Mapping[str, Any]]) -> bool:
    """Return whether there is a claim, not on the contact model alone, that was tested."""
    return any(one["kind"] != "model" and one["verdict"] != "untestable" for one in claims)


def engine_checks(claims: Iterable[Mapping[str, Any]]) -> dict[str, int]:
    """Return how many claims on the contact law alone were ``tested``, and how many ``held``."""
    checks = [one for one in claims if one["kind"] == "model" and one["verdict"] != "untestable"]
    held = sum(one["verdict"] == "reproduced" for one in checks)
    return {"tested": len(checks), "held": held}


def claim_rows(
    claims: Iterable[Mapping[str, Any]],
    runs: Iterable[Mapping[str, Any]],
    drawn: Iterable[str],
) -> list[dict[str, Any]]:
    """Return one row per claim with all that its evidence needs to be shown.

    Parameters
    ----------
    claims : iterable of mapping
        Claims, as `read_claims` returns them.
    runs : iterable of mapping
        The table of runs, as `sim.report.runs.run_rows` returns it.
    drawn : iterable of str
        Names of the figures in the report.
    """
    drawn = set(drawn)
    rows = {run["point"]: run for run in runs}
    numbers = {point: run["number"] for point, run in rows.items()}
    return [
        {
            **claim,
            "author": PAPERS.get(claim["paper"], ""),
            "figures": [
                {"name": name, "title": FIGURES[name].paper, "drawn": name in drawn}
                for name in claim["figures"]
            ],
            "by_protocol": {
                one["protocol"]: one["verdict"]
                for one in claim["variants"]
                if one["reading"] == claim["headline"]
            },
            "depends": [what for what in ("protocol", "reading") if claim[f"{what}_dependent"]],
            "by_number": [
                {**one, "checks": [_check(check, numbers) for check in one["checks"]]}
                for one in claim["by_number"]
            ],
            "variants": [_variant(one, claim, numbers) for one in claim["variants"]],
            "cost": _cost(claim, rows),
        }
        for claim in claims
    ]


def _cost(
    claim: Mapping[str, Any], runs: Mapping[str, Mapping[str, Any]]
) -> dict[str, float] | None:
    """Return how many points the checks under the headline reading rest on, and their core time."""
    usual = [one for one in claim["variants"] if one["reading"] == claim["headline"]]
    points = {point for one in usual for check in one["checks"] for point in check["points"]}
    known = [runs[point]["wall_time"] for point in points if point in runs]
    return {"points": len(known), "seconds": float(sum(known))} if known else None


def _variant(
    variant: Mapping[str, Any], claim: Mapping[str, Any], numbers: Mapping[str, int]
) -> dict[str, Any]:
    system = claim.get("system") or SYSTEM[claim["paper"]]
    words = PROTOCOLS[system].get(variant["protocol"], _MODEL).capitalize()
    usual = variant["reading"] == claim["headline"]
    named = "" if variant["reading"] == "default" else f", {variant['reading']}"
    return {
        **variant,
        "title": words + named,
        "usual": usual,
        "unsteady": variant.get("unsteady", ""),
        "checks": [_check(check, numbers) for check in variant["checks"]],
    }


def _check(check: Mapping[str, Any], numbers: Mapping[str, int]) -> dict[str, Any]:
    return {
        **check,
        "measured": _measured(check),
        "bounds": bounds(check),
        "threshold": threshold(check["low"], check["high"]),
        "strip": None if check["verdict"] == "reported" else strip(check),
        "runs": [(point, numbers.get(point)) for point in check["points"]],
    }


def _measured(check: Mapping[str, Any]) -> str:
    """Write what a check measured: with its interval, or with the p-value of its test."""
    if check["tested"]:
        return with_chance(check["value"], check["p_holds"])
    return measured(check["value"], check["half_width"])
