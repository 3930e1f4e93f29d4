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
        those ``tested``, how many runs of the published protocol are ``sound`` of all, the worst
        ledger of these (``missing``); and ``rows``, claims that more than one reading tests, with
        the verdict under each.
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
    """Return what is known of one reading."""
    declared = readings_of(system)
    every = [declared.headline, {}, *readings_run(results, system)]
    values = next((one for one in every if in_words(system, one) == words), {})
    verdicts = [one["by_reading"].get(words, "untestable") for one in claims]
    return {
        "words": words,
        "is_headline": values == declared.headline,
        "sentences": declared.sentences(values),
        "control": declared.is_control(values),
        "hold": sum(verdict.startswith("reproduced") for verdict in verdicts),
        "tested": sum(verdict != "untestable" for verdict in verdicts),
        **_ledger(results.dataset, system, values),
    }


def _ledger(dataset: xr.Dataset, system: str, values: Mapping[str, Any]) -> dict[str, Any]:
    """Return how many points close their ledger with the published step, and the worst share."""
    usual = SYSTEMS[system]()
    chosen = (dataset["system"] == system) & (dataset["protocol"] == "published")
    for name in parameters_of(SYSTEMS[system]):
        chosen = chosen & (dataset[name] == values.get(name, getattr(usual, name)))
    missing = np.abs(dataset["missing_energy"].values[np.flatnonzero(chosen)])
    worst = np.array([np.nanmax(row) for row in missing if np.isfinite(row).any()])
    return {
        "points": int(worst.size),
        "sound": int((worst <= UNSOUND).sum()),
        "missing": float(worst.max()) if worst.size else float("nan"),
    }
