"""JSON that says by a checksum whether it is as it was written."""

import hashlib
import json
from typing import Any

#: The key of the checksum, that of all the other keys and values.
CHECKSUM = "sha256"


def as_sealed(mapping: dict[str, Any]) -> str:
    """Write a mapping with its checksum as JSON."""
    held = mapping | {CHECKSUM: _checksum(mapping)}
    return json.dumps(held, indent=1, ensure_ascii=False, allow_nan=False) + "\n"


def read_sealed(text: str) -> dict[str, Any]:
    """Return the mapping that was written; raise ``ValueError`` when it has changed since."""
    held = json.loads(text)
    told = held.pop(CHECKSUM, "")
    if _checksum(held) != told:
        raise ValueError("the checksum is wrong")
    return held


def _checksum(mapping: dict[str, Any]) -> str:
    text = json.dumps(mapping, ensure_ascii=False, allow_nan=False)
    return hashlib.sha256(text.encode()).hexdigest()
