"""All claims with their first verdict, the present one and why it changed, as a page of docs/."""

import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from sim.report.claims import PAPERS, VERDICTS, counts, read_claims
from sim.report.publish import PUBLISHED

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
    for paper, author in PAPERS.items():
        rows = [_row(one) for one in claims if one["paper"] == paper]
        heads = "| claim | first | now | by number of ours | why |\n| --- | --- | --- | --- | --- |"
        parts.append("\n".join([f"## {author}\n", heads, *rows, ""]))
    return "\n".join(parts)


def _totals(claims: Sequence[Mapping[str, Any]]) -> str:
    """Return how many claims have each verdict, first and now."""
    now = counts(claims)
    rows = [
        f"| {verdict} | "
        + " | ".join(
            f"{sum(one['paper'] == paper and one['first']['verdict'] == verdict for one in claims)}"
            f" | {now[paper][verdict]}"
            for paper in PAPERS
        )
        + " |"
        for verdict in VERDICTS
    ]
    heads = " | ".join(f"{author}, first | now" for author in PAPERS.values())
    return "\n".join([f"| verdict | {heads} |", "| --- |" + " --- |" * 2 * len(PAPERS), *rows, ""])


def _row(claim: Mapping[str, Any]) -> str:
    first, now = claim["first"], claim["verdict"]
    changed = first["verdict"] != now
    verdict = f"**{now}**" if changed else now
    if claim["part_verdicts"]:
        verdict += ": " + ", ".join(
            f"{part} {each}" for part, each in claim["part_verdicts"].items()
        )
    if claim["protocol_dependent"]:
        verdict += "; depends on the protocol"
    numbers = ", ".join(f"{one['value']:g}: {one['verdict']}" for one in claim["by_number"])
    title = f"{claim['id']} {claim['title']}"
    return f"| {title} | {first['verdict']} | {verdict} | {numbers} | {first['why']} |"


def main(published: Path = PUBLISHED) -> str:
    """Return the page from what is published of both papers."""
    files = (published / f"paper_{paper}" / "claims.json" for paper in PAPERS)
    found = [read_claims(file, replaceable=False) for file in files]
    return page([claim for claims in found for claim in claims])


if __name__ == "__main__":
    sys.stdout.write(main())
