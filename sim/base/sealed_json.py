"""JSON that says by a checksum whether it is as it was written."""

import hashlib
import json
from typing import Any

#: The key of the checksum, that of all the other keys and values.
CHECKSUM = "sha256"


def as_sealed(mapping: dict[str, Any]) -> str:
    """Write a mapping with its checksum as JSON, a line for each key."""
    held = mapping | {CHECKSUM: _checksum(mapping)}
    lines = (f"{_text(key)}: {_text(value)}" for key, value in held.items())
    return "{\n" + ",\n".join(lines) + "\n}\n"


def read_sealed(text: str) -> dict[str, Any]:
    """Return the mapping that was written; raise ``ValueError`` when it has changed since."""
    held = json.loads(text)
    told = held.pop(CHECKSUM, "")
    if _checksum(held) != told:
        raise ValueError("the checksum is wrong")
    return held


def _checksum(mapping: dict[str, Any]) -> str:
    return hashlib.sha256(_text(mapping).encode()).hexdigest()


def _text(value: Any) -> str:
    return json.dumps(value, ensure_ascii=False, allow_nan=False)
