"""Reading YAML the strict way: YAML 1.2 scalars, no duplicate keys, one-line errors."""

import re
import sys
from pathlib import Path
from typing import Any, ClassVar

import yaml

from sim.errors import InputError, key_path

_Base = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
_Path = tuple[str | int, ...]

MAX_DEPTH = 50


class _Loader(_Base):
    """Safe loader that resolves plain scalars by the core schema of YAML 1.2.

    PyYAML follows YAML 1.1, where ``1e3`` is text, ``010`` is eight and ``on`` is true. The first
    would make JSON's own numbers unreadable, the others surprise.
    """

    yaml_implicit_resolvers: ClassVar[dict[str, list]] = {}


for _tag, _pattern, _first in (
    ("null", r"~|null|Null|NULL|", ["~", "n", "N", ""]),
    ("bool", r"true|True|TRUE|false|False|FALSE", list("tTfF")),
    ("int", r"[-+]?(?:0|[1-9][0-9]*)", list("-+0123456789")),
    (
        "float",
        r"[-+]?(?:(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][-+]?[0-9]+)?|\.inf)|\.nan",
        list("-+.0123456789"),
    ),
    ("merge", r"<<", ["<"]),
):
    _Loader.add_implicit_resolver(
        f"tag:yaml.org,2002:{_tag}", re.compile(rf"(?:{_pattern})\Z"), _first
    )


def read_yaml(path: str | Path) -> Any:
    """Read the one document of a YAML (or JSON) file; ``-`` reads standard input.

    Raises
    ------
    InputError
        When the file is missing, a folder, unreadable, not text, empty, not YAML (with the line
        number), or repeats a key in a mapping.
    """
    source = "<stdin>" if str(path) == "-" else str(path)
    return parse_yaml(_text(path, source), source)


def parse_yaml(text: str, source: str) -> Any:
    """Parse YAML text; ``source`` names it in error messages. See `read_yaml`."""
    loader = _Loader(text)
    try:
        _refuse_deep_nesting(text, source)
        node = loader.get_single_node()
        if node is None:
            raise InputError(f"{source}: the file is empty; allowed: a mapping of names to values")
        _refuse_duplicates(node, source)
        return loader.construct_document(node)
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        line = f"line {mark.line + 1}, column {mark.column + 1}: " if mark else ""
        raise InputError(f"{source}: {line}not readable as YAML: {error.problem}") from None
    except (yaml.YAMLError, ValueError, LookupError, AttributeError, TypeError) as error:
        # All but the first come from explicit tags that do not fit their values.
        problem = " ".join(str(error).split()).partition(";")[0]
        raise InputError(f"{source}: not readable as YAML: {problem}") from None
    finally:
        loader.dispose()


def _text(path: str | Path, source: str) -> str:
    """Return the file's text, or say in one line why there is none."""
    try:
        data = sys.stdin.buffer.read() if source == "<stdin>" else Path(path).read_bytes()
        text = data.decode("utf-8-sig")
    except FileNotFoundError:
        raise InputError(f"{source}: no such file") from None
    except IsADirectoryError:
        raise InputError(f"{source}: a folder, where a YAML file is expected") from None
    except UnicodeDecodeError:
        raise InputError(f"{source}: not a text file (UTF-8 expected)") from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise InputError(f"{source}: cannot be read: {reason}") from None
    if "\0" in text:
        raise InputError(f"{source}: not a text file (UTF-8 expected)")
    return text


def _refuse_deep_nesting(text: str, source: str) -> None:
    """Raise before the recursive part of the YAML library, which may crash, meets deep nesting."""
    depth = 0
    for event in yaml.parse(text, Loader=_Loader):
        depth += isinstance(event, yaml.CollectionStartEvent)
        depth -= isinstance(event, yaml.CollectionEndEvent)
        if depth > MAX_DEPTH:
            line = event.start_mark.line + 1
            raise InputError(f"{source}: line {line}: nested deeper than {MAX_DEPTH} levels")


def _refuse_duplicates(root: yaml.Node, source: str) -> None:
    """Raise if any mapping repeats a key: YAML would silently keep the last one."""
    pending: list[tuple[yaml.Node, _Path]] = [(root, ())]
    visited: set[int] = set()
    while pending:
        node, path = pending.pop()
        if id(node) in visited:
            continue
        visited.add(id(node))
        if isinstance(node, yaml.SequenceNode):
            pending += [(child, (*path, index)) for index, child in enumerate(node.value)]
        elif isinstance(node, yaml.MappingNode):
            pending += _members(node, path, source)


def _members(node: yaml.MappingNode, path: _Path, source: str) -> list[tuple[yaml.Node, _Path]]:
    """Return a mapping's values with their paths, refusing a repeated key."""
    first_lines: dict[str, int] = {}
    members = []
    for key, value in node.value:
        name = str(key.value) if isinstance(key, yaml.ScalarNode) else "?"
        here = (*path, name)
        if isinstance(key, yaml.ScalarNode):
            line = key.start_mark.line + 1
            if name in first_lines:
                raise InputError(
                    f"{source}: {key_path(here)}: duplicate key on line {line}, "
                    f"first on line {first_lines[name]}; allowed: each key once"
                )
            first_lines[name] = line
        members.append((value, here))
    return members
