"""Summary of a file: a line of JSON near its end, which is read without opening the file.

It follows the end that the file declares, and the seal follows it, see `sim.base.files`.
"""

import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any
from zlib import crc32

from sim.base.files import SEAL, open_regular

#: Ending of a summary: its length in bytes and its checksum.
_END = b"\nsummary %012d %08x"

#: Bytes of this ending and of a seal.
_ENDING, _SEAL = len(_END % (0, 0)), len(SEAL % bytes(64))


def append_summary(path: Path, summary: Mapping[str, Any]) -> None:
    """Append a summary of plain values or numbers of NumPy to a file that will be sealed."""
    text = json.dumps(summary, separators=(",", ":"), default=lambda number: number.item()).encode()
    with path.open("ab") as file:
        file.write(b"\n" + text + _END % (len(text), crc32(text)))


def read_summary(path: Path) -> dict[str, Any] | None:
    """Return the summary of a sealed file, None where it is missing or damaged.

    The rest of the file is not read and may be damaged.
    """
    with open_regular(path) as file:
        end = file.seek(0, os.SEEK_END) - _ENDING - _SEAL
        if end < 0:
            return None
        file.seek(end)
        ending = file.read(_ENDING + len(SEAL[:9]))
        words = ending.split()
        if len(words) != 4 or words[0] != b"summary":
            return None
        try:
            length = int(words[1])
            file.seek(end - length)
            text = file.read(length)
            return json.loads(text) if ending.startswith(_END % (length, crc32(text))) else None
        except (ValueError, OSError):
            return None
