"""Rows of the report for claims and the evidence of their verdicts."""

import hashlib
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from sim.base.seals import checked_read, parse_sealed_json
from sim.parameters.words import PROTOCOLS
from sim.report.numbers import bounds, strip, threshold, value_with_interval, value_with_p
from sim.study.catalogue import FIGURES
from sim.study.papers import papers

#: Verdicts, best first, each with its tone and its sign.
VERDICTS = {
    "reproduced": ("good", "✓"),
    "reproduced in part": ("part-good", "◐"),
    "not reproduced": ("bad", "✗"),
    "depends on the reading": ("torn", "⇄"),
    "depends on the protocol": ("torn", "⇅"),
    "paper inconsistent": ("torn-paper", "≠"),
    "inconclusive": ("open", "?"),
    "untestable": ("none", "–"),
}

#: The further outcome of a check that does not vote.
REPORTED = {"reported": ("none", "i")}

_MODEL = "Experiments on the model itself"


def read_claims(path: Path, replaceable: bool = True) -> list[dict[str, Any]]:
    """Return the claims that `sim.claims.verdict_files` has written; empty without a file.

    A damaged file is set aside if it is ``replaceable``: the workflow can make it again.

    Raises
    ------
    DamagedError
        When it cannot be read.
    """
    return _read(path, replaceable)["claims"] if path.is_file() else []


def require_table(folder: Path) -> None:
    """Raise an error unless the tables of checks and of verdicts were written with the claims.

    Raises
    ------
    InputError
        Where one of them, or ``claims.json``, is missing.
    DamagedError
        When a table has changed since, or ``claims.json`` cannot be read.
    """
    for name in ("claims.csv", "verdicts.csv"):
        table = folder / name
        with checked_read(table, "table of verdicts", replaceable=True):
            recorded = _read(folder / "claims.json")[name]
            if hashlib.sha256(table.read_bytes()).hexdigest() != recorded:
                raise ValueError("the checksum is wrong")


def _read(path: Path, replaceable: bool = True) -> dict[str, Any]:
    with checked_read(path, "table of verdicts", replaceable=replaceable):
        return parse_sealed_json(path.read_text(encoding="utf-8"))


def count_verdicts(claims: Sequence[Mapping[str, Any]]) -> dict[str, dict[str, int]]:
    """Return the number of claims by the short name of the paper and by verdict."""
    return {
        paper: {
            verdict: sum(
                claim["paper"] == paper and claim["verdict"] == verdict for claim in claims
            )
            for verdict in VERDICTS
        }
        for paper in papers()
        if any(claim["paper"] == paper for claim in claims)
    }


def has_tested_claims(claims: Iterable[Mapping[str, Any]]) -> bool:
    """Return whether any claim was tested by runs; those on the contact model do not count."""
    return any(claim["kind"] != "model" and claim["verdict"] != "untestable" for claim in claims)


def engine_checks(claims: Iterable[Mapping[str, Any]]) -> dict[str, int]:
    """Return how many claims on the contact law alone were ``tested`` and ``reproduced``."""
    checks = [
        claim for claim in claims if claim["kind"] == "model" and claim["verdict"] != "untestable"
    ]
    reproduced = sum(claim["verdict"] == "reproduced" for claim in checks)
    return {"tested": len(checks), "reproduced": reproduced}


def claim_rows(
    claims: Iterable[Mapping[str, Any]],
    runs: Iterable[Mapping[str, Any]],
    figure_names: Iterable[str],
) -> list[dict[str, Any]]:
    """Return one row per claim with everything that the templates show of its evidence.

    Parameters
    ----------
    claims : iterable of mapping
        Claims, as `read_claims` returns them.
    runs : iterable of mapping
        The table of runs, as `sim.report.runs.run_rows` returns it.
    figure_names : iterable of str
        Names of the figures in the report.
    """
    figure_names = set(figure_names)
    authors = {name: paper.author for name, paper in papers().items()}
    rows = {run["point"]: run for run in runs}
    numbers = {point: run["number"] for point, run in rows.items()}
    return [
        {
            **claim,
            "author": authors.get(claim["paper"], ""),
            "figures": [
                {"name": name, "title": FIGURES[name].paper, "drawn": name in figure_names}
                for name in claim["figures"]
            ],
            "by_protocol": {
                variant["protocol"]: variant["verdict"]
                for variant in claim["variants"]
                if variant["reading"] == claim["headline"]
            },
            "depends": [name for name in ("protocol", "reading") if claim[f"{name}_dependent"]],
            "by_number": [
                {**entry, "checks": [_check(check, numbers) for check in entry["checks"]]}
                for entry in claim["by_number"]
            ],
            "variants": [_variant(variant, claim, numbers) for variant in claim["variants"]],
            "cost": _cost(claim, rows),
        }
        for claim in claims
    ]


def _cost(
    claim: Mapping[str, Any], runs: Mapping[str, Mapping[str, Any]]
) -> dict[str, float] | None:
    """Return number and core time (s) of the points behind the checks of the headline reading."""
    headline_variants = [
        variant for variant in claim["variants"] if variant["reading"] == claim["headline"]
    ]
    points = {
        point
        for variant in headline_variants
        for check in variant["checks"]
        for point in check["points"]
    }
    seconds = [runs[point]["wall_time"] for point in points if point in runs]
    return {"points": len(seconds), "seconds": float(sum(seconds))} if seconds else None


def _variant(
    variant: Mapping[str, Any], claim: Mapping[str, Any], numbers: Mapping[str, int]
) -> dict[str, Any]:
    system = claim.get("system") or papers()[claim["paper"]].system
    title = PROTOCOLS[system].get(variant["protocol"], _MODEL).capitalize()
    is_headline = variant["reading"] == claim["headline"]
    reading = "" if variant["reading"] == "default" else f", {variant['reading']}"
    return {
        **variant,
        "title": title + reading,
        "usual": is_headline,
        "unsteady": variant.get("unsteady", ""),
        "checks": [_check(check, numbers) for check in variant["checks"]],
    }


def _check(check: Mapping[str, Any], numbers: Mapping[str, int]) -> dict[str, Any]:
    return {
        **check,
        "measured": _measured_text(check),
        "bounds": bounds(check),
        "threshold": threshold(check["low"], check["high"]),
        "strip": None if check["verdict"] == "reported" else strip(check),
        "runs": [(point, numbers.get(point)) for point in check["points"]],
    }


def _measured_text(check: Mapping[str, Any]) -> str:
    """Write the measured value of a check with its interval, or with the p-value of its test."""
    if check["tested"]:
        return value_with_p(check["value"], check["p_holds"])
    return value_with_interval(check["value"], check["half_width"])
