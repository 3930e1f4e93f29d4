"""The table of readings: which claims of a paper hold under each of its readings."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr

from sim.claims.judgement import PROTOCOLS
from sim.claims.readings import GRID, combined_readings, reading_label
from sim.dataset.caveats import UNSOUND_SHARE
from sim.dataset.results import Results
from sim.parameters import SYSTEMS
from sim.parameters.roles import reading_parameters as parameters_of
from sim.study.papers import Paper, papers


def reading_tables(claims: Sequence[Mapping[str, Any]], results: Results) -> list[dict[str, Any]]:
    """Return a table per paper whose claims were judged under more than one reading.

    Returns
    -------
    list of dict
        ``paper`` and its ``author``; ``why``, the reason for the headline reading; ``readings``;
        ``claims``, which more than one protocol or reading tests; and ``rows``, one per protocol
        and reading, with their ``verdicts`` on these claims, None where it has no runs of its own.

        Each reading has its ``words``, and the ``sentences`` that leave it open or the reason why
        it is a ``control``. Of the claims ``tested`` under it, ``hold`` hold. Of the ``common``
        claims, which the headline reading tests, too, ``common_hold`` hold under it and
        ``headline_hold`` under the headline reading.

        ``points`` counts the points with a run of the published protocol. Of these, ``stable`` have
        a time step within the integrator's stability (None where the system has no such bound), and
        ``sound`` close their energy ledger. ``missing`` is the worst ledger of these points.
    """
    tables = []
    for name, paper in papers().items():
        paper_claims = [
            claim for claim in claims if claim["paper"] == name and claim["kind"] != "model"
        ]
        words = list(
            dict.fromkeys(label for claim in paper_claims for label in claim["by_reading"])
        )
        if len(words) > 1:
            readings = {
                reading_label(paper.system, reading, paper.readings): reading
                for reading in combined_readings(results, paper.system, paper.readings)
            }
            # What is the same runs on another grid is told of the headline reading alone.
            shown = [
                label
                for label in words
                if GRID not in (reading := readings.get(label, {}))
                or reading == paper.readings.headline | {GRID: reading[GRID]}
            ]
            columns = [
                _reading(label, readings.get(label, {}), paper_claims, results, paper)
                for label in shown
            ]
            heading = {"paper": name, "author": paper.author, "why": paper.readings.why}
            tables.append(heading | {"readings": columns} | _by_variant(paper_claims, words))
    return tables


def _by_variant(claims: Sequence[Mapping[str, Any]], words: Sequence[str]) -> dict[str, Any]:
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
    rows = [
        {
            "protocol": protocol,
            "words": label,
            "verdicts": [verdicts[claim["id"]].get((protocol, label)) for claim in several],
        }
        for label in words
        for protocol in PROTOCOLS
    ]
    return {"claims": several, "rows": [row for row in rows if any(row["verdicts"])]}


def _verdicts(claim: Mapping[str, Any], words: Sequence[str]) -> list[str]:
    return [claim["by_reading"].get(name, "untestable") for name in words]


def _reading(
    words: str,
    values: Mapping[str, Any],
    claims: Sequence[Mapping[str, Any]],
    results: Results,
    paper: Paper,
) -> dict[str, Any]:
    """Return one reading for the report: sentences, counts of verdicts, checks of the time step."""
    system, declared = paper.system, paper.readings
    first = reading_label(system, declared.headline, declared)
    pairs = [_verdicts(candidate, (words, first)) for candidate in claims]
    common = [pair for pair in pairs if "untestable" not in pair]
    return {
        "words": words,
        "is_headline": values == declared.headline,
        "sentences": declared.sentences(values),
        "control": declared.control_reason(values),
        "hold": sum(_is_reproduced(here) for here, _ in pairs),
        "tested": sum(here != "untestable" for here, _ in pairs),
        "common": len(common),
        "common_hold": sum(_is_reproduced(here) for here, _ in common),
        "headline_hold": sum(_is_reproduced(there) for _, there in common),
        **_step_checks(results.dataset, paper, values),
    }


def _is_reproduced(verdict: str) -> bool:
    """Return whether a verdict is reproduced, wholly or in part."""
    return verdict.startswith("reproduced")


def _step_checks(dataset: xr.Dataset, paper: Paper, values: Mapping[str, Any]) -> dict[str, Any]:
    """Return checks of the published time step under a reading: by theory and by energy of runs."""
    model = SYSTEMS[paper.system]
    defaults = model()
    is_chosen = (dataset["system"] == paper.system) & (dataset["protocol"] == "published")
    for name in parameters_of(model):
        is_chosen = is_chosen & (dataset[name] == values.get(name, getattr(defaults, name)))
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
