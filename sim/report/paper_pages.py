"""Pages of docs/ on both papers, made of what is published: results in words, and all verdicts.

``python -m sim.report.paper_pages results`` and ``verdicts`` write them to the standard output.
"""

import json
import sys
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from sim.report.claims import VERDICTS, count_verdicts, read_claims
from sim.report.numbers import template, value_with_interval
from sim.report.publish import PUBLISHED
from sim.study.papers import papers

_HEAD = """\
# Verdicts, first and now

Each claim of both papers with the verdict that the first criterion gave on the runs published
first, the verdict that the present criterion gives on those published now, and why the two differ
or why the criterion was restated. The present ones are of a second campaign on **fresh seeds**, run
after criteria, rules and readings had been restated, but for one rule that was made when it was
seen that no flow of the softest spheres lasts at depth 40: those of 1,000 N/m are judged there
(W14, a part of W15, W17; W21 and W22 then compare depth 20 alone).
Sentences, criteria and evidence: the reports
([Walton](../results/published/paper_walton/report.html),
[Gallas](../results/published/paper_gallas/report.html)).

`python -m sim.report.paper_pages verdicts > docs/verdicts.md` makes this page from both
`claims.json`.
"""


def main(page: str, published: Path = PUBLISHED) -> str:
    """Return a page, ``results`` or ``verdicts``, of the published studies of both papers."""
    folders = {paper: published / f"paper_{paper}" for paper in papers()}
    claims = [
        claim
        for folder in folders.values()
        for claim in read_claims(folder / "claims.json", replaceable=False)
    ]
    if page == "verdicts":
        return verdicts_page(claims)
    runs = {
        paper: json.loads((folder / "provenance.json").read_text(encoding="utf-8"))
        for paper, folder in folders.items()
    }
    return results_page({claim["id"]: claim for claim in claims}, runs)


def results_page(
    claims: Mapping[str, Mapping[str, Any]], runs: Mapping[str, Mapping[str, Any]]
) -> str:
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
        template("results.md.j2").render(
            claim=partial(_claim, claims),
            number=partial(_number, claims),
            counts=count_verdicts(list(claims.values())),
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


def verdicts_page(claims: Sequence[Mapping[str, Any]]) -> str:
    """Return the page as Markdown text.

    Parameters
    ----------
    claims : sequence of mapping
        The claims of both papers, as `sim.report.claims.read_claims` returns them.
    """
    parts = [_HEAD, _totals(claims)]
    for name, paper in papers().items():
        rows = [_row(claim) for claim in claims if claim["paper"] == name]
        heads = "| claim | first | now | by number of ours | why |\n| --- | --- | --- | --- | --- |"
        parts.append("\n".join([f"## {paper.author}\n", heads, *rows, ""]))
    return "\n".join(parts)


def _totals(claims: Sequence[Mapping[str, Any]]) -> str:
    """Return a table with the number of claims by verdict and paper, first and now."""
    now = count_verdicts(claims)
    rows = [
        f"| {verdict} | "
        + " | ".join(
            f"{sum(one['paper'] == paper and one['first']['verdict'] == verdict for one in claims)}"
            f" | {now[paper][verdict]}"
            for paper in papers()
        )
        + " |"
        for verdict in VERDICTS
    ]
    heads = " | ".join(f"{paper.author}, first | now" for paper in papers().values())
    return "\n".join(
        [f"| verdict | {heads} |", "| --- |" + " --- |" * 2 * len(papers()), *rows, ""]
    )


def _row(claim: Mapping[str, Any]) -> str:
    first, now = claim["first"], claim["verdict"]
    has_changed = first["verdict"] != now
    verdict = f"**{now}**" if has_changed else now
    if claim["part_verdicts"]:
        verdict += ": " + ", ".join(
            f"{part} {part_verdict}" for part, part_verdict in claim["part_verdicts"].items()
        )
    if claim["protocol_dependent"]:
        verdict += "; depends on the protocol"
    numbers = ", ".join(
        f"{number['value']:g}: {number['verdict']}" for number in claim["by_number"]
    )
    title = f"{claim['id']} {claim['title']}"
    return f"| {title} | {first['verdict']} | {verdict} | {numbers} | {first['why']} |"


if __name__ == "__main__":
    sys.stdout.write(main(sys.argv[1]))
