"""The table of readings: under each reading of a paper, which of its claims hold."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr

from sim.claims.readings import in_words, readings_of, readings_run
from sim.dataset.caveats import UNSOUND
from sim.dataset.results import Results
from sim.parameters import SYSTEMS
from sim.parameters.roles import readings as parameters_of
from sim.report.claims import SYSTEM


def reading_tables(claims: Sequence[Mapping[str, Any]], results: Results) -> list[dict[str, Any]]:
    """Return a table per paper whose claims were judged under more than one reading.

    Returns
    -------
    list of dict
        ``paper``, ``why`` the headline reading is that; ``readings``, each with its ``words``, the
        ``sentences`` that leave it open or why it is a ``control``, how many claims ``hold`` of
        those ``tested``, and of those that the headline reading tests too (``common``) how many
        hold under it (``common_hold``) and under the headline reading (``headline_hold``); of the
        points with a run of the published protocol (``points``) how many have a time step within
        the integrator's stability (``stable``, none where its system knows no bound) and close
        their ledger (``sound``), the worst ledger of these (``missing``); and ``rows``, claims
        that more than one reading tests, with the verdict under each.
    """
    tables = []
    for paper, system in SYSTEM.items():
        own = [one for one in claims if one["paper"] == paper and one["kind"] != "model"]
        words = list(dict.fromkeys(name for one in own for name in one["by_reading"]))
        if len(words) > 1:
            columns = [_reading(name, own, results, system) for name in words]
            rows = [
                {"id": one["id"], "title": one["title"], "verdicts": _verdicts(one, words)}
                for one in own
                if sum(verdict != "untestable" for verdict in one["by_reading"].values()) > 1
            ]
            why = readings_of(system).why
            tables.append({"paper": paper, "why": why, "readings": columns, "rows": rows})
    return tables


def _verdicts(claim: Mapping[str, Any], words: Sequence[str]) -> list[str]:
    return [claim["by_reading"].get(name, "untestable") for name in words]


def _reading(
    words: str, claims: Sequence[Mapping[str, Any]], results: Results, system: str
) -> dict[str, Any]:
    """Return sentences, verdict counts and time step of one reading for the report."""
    declared = readings_of(system)
    every = [declared.headline, {}, *readings_run(results, system)]
    values = next((one for one in every if in_words(system, one) == words), {})
    first = in_words(system, declared.headline)
    pairs = [_verdicts(one, (words, first)) for one in claims]
    common = [pair for pair in pairs if "untestable" not in pair]
    return {
        "words": words,
        "is_headline": values == declared.headline,
        "sentences": declared.sentences(values),
        "control": declared.is_control(values),
        "hold": sum(_holds(here) for here, _ in pairs),
        "tested": sum(here != "untestable" for here, _ in pairs),
        "common": len(common),
        "common_hold": sum(_holds(here) for here, _ in common),
        "headline_hold": sum(_holds(there) for _, there in common),
        **_step(results.dataset, system, values),
    }


def _holds(verdict: str) -> bool:
    """Return whether a claim holds, wholly or in part."""
    return verdict.startswith("reproduced")


def _step(dataset: xr.Dataset, system: str, values: Mapping[str, Any]) -> dict[str, Any]:
    """Return whether the published step bears a reading, by theory and by the energy of runs."""
    model = SYSTEMS[system]
    usual = model()
    chosen = (dataset["system"] == system) & (dataset["protocol"] == "published")
    for name in parameters_of(model):
        chosen = chosen & (dataset[name] == values.get(name, getattr(usual, name)))
    for name in values.keys() & readings_of(system).rows:
        chosen = chosen & (dataset[name] == values[name])
    points = dataset.isel(point=np.flatnonzero(chosen))
    missing = np.abs(points["missing_energy"].values)
    known = np.isfinite(missing).any(axis=1)
    worst = np.nanmax(missing[known], axis=1)
    names = model.model_fields
    rows = zip(*(points[name].values[known].tolist() for name in names), strict=True)
    run = [model.model_construct(**dict(zip(names, row, strict=True))) for row in rows]
    return {
        "points": len(run),
        "stable": None if usual.is_stable is None else sum(bool(one.is_stable) for one in run),
        "sound": int((worst <= UNSOUND).sum()),
        "missing": float(worst.max(initial=0)) if run else float("nan"),
    }
