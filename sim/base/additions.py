"""A registry of what plug-ins add to Talus, by kind and name; errors are attributed to plug-ins."""

import ast
import hashlib
import inspect
import re
import traceback
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

from sim.base.errors import InputError

#: Pattern of the name of an addition.
NAME = r"^[a-z][a-z0-9_]{0,39}$"

#: A line of a message of numba that names an error.
_ERROR = re.compile(r"^\s*(\w+(?:Error|Exception): .*)$", re.MULTILINE)

#: Suffix of plug-ins that are files beside a study.
FILE = ".py"


@dataclass(frozen=True)
class Plugin:
    """A loaded plug-in, with its ``name`` in the study file and a hash of its content, ``code``.

    By its ``place``, path of its file or folder or name of the installed package, another process
    loads it. It has ``files`` where it stands beside a study; an installed one has none.
    """

    name: str
    place: str
    code: str
    files: tuple[Path, ...] = ()

    @property
    def pinned_name(self) -> str:
        """Entry of ``TALUS_PLUGINS`` with its hash, so that a later edit is noticed."""
        return f"{self.place}@{self.code}"

    def __str__(self) -> str:
        return f"plug-in {self.name} ({self.code})"


class Addition(NamedTuple):
    """A value that a plug-in adds, with the plug-in and those of its files that declare it."""

    value: Any
    plugin: Plugin
    declared_in: frozenset[Path] = frozenset()


class AdditionError(Exception):
    """An addition of a plug-in is refused; the message says why."""


#: Talus itself, whose files add by the same calls; points name its options without a hash.
TALUS = Plugin("Talus", "", "")

_additions: dict[str, dict[str, Addition]] = {}
_shipped: dict[str, dict[str, Any]] = {}
_loading: list[Plugin] = []
_listeners: list[Callable[[], None]] = []


@contextmanager
def attribute_additions_to(plugin: Plugin) -> Iterator[None]:
    """Attribute the additions of a block to a plug-in; an error removes all of them."""
    before = {kind: dict(entries) for kind, entries in _additions.items()}
    _loading.append(plugin)
    try:
        yield
    except BaseException:
        _additions.clear()
        _additions.update(before)
        raise
    finally:
        _loading.pop()


def add(kind: str, name: str, value: Any, reserved: Iterable[str] = ()) -> None:
    """Add a value of a kind under a name.

    Outside the loading of a plug-in this adds nothing: its file can be imported as usual. Raises
    `AdditionError` when the name is not valid, or in use: by Talus (``reserved``) or by a plug-in.
    """
    require_name(kind, name)
    if is_of_talus():
        _shipped.setdefault(kind, {})[name] = value
        return
    if name in reserved or name in _shipped.get(kind, {}):
        raise AdditionError(f"{kind} {name}: Talus has one of this name")
    if not _loading:
        return
    entries = _additions.setdefault(kind, {})
    if name in entries:
        other = entries[name].plugin
        same = " in this process; start another" if other.name == _loading[-1].name else ""
        raise AdditionError(f"{kind} {name}: {other} has one of this name{same}")
    entries[name] = Addition(value, _loading[-1], _declaring_files(_loading[-1]))


def is_of_talus() -> bool:
    """True while files of Talus itself are loaded."""
    return bool(_loading) and _loading[-1] is TALUS


def require_name(kind: str, name: Any) -> None:
    """Raise `AdditionError` for an invalid name of an addition; Talus itself is free to choose."""
    if not (is_of_talus() or (isinstance(name, str) and re.fullmatch(NAME, name))):
        raise AdditionError(f"{kind} {name!r}: a name has up to 40 letters a-z, digits and _")


def addition_labels(plugin: Plugin) -> list[str]:
    """Return ``kind name`` of each addition of a plug-in."""
    return [
        f"{kind} {name}"
        for kind, entries in _additions.items()
        for name, addition in sorted(entries.items())
        if addition.plugin == plugin
    ]


def additions(kind: str) -> dict[str, Addition]:
    """Return the additions of plug-ins of a kind, by name."""
    return dict(_additions.get(kind, {}))


def plugin_options(kind: str) -> dict[str, Any]:
    """Return the values of a kind that plug-ins add, by the names that points have for them."""
    return {f"{name}.{option_code(one)}": one.value for name, one in additions(kind).items()}


#: File by which a folder is that of a paper; and names by which code reaches further files.
PAPER_FILE = "paper.yaml"
_REACHES = {"__file__", "__path__", "__spec__", "__import__", "import_module", "open", "resources"}


def option_code(addition: Addition) -> str:
    """Return the hash by which points name a law, a motion or an engine of a plug-in.

    It is that of the plug-in. In the folder of a paper it is that of the modules that declare it or
    have its functions, with those that they import there: an edit of a judge makes no other points.
    """
    plugin, held = addition.plugin, vars(addition.value).values()
    own = {Path(one.__code__.co_filename) for one in held if inspect.isfunction(one)}
    return _code_of(plugin, frozenset(own & {*plugin.files} | addition.declared_in))


@cache
def _code_of(plugin: Plugin, files: frozenset[Path]) -> str:
    folder, found, rest = Path(plugin.place), set[Path](), [*files]
    if folder / PAPER_FILE not in plugin.files:
        return plugin.code
    while rest:
        found.add(file := rest.pop())
        for node in ast.walk(ast.parse(file.read_bytes())):
            if _REACHES & {getattr(node, key, None) for key in ("id", "attr", "name")}:
                return plugin.code
            if isinstance(node, ast.ImportFrom) and node.level:
                rest += {*_imported(file, node)} & {*plugin.files} - found
    digest = hashlib.sha256()
    for file in sorted(found):
        digest.update(file.relative_to(folder).as_posix().encode() + file.read_bytes())
    return digest.hexdigest()[: len(plugin.code)]


def _imported(file: Path, node: ast.ImportFrom) -> Iterator[Path]:
    """Yield the files that a relative import in a file may mean."""
    base = file.parents[node.level - 1].joinpath(*(node.module or "").split("."))
    for place in (base, *(base / one.name for one in node.names)):
        yield from (place.with_name(f"{place.name}{FILE}"), place / "__init__.py")


def _declaring_files(plugin: Plugin) -> frozenset[Path]:
    """Return the files of a plug-in whose code is at work, up to what imports them."""
    files, frame = set[Path](), inspect.currentframe()
    while frame and not frame.f_code.co_filename.startswith("<frozen importlib"):
        files.add(Path(frame.f_code.co_filename))
        frame = frame.f_back
    return frozenset(files & {*plugin.files})


def plain_name(option: str) -> str:
    """Return the name of an option of a plug-in without the hash."""
    return option.rpartition(".")[0] or option


def shipped(kind: str) -> Mapping[str, Any]:
    """Return the values of a kind that Talus itself adds, by name."""
    return _shipped.get(kind, {})


def codes(*kinds: str) -> str:
    """Return names and plug-in hashes of all additions of some kinds, as one text.

    The text changes with the code of any of these plug-ins; it is empty without additions.
    """
    return " ".join(
        f"{name}.{addition.plugin.code}"
        for kind in kinds
        for name, addition in sorted(additions(kind).items())
    )


def on_change(function: Callable[[], None]) -> None:
    """Call a function now, and again after every change of the additions."""
    _listeners.append(function)
    function()


def notify_listeners() -> None:
    """Call the functions that `on_change` has registered."""
    for function in _listeners:
        function()


def plugin_error(kind: str, name: str, error: BaseException, of: str = "") -> InputError:
    """Return an error of an addition as one line with its plug-in and the line there, if known."""
    plugin = _additions[kind][name].plugin
    return InputError(f"{plugin}: {kind} {name}{of}: {error_text(error, Path(plugin.place))}")


@contextmanager
def attribute_errors_to(kind: str, name: str, of: str = "") -> Iterator[None]:
    """Raise any error of a block as an `InputError` that names an addition and its plug-in.

    Errors of what Talus itself adds stay as they are.
    """
    try:
        yield
    except (Exception, SystemExit) as error:
        if name in shipped(kind):
            raise
        raise plugin_error(kind, name, error, of) from None


def plugin_code_error(error: Exception) -> InputError | None:
    """Return an error of a plug-in's compiled code as one line, None for other errors.

    Numba could not compile the code, or the compiled code raised the error.
    """
    every = [addition for entries in _additions.values() for addition in entries.values()]
    if type(error).__module__.startswith("numba."):
        return next(
            filter(None, (_compile_error(addition, str(error)) for addition in every)), None
        )
    last = Path(traceback.extract_tb(error.__traceback__)[-1].filename)
    plugins = [addition.plugin for addition in every if last in addition.plugin.files]
    return InputError(f"{plugins[0]}: {error_text(error, last)}") if plugins else None


def _compile_error(addition: Addition, text: str) -> InputError | None:
    """Return why an addition does not compile, None where numba's text is of another."""
    plugin = addition.plugin
    place = re.search(rf'File "[^"]*{re.escape(plugin.name)}", line (\d+)', text)
    if place:
        lines = [line.strip() for line in text[: place.start()].splitlines() if line.strip()]
        return InputError(f"{plugin}: line {place[1]}: cannot be compiled: {lines[-1]}")
    # For an undefined name numba gives the function, not the line.
    for function in filter(inspect.isfunction, vars(addition.value).values()):
        if f"<function {function.__name__} at {id(function):#x}>" in text:
            line, errors = function.__code__.co_firstlineno, _ERROR.findall(text)
            return InputError(f"{plugin}: line {line}: cannot be compiled: {errors[-1]}")
    return None


def error_text(error: BaseException, place: Path) -> str:
    """Return type and message of an error, after the line that raised it in a file or a folder.

    An `InputError` says by itself where it comes from.
    """
    if isinstance(error, InputError):
        return str(error)
    try:
        words = str(error)
    except (Exception, SystemExit):
        words = "an error without words"
    kind = "" if isinstance(error, AdditionError) else f"{type(error).__name__}: "
    return f"{_line_of(error, place)}{kind}{words}"


def _line_of(error: BaseException, place: Path) -> str:
    """Return ``line N: `` for the last line of a file in a traceback, ``""`` where it has none.

    Of a folder it is the last line of any file in it, after the name of that file.
    """
    for frame in reversed(traceback.extract_tb(error.__traceback__)):
        file = Path(frame.filename)
        if file == place:
            return f"line {frame.lineno}: "
        if file.is_relative_to(place):
            return f"{file.relative_to(place)} line {frame.lineno}: "
    return ""
