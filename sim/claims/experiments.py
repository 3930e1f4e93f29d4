"""Experiments on the model, which need no study: done once for the present code, then kept.

What they give is kept beside the compiled code. Anything that it could depend on is part of its
name: sources of parameters, engine and claims, versions of libraries, the reading.
"""

import hashlib
import json
import logging
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

from sim.base.files import is_damaged, replacing, seal
from sim.claims.table import Claim
from sim.claims.verdict import Check
from sim.engine.cache import cache_directory
from sim.engine.identity import library_versions, source_hash

log = logging.getLogger("talus")

#: The parts of the package that decide what an experiment gives.
SOURCES = ("parameters", "engine", "claims")


def experiment(claim: Claim, reading: Mapping[str, Any]) -> tuple[Check, ...]:
    """Return the checks of a claim on the model under a reading, computed or as kept.

    What is kept is used only if it is whole and says of itself that it is of this code, claim and
    reading; else the experiment is done.
    """
    identity = {
        "judge": claim.judge,
        "reading": dict(reading),
        "sources": source_hash(SOURCES),
        "libraries": library_versions(),
    }
    name = hashlib.sha256(json.dumps(identity, sort_keys=True).encode()).hexdigest()[:12]
    path = cache_directory(plugged=False) / f"{claim.id}-{name}.json"
    checks = _read(path, identity)
    if checks is None:
        checks = tuple(claim.judging()(reading))
        _keep(path, identity, checks)
    return checks


def _read(path: Path, identity: Mapping[str, Any]) -> tuple[Check, ...] | None:
    try:
        if is_damaged(path):
            return None
        with path.open(encoding="utf-8") as file:
            held = json.loads(file.readline())
        if held["identity"] != identity:
            return None
        return tuple(_check(one) for one in held["checks"])
    except (OSError, ValueError, LookupError, TypeError):
        return None


def _check(one: dict[str, Any]) -> Check:
    tested = one["tested"]
    return Check(
        **one
        | {
            "points": tuple(one["points"]),
            "short": tuple(one["short"]),
            "tested": None if tested is None else tuple(tested),
        }
    )


def _keep(path: Path, identity: Mapping[str, Any], checks: tuple[Check, ...]) -> None:
    held = {"identity": identity, "checks": [asdict(check) for check in checks]}
    try:
        with replacing(path) as temporary:
            temporary.write_text(json.dumps(held), encoding="utf-8")
            seal(temporary)
    except OSError as error:
        log.warning("%s: not kept: %s", path, error.strerror or error)
