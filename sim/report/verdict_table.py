"""The page of docs/ with all claims: the verdicts of each round, and why they differ."""

import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from sim.report.claims import VERDICTS, count_verdicts, read_claims
from sim.report.publish import PUBLISHED
from sim.study.papers import papers

_HEAD = """\
# Verdicts, then and now

Only the text of both papers was at hand, no figure. Each claim has four verdicts:

- *first*: of the first criterion, on the runs published first;
- *second round*: of restated criteria, on **fresh seeds**;
- *referee*: of one who judged the runs of the second round anew;
- *now*: of the present rules, on the same runs
  ([how often they err](validation.md#how-often-the-judge-is-right)).

The last column says what changed since the second round, and then why the first criterion was
restated. A verdict that changed since the second round is bold. It may hold under a condition ("at
K1 = 1,000 N/m"); letters are the statements of a claim that says several things. *By number of
ours* has the verdict for other values of a number that the paper does not give.

Sentences, criteria and evidence: the reports
([Walton](../results/published/paper_walton/report.html),
[Gallas](../results/published/paper_gallas/report.html)). Verdicts by reading and protocol:
`verdicts.csv` beside them.

`python -m sim.report.verdict_table > docs/verdicts.md` makes this page from `claims.json` of both.
"""


def page(claims: Sequence[Mapping[str, Any]]) -> str:
    """Return the page as Markdown text.

    Parameters
    ----------
    claims : sequence of mapping
        The claims of both papers, as `sim.report.claims.read_claims` returns them.
    """
    to_second, to_now = changes(claims)
    counts = (
        f"Of {len(claims)} verdicts {to_second} changed from the first to the second round, and "
        f"{to_now} from the second to now.\n"
    )
    parts = [_HEAD, _totals(claims), counts]
    for name, paper in papers().items():
        rows = [_row(claim) for claim in claims if claim["paper"] == name]
        heads = (
            "| claim | first | second round | referee | now | by number of ours | why |\n"
            "| --- | --- | --- | --- | --- | --- | --- |"
        )
        parts.append("\n".join([f"## {paper.author}\n", heads, *rows, ""]))
    return "\n".join(parts)


def _totals(claims: Sequence[Mapping[str, Any]]) -> str:
    """Return a table with the number of claims by verdict and paper: first, in round two, now."""
    now = count_verdicts(claims)
    rows = []
    for verdict in VERDICTS:
        cells = []
        for paper in papers():
            of_paper = [claim for claim in claims if claim["paper"] == paper]
            cells += [
                sum(claim[when]["verdict"] == verdict for claim in of_paper)
                for when in ("first", "round_two")
            ]
            cells.append(now[paper][verdict])
        rows.append(f"| {verdict} | {' | '.join(map(str, cells))} |")
    heads = " | ".join(f"{paper.author}, first | second | now" for paper in papers().values())
    return "\n".join(
        [f"| verdict | {heads} |", "| --- |" + " --- |" * 3 * len(papers()), *rows, ""]
    )


def changes(claims: Sequence[Mapping[str, Any]]) -> tuple[int, int]:
    """Return how many headline verdicts changed from the first to the second round, and to now."""
    return (
        sum(claim["first"]["verdict"] != claim["round_two"]["verdict"] for claim in claims),
        sum(claim["round_two"]["verdict"] != claim["verdict"] for claim in claims),
    )


def _row(claim: Mapping[str, Any]) -> str:
    first, second, now = claim["first"], claim["round_two"], claim["verdict"]
    verdict = f"**{now}**" if second["verdict"] != now else now
    if claim["condition"]:
        verdict += f" {claim['condition']}"
    if claim["part_verdicts"]:
        verdict += ": " + ", ".join(
            f"{part} {part_verdict}" for part, part_verdict in claim["part_verdicts"].items()
        )
    numbers = ", ".join(
        f"{number['value']:g}: {number['verdict']}" for number in claim["by_number"]
    )
    title = f"{claim['id']} {claim['title']}"
    why = " ".join(filter(None, (second["why"], first["why"] and f"At first: {first['why']}")))
    cells = title, first["verdict"], second["verdict"], second["referee"], verdict, numbers, why
    return f"| {' | '.join(cells)} |"


def main(published: Path = PUBLISHED) -> str:
    """Return the page of the published studies of both papers."""
    files = (published / f"paper_{paper}" / "claims.json" for paper in papers())
    claim_lists = [read_claims(file, replaceable=False) for file in files]
    return page([claim for claims in claim_lists for claim in claims])


if __name__ == "__main__":
    sys.stdout.write(main())
