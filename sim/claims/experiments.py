"""Experiments on the model, which need no study: run once for the present code, then cached.

The cache is kept beside the compiled code. The file name contains a hash of all inputs: sources of
parameters, engine, claims and papers, versions of libraries, the reading.
"""

import hashlib
import json
import logging
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

from sim.base.additions import additions
from sim.base.files import atomic_write
from sim.base.seals import is_damaged, seal
from sim.claims.claim import Claim
from sim.claims.verdict import Check
from sim.engine.identity import cache_directory, library_versions, source_hash
from sim.study.entries import JUDGE

log = logging.getLogger("talus")

#: Parts of the package on which the result of an experiment depends.
SOURCES = ("parameters", "engine", "claims", "papers")


def run_experiment(claim: Claim, reading: Mapping[str, Any]) -> tuple[Check, ...]:
    """Return the checks of a claim on the model under a reading, computed or cached.

    A cached result is used only if it is undamaged and its identity matches this code, claim and
    reading. Otherwise the experiment is run.
    """
    plugin = additions(JUDGE).get(claim.id)
    identity = {
        "claim": claim.id,
        "plugin": plugin.plugin.code if plugin else "",
        "bounds": claim.bounds_at(),
        "reading": dict(reading),
        "sources": source_hash(SOURCES),
        "libraries": library_versions(),
    }
    name = hashlib.sha256(json.dumps(identity, sort_keys=True).encode()).hexdigest()[:12]
    path = cache_directory(with_plugins=False) / f"{claim.id}-{name}.json"
    checks = _read(path, identity)
    if checks is None:
        checks = claim.checks_on(reading)
        _write(path, identity, checks)
    return checks


def _read(path: Path, identity: Mapping[str, Any]) -> tuple[Check, ...] | None:
    try:
        if is_damaged(path):
            return None
        with path.open(encoding="utf-8") as file:
            document = json.loads(file.readline())
        if document["identity"] != identity:
            return None
        return tuple(_restore_check(fields) for fields in document["checks"])
    except (OSError, ValueError, LookupError, TypeError):
        return None


def _restore_check(fields: dict[str, Any]) -> Check:
    p_values = fields["tested"]
    return Check(
        **fields
        | {
            "points": tuple(fields["points"]),
            "short": tuple(fields["short"]),
            "open_points": tuple(fields["open_points"]),
            "tested": None if p_values is None else tuple(p_values),
        }
    )


def _write(path: Path, identity: Mapping[str, Any], checks: tuple[Check, ...]) -> None:
    document = {"identity": identity, "checks": [asdict(check) for check in checks]}
    try:
        with atomic_write(path) as temporary:
            temporary.write_text(json.dumps(document), encoding="utf-8")
            seal(temporary)
    except OSError as error:
        log.warning("%s: not kept: %s", path, error.strerror or error)
