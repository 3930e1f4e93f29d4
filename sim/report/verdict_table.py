"""The page of docs/ with all claims: first verdict, present verdict, and reason of the change."""

import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from sim.report.claims import VERDICTS, count_verdicts, read_claims
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

`python -m sim.report.verdict_table > docs/verdicts.md` makes this page from `claims.json` of both.
"""


def page(claims: Sequence[Mapping[str, Any]]) -> str:
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


def main(published: Path = PUBLISHED) -> str:
    """Return the page of the published studies of both papers."""
    files = (published / f"paper_{paper}" / "claims.json" for paper in papers())
    claim_lists = [read_claims(file, replaceable=False) for file in files]
    return page([claim for claims in claim_lists for claim in claims])


if __name__ == "__main__":
    sys.stdout.write(main())
