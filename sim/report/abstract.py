"""What both papers gave on one page, as a page of docs/: its numbers are those published."""

import json
import sys
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import Any

from sim.report.claims import PAPERS, VERDICTS, counts, read_claims
from sim.report.numbers import measured
from sim.report.publish import PUBLISHED
from sim.report.templating import template


def page(claims: Mapping[str, Mapping[str, Any]], runs: Mapping[str, Mapping[str, Any]]) -> str:
    """Return the page as Markdown text.

    Parameters
    ----------
    claims : mapping
        The claims of both papers, as `sim.report.claims.read_claims` returns them, by id.
    runs : mapping
        ``provenance.json`` of what is published, by the short name of the paper.

    Raises
    ------
    ValueError
        When a claim has another verdict than the sentence about it is written for, or a number is
        of no check: the template is then to be read and written anew.
    """
    return (
        template("abstract.md.j2").render(
            claim=partial(_claim, claims),
            number=partial(_number, claims),
            counts=counts(list(claims.values())),
            statements=len(claims),
            papers=PAPERS,
            verdicts=VERDICTS,
            runs=runs,
        )
        + "\n"
    )


def _claim(claims: Mapping[str, Mapping[str, Any]], name: str, verdict: str) -> str:
    """Return the id of a claim that a sentence rests on, if it has the verdict told there."""
    found = claims[name]["verdict"]
    if found != verdict:
        raise ValueError(f"{name} is {found!r} and no more {verdict!r}: rewrite what is told of it")
    return name


def _number(
    claims: Mapping[str, Mapping[str, Any]], name: str, what: str, interval: bool = True
) -> str:
    """Return what a check of a claim measured, under its headline's reading and protocol.

    It comes with the half width of its 95 % interval, where it has one, or to three digits.
    """
    claim = claims[name]
    found = [
        check
        for variant in claim["variants"]
        if variant["reading"] == claim["headline"] and not variant["control"]
        if variant["protocol"] in claim["decided_by"].split(", ")
        for check in variant["checks"]
        if check["what"] == what
    ]
    if len(found) != 1:
        raise ValueError(f"{name} has {len(found)} checks {what!r} instead of one")
    value, half_width = found[0]["value"], found[0]["half_width"]
    told = measured(value, half_width) if interval and half_width else f"{value:.3g}"
    return told.replace("-", "\N{MINUS SIGN}")


def main(published: Path = PUBLISHED) -> str:
    """Return the page from what is published of both papers."""
    folders = {paper: published / f"paper_{paper}" for paper in PAPERS}
    claims = {
        one["id"]: one
        for folder in folders.values()
        for one in read_claims(folder / "claims.json", replaceable=False)
    }
    runs = {
        paper: json.loads((folder / "provenance.json").read_text(encoding="utf-8"))
        for paper, folder in folders.items()
    }
    return page(claims, runs)


if __name__ == "__main__":
    sys.stdout.write(main())
