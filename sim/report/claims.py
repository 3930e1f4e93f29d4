"""Rows of the report for claims, the evidence of their verdicts, and the readings of papers."""

import hashlib
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from sim.base.seals import checked_read, parse_sealed_json
from sim.claims.evidence import combined_readings, is_regridded, reading_label
from sim.claims.verdict_files import checks_of
from sim.dataset.replicates import UNSOUND_SHARE
from sim.dataset.results import Results
from sim.parameters import SYSTEMS
from sim.parameters.roles import reading_parameters as parameters_of
from sim.parameters.words import PROTOCOLS
from sim.study.figure_spec import FIGURES
from sim.study.model import Study
from sim.study.papers import Paper, papers

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

    Checks have the ids of their points. A damaged file is set aside if it is ``replaceable``: the
    workflow can make it again.

    Raises `DamagedError` when it cannot be read.
    """
    return _read(path, replaceable)["claims"] if path.is_file() else []


def require_table(folder: Path) -> None:
    """Raise `InputError` unless the tables of checks and of verdicts were written with the claims.

    That is a `DamagedError` when a table has changed since, or ``claims.json`` cannot be read.
    """
    for name in ("claims.csv", "verdicts.csv"):
        table = folder / name
        with checked_read(table, "table of verdicts", replaceable=True):
            recorded = _read(folder / "claims.json")[name]
            if hashlib.sha256(table.read_bytes()).hexdigest() != recorded:
                raise ValueError("the checksum is wrong")


def _read(path: Path, replaceable: bool = True) -> dict[str, Any]:
    with checked_read(path, "table of verdicts", replaceable=replaceable):
        content = parse_sealed_json(path.read_text(encoding="utf-8"))
        for check in checks_of(content["claims"]):
            check["points"] = [content["points"][place] for place in check["points"]]
        return content


def is_on_flows(claim: Mapping[str, Any]) -> bool:
    """Return whether a claim is a statement on flows; others are checks of the model.

    What the model is made of holds for any correct program, whatever flows do.
    """
    return claim["kind"] == "flow"


def count_verdicts(claims: Sequence[Mapping[str, Any]]) -> dict[str, dict[str, int]]:
    """Return the number of statements on flows by the short name of the paper and by verdict."""
    found = Counter((claim["paper"], claim["verdict"]) for claim in claims if is_on_flows(claim))
    known = {claim["paper"] for claim in claims}
    return {
        paper: {verdict: found[paper, verdict] for verdict in VERDICTS}
        for paper in papers()
        if paper in known
    }


def papers_of(claims: Iterable[Mapping[str, Any]], study: Study) -> set[str]:
    """Return the papers that count for a study.

    That is the one it names, those whose figures it feeds, and, if it names none, those with a
    claim on flows that its runs can decide.
    """
    fed = [spec.paper for spec in study.entries.values() if spec.paper]
    named = {
        name
        for name, paper in papers().items()
        if any(text.startswith(f"{paper.quote}, ") for text in fed)
    }
    decided = {claim["paper"] for claim in claims if has_tested_claims([claim])}
    return named | ({study.paper} if study.paper else decided)


def protocols_of(claims: Iterable[Mapping[str, Any]]) -> list[str]:
    """Return the protocols whose runs test any of the claims, of `claim_rows`."""
    tested = {
        protocol
        for claim in claims
        for protocol, verdict in claim["by_protocol"].items()
        if verdict != "untestable"
    }
    return [name for name in ("published", "converged") if name in tested]


def has_tested_claims(claims: Iterable[Mapping[str, Any]]) -> bool:
    """Return whether any claim on flows was tested."""
    return any(is_on_flows(claim) and claim["verdict"] != "untestable" for claim in claims)


def tests_a_paper(claims: Sequence[Mapping[str, Any]]) -> bool:
    """Return whether runs test most claims of any paper."""
    tested = Counter(claim["paper"] for claim in claims if claim["verdict"] != "untestable")
    return any(2 * tested[name] > len(paper.claims) for name, paper in papers().items())


def model_checks(claims: Iterable[Mapping[str, Any]]) -> dict[str, int]:
    """Return how many checks of the model were ``tested`` and ``reproduced``."""
    checks = [
        claim for claim in claims if not is_on_flows(claim) and claim["verdict"] != "untestable"
    ]
    reproduced = sum(claim["verdict"] == "reproduced" for claim in checks)
    return {"tested": len(checks), "reproduced": reproduced}


def claim_rows(
    claims: Iterable[Mapping[str, Any]],
    runs: Iterable[Mapping[str, Any]],
    figure_names: Iterable[str],
) -> list[dict[str, Any]]:
    """Return one row per claim with everything that the templates show of its evidence.

    Claims are as `read_claims` returns them, ``runs`` is the table of `sim.report.runs.run_rows`,
    and ``figure_names`` are those in the report.
    """
    figure_names = set(figure_names)
    authors = {name: paper.author for name, paper in papers().items()}
    rows = {run["point"]: run for run in runs}
    return [
        {
            **claim,
            "author": authors.get(claim["paper"], ""),
            "figures": [
                {"name": name, "title": title, "drawn": name in figure_names}
                for name, title in _figure_titles(claim["figures"]).items()
            ],
            "by_protocol": {
                variant["protocol"]: variant["verdict"]
                for variant in reversed(claim["variants"])
                if variant["reading"] in claim["headings"]
            },
            "holds_simply": claim["verdict"] == "reproduced" and not claim["condition"],
            "depends": [name for name in ("protocol", "reading") if claim[f"{name}_dependent"]],
            "variants": [_variant(variant, claim) for variant in claim["variants"]],
            "cost": _cost(claim, rows),
        }
        for claim in claims
    ]


def _figure_titles(names: Sequence[str]) -> dict[str, str]:
    """Return where figures are in their papers, with their titles where two are in one place."""
    places = Counter(FIGURES[name].paper for name in names)
    return {
        name: spec.paper if places[spec.paper] == 1 else f"{spec.paper}: {spec.title}"
        for name, spec in ((name, FIGURES[name]) for name in names)
    }


def _cost(claim: Mapping[str, Any], runs: Mapping[str, Mapping[str, Any]]) -> dict[str, float]:
    """Return the points behind the headline verdict and the wall time (s) of their runs."""
    points = {
        point
        for variant in claim["variants"]
        if variant["reading"] in claim["headings"]
        for check in variant["checks"]
        for point in check["points"]
    }
    seconds = [runs[point]["wall_time"] for point in points if point in runs]
    return {"points": len(seconds), "seconds": float(sum(seconds))} if seconds else {}


def _variant(variant: Mapping[str, Any], claim: Mapping[str, Any]) -> dict[str, Any]:
    system = claim.get("system") or papers()[claim["paper"]].system
    title = PROTOCOLS[system].get(variant["protocol"], _MODEL).capitalize()
    reading = "" if variant["reading"] == "default" else f", {variant['reading']}"
    is_usual = variant["reading"] in claim["headings"]
    return {**variant, "title": title + reading, "usual": is_usual}


def reading_tables(claims: Sequence[Mapping[str, Any]], results: Results) -> list[dict[str, Any]]:
    """Return a table per paper whose claims were judged under more than one reading.

    It has ``paper`` and its ``author``; ``why``, the reason for the headline reading; ``readings``;
    ``claims``, which more than one protocol or reading tests; and ``rows``, one per protocol and
    reading, with their ``verdicts`` on these claims, None where it has no runs of its own.

    Each reading has its ``words``, and the ``sentences`` that leave it open or the reason why it is
    a ``control``. Of the claims ``tested`` under it, ``hold`` hold. Of the ``common`` claims, which
    the headline reading tests, too, ``common_hold`` hold under it and ``headline_hold`` under the
    headline reading. ``points`` counts the points with a run of the published protocol. Of these,
    ``stable`` have a time step within the integrator's stability (None where the system has no such
    bound), and ``sound`` close their energy ledger. ``missing`` is the worst ledger of these
    points.
    """
    tables = []
    for name, paper in papers().items():
        own = [claim for claim in claims if claim["paper"] == name and is_on_flows(claim)]
        words = list(dict.fromkeys(label for claim in own for label in claim["by_reading"]))
        if len(words) > 1:
            combined = combined_readings(results, paper.system, paper)
            readings = {reading_label(paper.system, one, paper.readings): one for one in combined}
            # What is the same runs on another grid is told of the headline reading alone, and what
            # is another reading of one claim in that claim.
            columns = [
                _reading(label, readings[label], combined[0], own, results, paper)
                for label in words
                if label in readings and not is_regridded(readings[label], combined[0])
            ]
            heading = {"paper": name, "author": paper.author, "why": paper.readings.why}
            tables.append(heading | {"readings": columns} | _by_variant(own, words, paper.system))
    return tables


def _by_variant(
    claims: Sequence[Mapping[str, Any]], words: Sequence[str], system: str
) -> dict[str, Any]:
    """Return the claims that several protocols or readings test, and a row for each of these."""
    verdicts = {
        claim["id"]: {
            (variant["protocol"], variant["reading"]): variant["verdict"]
            for variant in claim["variants"]
            if variant["verdict"] != "untestable"
        }
        for claim in claims
    }
    several = [claim for claim in claims if len(verdicts[claim["id"]]) > 1]
    rows = []
    for label in words:
        for protocol in PROTOCOLS[system]:
            found = [verdicts[claim["id"]].get((protocol, label)) for claim in several]
            if any(found):
                rows.append({"protocol": protocol, "words": label, "verdicts": found})
    return {"claims": several, "rows": rows}


def _reading(
    words: str,
    values: Mapping[str, Any],
    first: Mapping[str, Any],
    claims: Sequence[Mapping[str, Any]],
    results: Results,
    paper: Paper,
) -> dict[str, Any]:
    """Return one reading for the report: sentences, counts of verdicts, checks of the time step.

    It is compared with the first, which heads the verdicts.
    """
    system, declared = paper.system, paper.readings
    heading = reading_label(system, first, declared)
    pairs = [
        [claim["by_reading"].get(name, "untestable") for name in (words, heading)]
        for claim in claims
    ]
    common = [pair for pair in pairs if "untestable" not in pair]
    return {
        "words": words,
        "is_headline": values == first,
        "sentences": declared.sentences(values),
        "control": declared.control_reason(values),
        "hold": sum(here.startswith("reproduced") for here, _ in pairs),
        "tested": sum(here != "untestable" for here, _ in pairs),
        "common": len(common),
        "common_hold": sum(here.startswith("reproduced") for here, _ in common),
        "headline_hold": sum(there.startswith("reproduced") for _, there in common),
        **_step_checks(results.dataset, paper, values),
    }


def _step_checks(dataset: xr.Dataset, paper: Paper, values: Mapping[str, Any]) -> dict[str, Any]:
    """Return checks of the published time step under a reading: by theory and by energy of runs."""
    model = SYSTEMS[paper.system]
    defaults = model()
    usual = vars(defaults) | paper.usual(paper.system, values)
    is_chosen = (dataset["system"] == paper.system) & (dataset["protocol"] == "published")
    for name in parameters_of(model):
        is_chosen = is_chosen & (dataset[name] == values.get(name, usual[name]))
    for name in values.keys() & paper.readings.rows:
        is_chosen = is_chosen & (dataset[name] == values[name])
    points = dataset.isel(point=np.flatnonzero(is_chosen))
    missing_energy = np.abs(points["missing_energy"].values)
    has_energy = np.isfinite(missing_energy).any(axis=1)
    worst = np.nanmax(missing_energy[has_energy], axis=1)
    names = model.model_fields
    rows = zip(*(points[name].values[has_energy].tolist() for name in names), strict=True)
    points_run = [model.model_construct(**dict(zip(names, row, strict=True))) for row in rows]
    return {
        "points": len(points_run),
        "stable": None
        if defaults.is_stable is None
        else sum(bool(point.is_stable) for point in points_run),
        "sound": int((worst <= UNSOUND_SHARE).sum()),
        "missing": float(worst.max(initial=0)) if points_run else float("nan"),
    }
