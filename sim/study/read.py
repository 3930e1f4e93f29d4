"""First step of a study: read its file and those of its parts, and load the plug-ins they name."""

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from sim.base.additions import Plugin
from sim.base.errors import InputError
from sim.base.plugins import PATTERN as PLUGIN_NAME
from sim.base.plugins import load
from sim.base.yaml import read_yaml

#: Pattern of the name of a part. A lone hyphen would be standard input.
PART_NAME = r"^([^/\\-]|[^/\\]{2,})$"


@dataclass(frozen=True)
class Document:
    """A study file as it was read: its path, its contents, and the plug-ins that it names."""

    path: Path
    contents: Any
    plugins: tuple[Plugin, ...]


def read(path: str | Path, plugins: bool = True) -> list[Document]:
    """Read a study file and its parts; return them in this order.

    Plug-ins are loaded, which runs their code, unless ``plugins`` is false.

    Raises
    ------
    InputError
        If a file or a plug-in cannot be read.
    """
    contents = read_yaml(path)
    return with_parts(contents, Path(path), plugins)


def with_parts(contents: Any, path: Path, plugins: bool = True) -> list[Document]:
    """Return the document of a study file and those of its parts: see `read`."""
    documents = [_document(contents, path, plugins)]
    for index, name in enumerate(_names(contents, "parts", PART_NAME)):
        try:
            part = read_yaml(path.parent / name)
        except InputError as error:
            raise InputError(f"{path}: parts[{index}]: {error}") from None
        documents.append(_document(part, path.parent / name, plugins))
    return documents


def _document(contents: Any, path: Path, plugins: bool) -> Document:
    names = _names(contents, "plugins", PLUGIN_NAME) if plugins else ()
    return Document(path, contents, load(names, path.parent, f"{path}: plugins"))


def _names(contents: Any, key: str, pattern: str) -> list[str]:
    """Return the names under a key, none if one is malformed, which `validate` refuses then."""
    names = contents.get(key) if isinstance(contents, dict) else None
    if isinstance(names, list) and all(
        isinstance(name, str) and re.match(pattern, name) for name in names
    ):
        return names
    return []
