"""JSON with a checksum, which shows any later change."""

import hashlib
import json
from typing import Any

#: Key of the checksum, which covers all other keys and values.
CHECKSUM = "sha256"


def to_sealed_json(mapping: dict[str, Any]) -> str:
    """Return a mapping with its checksum as JSON, a line for each key."""
    sealed = mapping | {CHECKSUM: _checksum(mapping)}
    lines = (f"{_text(key)}: {_text(value)}" for key, value in sealed.items())
    return "{\n" + ",\n".join(lines) + "\n}\n"


def parse_sealed_json(text: str) -> dict[str, Any]:
    """Return the mapping in a text of `to_sealed_json`; raise ``ValueError`` if it has changed."""
    mapping = json.loads(text)
    checksum = mapping.pop(CHECKSUM, "")
    if _checksum(mapping) != checksum:
        raise ValueError("the checksum is wrong")
    return mapping


def _checksum(mapping: dict[str, Any]) -> str:
    return hashlib.sha256(_text(mapping).encode()).hexdigest()


def _text(value: Any) -> str:
    return json.dumps(value, ensure_ascii=False, allow_nan=False)
