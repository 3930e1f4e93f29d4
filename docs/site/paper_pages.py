"""Pages on both papers, made of what is published: results in words, and all verdicts.

``python -m docs.site.paper_pages`` writes the first to the standard output. The second is on the
site alone.
"""

import json
import sys
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import jinja2
import xarray as xr
from uncertainties import ufloat

from sim.report.claims import VERDICTS, count_verdicts, is_on_flows, read_claims
from sim.report.publish import PUBLISHED
from sim.study.papers import papers

#: The papers that the article is about.
PAPERS = {name: papers()[name] for name in ("walton", "gallas")}

#: The article, with places for verdicts and numbers.
TEMPLATE = Path(__file__).with_name("paper.md.j2")

_HEAD = """\
# Verdicts, then and now

Only the texts of both papers were at hand, none of their figures. The [glossary](glossary.md)
explains the words. Each claim has four verdicts:

- *first*: by the first criterion, on the first published runs;
- *second round*: by restated criteria, on **fresh seeds**;
- *referee*: by a referee who judged the runs of the second round again;
- *now*: by the present rules, on these runs and on beds and readings added since
  ([how often they err](validation.md#how-often-the-judge-is-right)).

A dash marks a claim that was added later. A verdict that changed since the second round is bold.
It may hold under a condition ("at K1 = 1,000 N/m"). Letters are the statements of a claim with
several. *By number of ours* has the verdict as a function of a number that the paper does not give.

Sentences, criteria, reasons and evidence are in the reports
([Walton](../results/published/paper_walton/report.html),
[Gallas](../results/published/paper_gallas/report.html)). Verdicts by reading and protocol are in
`verdicts.csv` beside them.
"""


def main(published: Path = PUBLISHED) -> str:
    """Return the page of results of the published studies of both papers."""
    folders = {paper: published / f"paper_{paper}" for paper in PAPERS}
    runs = {}
    for paper, folder in folders.items():
        told = json.loads((folder / "provenance.json").read_text(encoding="utf-8"))
        with xr.open_dataset(folder / "dataset.nc") as dataset:
            hours = float(dataset["loop_time"].sum()) / 3600
        runs[paper] = {"points": told["points"], "runs": told["runs"], "hours": hours}
    return results_page({claim["id"]: claim for claim in published_claims(published)}, runs)


def published_claims(published: Path = PUBLISHED) -> list[dict[str, Any]]:
    """Return the claims of the published studies of both papers."""
    return [
        claim
        for paper in PAPERS
        for claim in read_claims(published / f"paper_{paper}" / "claims.json", replaceable=False)
    ]


def results_page(
    claims: Mapping[str, Mapping[str, Any]], runs: Mapping[str, Mapping[str, Any]]
) -> str:
    """Return the page as Markdown text.

    Parameters
    ----------
    claims : mapping
        The claims of both papers, as `sim.report.claims.read_claims` returns them, by id.
    runs : mapping
        Points, runs and hours of processor time in the loops over time steps, by paper.

    Raises
    ------
    ValueError
        When a claim has another verdict than its sentence assumes, or a number belongs to no check.
        The template must then be rewritten.
    """
    template = jinja2.Template(
        TEMPLATE.read_text(encoding="utf-8"),
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    text = template.render(
        claim=partial(_claim, claims),
        number=partial(_number, claims),
        counts=count_verdicts(list(claims.values())),
        checks=[name for name, claim in claims.items() if not is_on_flows(claim)],
        changes=changes(list(claims.values())),
        statements=sum(map(is_on_flows, claims.values())),
        papers={name: paper.author for name, paper in PAPERS.items()},
        verdicts=VERDICTS,
        runs=runs,
    )
    return text + "\n"


def _claim(claims: Mapping[str, Mapping[str, Any]], name: str, verdict: str) -> str:
    """Return the id of a claim, after a check that it has the verdict that a sentence assumes."""
    current = claims[name]["verdict"]
    if current != verdict:
        raise ValueError(
            f"{name} is {current!r} and no more {verdict!r}: rewrite what is told of it"
        )
    return name


def _number(
    claims: Mapping[str, Mapping[str, Any]],
    name: str,
    what: str,
    interval: bool = True,
    reading: str = "",
    times: float = 1,
) -> str:
    """Return the measured value of a check under a reading and the deciding protocol.

    ``what`` names the check; by default the reading is that of the headline. The value, which is
    multiplied by ``times``, has the half width of its 95 % interval, to one digit of it, or two
    digits where ``interval`` is false or there is none.
    """
    claim = claims[name]
    readings = [reading] if reading else claim["headings"]
    checks = [
        check
        for variant in claim["variants"]
        if variant["reading"] in readings and not variant["control"]
        if variant["protocol"] in claim["decided_by"].split(", ")
        for check in variant["checks"]
        if check["what"] == what
    ]
    if len(checks) != 1:
        raise ValueError(f"{name} has {len(checks)} checks {what!r} instead of one")
    value, half_width = checks[0]["value"], checks[0]["half_width"]
    text = f"{times * value:.2g}"
    if interval and half_width:
        text = f"{ufloat(times * value, times * half_width):.1uP}".replace("±", " ± ")
    return text.replace("-", "\N{MINUS SIGN}")


def verdicts_page(claims: Sequence[Mapping[str, Any]]) -> str:
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
    for name, paper in PAPERS.items():
        rows = [_row(claim) for claim in claims if claim["paper"] == name]
        heads = (
            "| claim | first | second round | referee | now | by number of ours |\n"
            "| --- | --- | --- | --- | --- | --- |"
        )
        parts.append("\n".join([f"## {paper.author}\n", heads, *rows, ""]))
    return "\n".join(parts)


def _totals(claims: Sequence[Mapping[str, Any]]) -> str:
    """Return a table with the number of claims by verdict and paper: first, in round two, now."""
    now = count_verdicts(claims)
    rows = []
    for verdict in VERDICTS:
        cells = []
        for paper in PAPERS:
            of_paper = [one for one in claims if one["paper"] == paper and is_on_flows(one)]
            cells += [
                sum(_then(claim, when) == verdict for claim in of_paper)
                for when in ("first", "round_two")
            ]
            cells.append(now[paper][verdict])
        rows.append(f"| {verdict} | {' | '.join(map(str, cells))} |")
    heads = " | ".join(f"{paper.author}, first | second | now" for paper in PAPERS.values())
    return "\n".join([f"| verdict | {heads} |", "| --- |" + " --- |" * 3 * len(PAPERS), *rows, ""])


def changes(claims: Sequence[Mapping[str, Any]]) -> tuple[int, int]:
    """Return how many headline verdicts changed from the first to the second round, and to now."""
    judged = [claim for claim in claims if claim["round_two"]]
    return (
        sum(_then(claim, "first") != _then(claim, "round_two") for claim in judged),
        sum(_then(claim, "round_two") != claim["verdict"] for claim in judged),
    )


def _then(claim: Mapping[str, Any], when: str, by: str = "verdict") -> str:
    """Return an earlier verdict, a dash of a claim that is newer."""
    return claim[when][by] if claim[when] else "–"


def _row(claim: Mapping[str, Any]) -> str:
    now, second = claim["verdict"], _then(claim, "round_two")
    verdict = f"**{now}**" if claim["round_two"] and second != now else now
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
    referee = _then(claim, "round_two", "referee")
    cells = title, _then(claim, "first"), second, referee, verdict, numbers
    return f"| {' | '.join(cells)} |"


if __name__ == "__main__":
    sys.stdout.write(main())
