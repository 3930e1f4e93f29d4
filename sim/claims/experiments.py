"""Experiments on the model, which need no study: run once for the present code, then cached.

The cache is kept beside the compiled code. The file name contains a hash of all inputs: sources of
parameters, engine, claims and papers, versions of libraries, the reading.
"""

import hashlib
import json
import logging
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import asdict
from math import sqrt
from typing import Any

import numpy as np
from pydantic import TypeAdapter

from sim.base.additions import additions
from sim.base.files import atomic_write
from sim.base.seals import is_damaged, seal
from sim.claims.claim import Claim
from sim.claims.verdict import Check
from sim.engine.compile import kernel
from sim.engine.contact.friction import blank_memory, contact_force
from sim.engine.identity import cache_directory, library_versions, source_hash
from sim.study.entries import JUDGE

log = logging.getLogger("talus")

_CHECKS = TypeAdapter(tuple[Check, ...])

#: Parts of the package on which the result of an experiment depends.
SOURCES = ("parameters", "engine", "claims", "papers")


def run_experiment(claim: Claim, reading: Mapping[str, Any]) -> tuple[Check, ...]:
    """Return the checks of a claim on the model under a reading, computed or cached.

    A cached result is used only if it is undamaged and that of this code, claim and reading, whose
    hash its name has. Otherwise the experiment is run.
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
    # It may not be there, or be of another form.
    with suppress(OSError, ValueError):
        if not is_damaged(path):
            with path.open(encoding="utf-8") as file:
                return _CHECKS.validate_python(json.loads(file.readline()))
    checks = claim.checks_on(reading)
    try:
        with atomic_write(path) as temporary:
            text = json.dumps([asdict(check) for check in checks])
            temporary.write_text(text, encoding="utf-8")
            seal(temporary)
    except OSError as error:
        log.warning("%s: not kept: %s", path, error.strerror or error)
    return checks


@kernel
def contact_path(law, overlap, normal, slip):
    """Follow one contact along a path of overlaps (n,), normals (n, 3) and slips (n, 3).

    Returns normal forces (n,), tangential forces (n, 3) and memories (n, M).
    """
    steps = overlap.size
    force, tangential = np.zeros(steps), np.zeros((steps, 3))
    memory = blank_memory(law)
    memories = np.zeros((steps, len(memory)))
    for k in range(steps):
        n = (normal[k, 0], normal[k, 1], normal[k, 2])
        s = (slip[k, 0], slip[k, 1], slip[k, 2])
        approach = overlap[k] - (overlap[k - 1] if k else 0.0)
        force[k], t, memory, _ = contact_force(law, overlap[k], approach, n, s, memory)
        for d in range(3):
            tangential[k, d] = t[d]
        for m in range(len(memory)):
            memories[k, m] = memory[m]
    return force, tangential, memories


@kernel
def vector_spring(slip, normal_force, stiffness, friction):
    """Cundall and Strack's spring: force (n, 2) after slips (n, 2), cut to friction times F_N."""
    force = np.empty_like(slip)
    x, y = 0.0, 0.0
    for k in range(normal_force.size):
        x, y = x + stiffness * slip[k, 0], y + stiffness * slip[k, 1]
        excess = max(1.0, sqrt(x * x + y * y) / (friction * normal_force[k]))
        x, y = x / excess, y / excess
        force[k, 0] = x
        force[k, 1] = y
    return force


def random_curve(seed: int, steps: int) -> np.ndarray:
    """Return a smooth closed random curve (steps + 1, 2) from the origin, of size one."""
    rng = np.random.default_rng(seed)
    mode = np.arange(1, 6)
    angle = 2 * np.pi * np.linspace(0, 1, steps + 1)[:, None] * mode
    sines, cosines = rng.normal(size=(2, 5, 2)) / mode[:, None]
    curve = np.sin(angle) @ sines + (np.cos(angle) - 1) @ cosines
    return curve / np.abs(curve).max()
