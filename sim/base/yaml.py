"""Strict reading of text and YAML: YAML 1.2 scalars, no duplicate keys, one-line errors."""

import re
import sys
from pathlib import Path
from typing import Any, ClassVar

import yaml

from sim.base.errors import InputError, key_path
from sim.base.numbers import integer, number

# The two loaders read the same YAML; the one written in C may be missing.
_Base: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)

_Path = tuple[str | int, ...]

MAX_BYTES = 1_000_000
MAX_DEPTH = 50
MAX_KEYS = 1_000_000
_MAX_PROBLEM = 200

#: Spaces that YAML takes for letters, as text processors write them.
_ODD_SPACE = re.compile("[\u00a0\u2000-\u200b\u202f\u3000]")

_TAG = "tag:yaml.org,2002:"
_TYPES = ("null", "bool", "str", "seq", "map")

#: Problems as the libraries word them: what a person did, and whether it is where its context is.
_INDENT = (
    "this belongs to nothing: it is indented as nothing above it, or behind a text in quotes; what "
    "belongs together begins in one column",
    False,
)
_OPEN = "a bracket that is not closed, or a comma or a colon missing behind it", True
_MEANINGS = {
    "could not find expected ':'": ("a key without a colon and a space behind it", True),
    "did not find expected key": _INDENT,
    "did not find expected '-' indicator": _INDENT,
    "expected <block end>": _INDENT,
    "did not find expected ',' or": _OPEN,
    "expected ',' or": _OPEN,
    "found unexpected end of stream": ("a quote that is not closed", True),
    "mapping values are not allowed": (
        "a colon where none can be: the line above lacks one with a space behind it, or is "
        "indented otherwise; or a text with ': ' in it needs quotes",
        False,
    ),
}


class _Loader(_Base):
    """Safe loader with the core schema of YAML 1.2: its types, its plain scalars, and merge keys.

    PyYAML follows YAML 1.1, where ``1e3``, a number in JSON, is text, ``010`` is eight and ``on``
    is true.
    """

    yaml_implicit_resolvers: dict[str, list[Any]] = {}
    yaml_constructors: ClassVar[dict[str | None, Any]] = {
        tag: _Base.yaml_constructors[tag] for tag in (*(f"{_TAG}{name}" for name in _TYPES), None)
    }
    keys = 0

    def construct_yaml_int(self, node: yaml.ScalarNode) -> int:
        """Read a decimal integer; YAML 1.1 had other bases too."""
        return integer(self.construct_scalar(node))

    def construct_yaml_float(self, node: yaml.ScalarNode) -> float:
        """Read a decimal number, ``.inf`` or ``.nan``; YAML 1.1 had base 60 too."""
        text = self.construct_scalar(node).lower()
        is_other = text.lstrip("-+") in (".inf", ".nan")
        return float(text.replace(".", "")) if is_other else number(text, or_beyond=True)

    def flatten_mapping(self, node: yaml.MappingNode) -> None:
        """Replace merge keys by the keys they stand for, up to `MAX_KEYS` keys.

        Merges of merges multiply: a few lines can stand for more keys than memory holds.
        """
        super().flatten_mapping(node)
        self.keys += len(node.value)
        if self.keys > MAX_KEYS:
            problem = f"more than {MAX_KEYS:,} keys, those that merge keys stand for included"
            raise yaml.constructor.ConstructorError(None, None, problem, node.start_mark)


_Loader.add_constructor(f"{_TAG}int", _Loader.construct_yaml_int)
_Loader.add_constructor(f"{_TAG}float", _Loader.construct_yaml_float)

for _name, _pattern, _first in (
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
    _Loader.add_implicit_resolver(f"{_TAG}{_name}", re.compile(rf"(?:{_pattern})\Z"), _first)


def read_yaml(path: str | Path) -> Any:
    """Read the one document of a YAML (or JSON) file; ``-`` reads standard input.

    Raises `InputError` when the file is missing, not regular, unreadable, too large, not text,
    empty or not YAML (with the line number), or when a key is repeated or no text.
    """
    source = "<stdin>" if str(path) == "-" else str(path)
    return parse_yaml(_read_text(path, source), source)


def parse_yaml(text: str, source: str) -> Any:
    """Parse YAML text; ``source`` names it in error messages. See `read_yaml`."""
    loader = _Loader(text)
    try:
        _refuse_deep_nesting(text, source)
        node = loader.get_single_node()
        if node is None:
            raise InputError(f"{source}: the file is empty; allowed: a mapping of names to values")
        _refuse_wrong_keys(node, source)
        return loader.construct_document(node)
    except yaml.MarkedYAMLError as error:
        raise InputError(f"{source}: {_cause(text.splitlines(), error)}") from None
    except (yaml.YAMLError, ValueError, LookupError, RecursionError) as error:
        # Explicit tags that do not fit their values and long chains of merge keys raise these.
        problem = " ".join(str(error).split()).partition(";")[0][:_MAX_PROBLEM]
        raise InputError(f"{source}: not readable as YAML: {problem}") from None
    finally:
        loader.dispose()


def _cause(lines: list[str], error: yaml.MarkedYAMLError) -> str:
    """Return what a person did, as far as it can be told, and where."""
    problem, mark = (error.problem or "")[:_MAX_PROBLEM], error.problem_mark or error.context_mark
    if mark:
        last = lines[mark.line] if mark.line < len(lines) else ""
        if last.lstrip(" ").startswith("\t"):
            return f"line {mark.line + 1} begins with a tab; YAML wants spaces"
        for number in (mark.line, mark.line - 1):
            if _ODD_SPACE.search("".join(lines[number : number + 1])):
                return f"line {number + 1} holds a non-breaking space; YAML wants plain ones"
        if problem.startswith("mapping values") and ": " in last[: mark.column]:
            return f"line {mark.line + 1}: a text with a colon and a space needs quotes"
    for beginning, (meaning, is_before) in _MEANINGS.items():
        if problem.startswith(beginning):
            problem, mark = meaning, error.context_mark if is_before else mark
    place = f"line {mark.line + 1}, column {mark.column + 1}: " if mark else ""
    return f"{place}not readable as YAML: {problem}"


def _read_text(path: str | Path, source: str) -> str:
    if source != "<stdin>":
        if Path(path).suffix == ".nc":
            problem = "a netCDF file, where a YAML file is expected"
            raise InputError(f"{source}: {problem}; talus points describes a run")
        return read_text(Path(path), "YAML file", MAX_BYTES)
    data = sys.stdin.buffer.read(MAX_BYTES + 1) if sys.stdin else b""
    return decoded(data, source, MAX_BYTES)


def read_text(path: Path, kind: str, most: int) -> str:
    """Return the text of a file that a user names; ``kind`` is what it should be, for messages.

    Raises ``InputError`` for a file that is missing, no regular one, or cannot be read, and as
    `decoded` does.
    """
    try:
        # Opening a device may have an effect, and reading a device or pipe may never end.
        if path.exists() and not path.is_file():
            what = "a folder" if path.is_dir() else "a device or pipe"
            raise InputError(f"{path}: {what}, where a {kind} is expected")
        with path.open("rb") as file:
            return decoded(file.read(most + 1), str(path), most)
    except FileNotFoundError:
        raise InputError(f"{path}: no such file") from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise InputError(f"{path}: cannot be read: {reason}") from None


def decoded(data: bytes, source: str, most: int) -> str:
    """Return bytes as text; raise ``InputError`` for more than ``most``, and for no text."""
    if len(data) > most:
        raise InputError(f"{source}: larger than {most / 1e6:g} MB")
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError:
        text = "\0"
    if "\0" in text:
        cure = "; a spreadsheet saves one as 'CSV UTF-8'" if source.endswith(".csv") else ""
        raise InputError(f"{source}: not a text file (UTF-8 expected){cure}")
    return text


def _refuse_deep_nesting(text: str, source: str) -> None:
    """Raise `InputError` for deep nesting, on which the recursive part of the library may crash."""
    depth = 0
    for event in yaml.parse(text, Loader=_Loader):
        depth += isinstance(event, yaml.CollectionStartEvent)
        depth -= isinstance(event, yaml.CollectionEndEvent)
        if depth > MAX_DEPTH:
            assert event.start_mark, "events of a parser say where they are"
            line = event.start_mark.line + 1
            raise InputError(f"{source}: line {line}: nested deeper than {MAX_DEPTH} levels")


def _refuse_wrong_keys(root: yaml.Node, source: str) -> None:
    """Raise if a key is not text or comes twice in a mapping; YAML would use its last value."""
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


def _key_problem(key: yaml.Node, before: Any) -> str:
    if isinstance(key, yaml.ScalarNode) and _ODD_SPACE.search(key.value):
        return "a key holds a non-breaking space; YAML wants plain ones"
    problem = "expected text as a key"
    if isinstance(before, str) and "(" in before:
        return f"{problem}; instead of {before}, ...) give a list, a range or a design"
    is_number = isinstance(key, yaml.ScalarNode) and key.tag == f"{_TAG}int"
    return problem + "; a number has a decimal point, not a comma" * is_number


def _members(node: yaml.MappingNode, path: _Path, source: str) -> list[tuple[yaml.Node, _Path]]:
    """Return a mapping's values with their paths; raise for a wrong key."""
    first_lines: dict[str, int] = {}
    members: list[tuple[yaml.Node, _Path]] = []
    for key, value in node.value:
        text = isinstance(key, yaml.ScalarNode) and key.tag in (f"{_TAG}str", f"{_TAG}merge")
        if not text or _ODD_SPACE.search(key.value):
            problem = _key_problem(key, members[-1][0].value if members else "")
            raise yaml.constructor.ConstructorError(None, None, problem, key.start_mark)
        key_location = (*path, key.value)
        line = key.start_mark.line + 1
        if key.value in first_lines:
            raise InputError(
                f"{source}: {key_path(key_location)}: duplicate key on line {line}, "
                f"first on line {first_lines[key.value]}; allowed: each key once"
            )
        first_lines[key.value] = line
        members.append((value, key_location))
    return members
