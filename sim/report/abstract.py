"""The page of docs/ that sums up the results of both papers, with the published numbers."""

import json
import sys
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import Any

from sim.report.claims import VERDICTS, count_verdicts, read_claims
from sim.report.numbers import template, value_with_interval
from sim.report.publish import PUBLISHED
from sim.report.verdict_table import changes
from sim.study.papers import papers


def page(claims: Mapping[str, Mapping[str, Any]], runs: Mapping[str, Mapping[str, Any]]) -> str:
    """Return the page as Markdown text.

    Parameters
    ----------
    claims : mapping
        The claims of both papers, as `sim.report.claims.read_claims` returns them, by id.
    runs : mapping
        ``provenance.json`` of the published studies, by the short name of the paper.

    Raises
    ------
    ValueError
        When a claim has another verdict than its sentence assumes, or a number belongs to no check.
        The template must then be rewritten.
    """
    return (
        template("abstract.md.j2").render(
            claim=partial(_claim, claims),
            number=partial(_number, claims),
            counts=count_verdicts(list(claims.values())),
            changes=changes(list(claims.values())),
            statements=len(claims),
            papers={name: paper.author for name, paper in papers().items()},
            verdicts=VERDICTS,
            runs=runs,
        )
        + "\n"
    )


def _claim(claims: Mapping[str, Mapping[str, Any]], name: str, verdict: str) -> str:
    """Return the id of a claim, after a check that it has the verdict that a sentence assumes."""
    current = claims[name]["verdict"]
    if current != verdict:
        raise ValueError(
            f"{name} is {current!r} and no more {verdict!r}: rewrite what is told of it"
        )
    return name


def _number(
    claims: Mapping[str, Mapping[str, Any]], name: str, what: str, interval: bool = True
) -> str:
    """Return the measured value of a check under the headline reading and the deciding protocol.

    ``what`` names the check. The value has the half width of its 95 % interval, or three digits
    where ``interval`` is false or there is none.
    """
    claim = claims[name]
    checks = [
        check
        for variant in claim["variants"]
        if variant["reading"] == claim["headline"] and not variant["control"]
        if variant["protocol"] in claim["decided_by"].split(", ")
        for check in variant["checks"]
        if check["what"] == what
    ]
    if len(checks) != 1:
        raise ValueError(f"{name} has {len(checks)} checks {what!r} instead of one")
    value, half_width = checks[0]["value"], checks[0]["half_width"]
    text = value_with_interval(value, half_width) if interval and half_width else f"{value:.3g}"
    return text.replace("-", "\N{MINUS SIGN}")


def main(published: Path = PUBLISHED) -> str:
    """Return the page of the published studies of both papers."""
    folders = {paper: published / f"paper_{paper}" for paper in papers()}
    claims = {
        claim["id"]: claim
        for folder in folders.values()
        for claim in read_claims(folder / "claims.json", replaceable=False)
    }
    runs = {
        paper: json.loads((folder / "provenance.json").read_text(encoding="utf-8"))
        for paper, folder in folders.items()
    }
    return page(claims, runs)


if __name__ == "__main__":
    sys.stdout.write(main())
