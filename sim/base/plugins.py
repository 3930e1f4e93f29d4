"""Plug-ins: a file beside a study, or an installed package, that adds to what Talus knows.

A plug-in is Python code, and loading it runs it. So only those are loaded that a study file names,
or a person (`sim.load_plugins`, ``TALUS_PLUGINS``), never one that results name, and each is told
on standard error. What it adds is known by the hash of its content: edited, it is another.
"""

import hashlib
import os
import re
import sys
import traceback
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from importlib import import_module
from importlib.metadata import entry_points
from importlib.util import find_spec
from pathlib import Path
from types import ModuleType
from typing import Any, NamedTuple

from sim.base.errors import InputError
from sim.base.files import read_regular

#: Where installed packages name their modules.
GROUP = "talus.plugins"

#: Names the plug-ins that every process loads at once, between colons: the jobs of a study do.
VARIABLE = "TALUS_PLUGINS"

#: What a study file may name, and that in words.
PATTERN = r"^[A-Za-z_][A-Za-z0-9_-]*(\.py)?$"
ALLOWED = "a Python file beside the study, as my_law.py, or the name of an installed plug-in"

#: What the name of something that a plug-in adds may be.
NAME = r"^[a-z][a-z0-9_]{0,39}$"

_FILE = ".py"
_CODE_DIGITS = 8

#: The end of a name with a hash.
_PINNED = re.compile(rf"@[0-9a-f]{{{_CODE_DIGITS}}}$")


@dataclass(frozen=True)
class Plugin:
    """A plug-in that is loaded.

    Attributes
    ----------
    name : str
        As the study names it.
    place : str
        What another process loads it by: the file, or the name of the installed one.
    code : str
        Hash of its content.
    """

    name: str
    place: str
    code: str

    @property
    def pinned(self) -> str:
        """How ``TALUS_PLUGINS`` names it as it is now, and not as it may be when it is loaded."""
        return f"{self.place}@{self.code}"

    @property
    def is_file(self) -> bool:
        """Whether it is a file beside a study, and not installed."""
        return self.name.endswith(_FILE)

    def __str__(self) -> str:
        return f"plug-in {self.name} ({self.code})"


@dataclass(frozen=True)
class Addition:
    """Something that a plug-in adds, and the plug-in."""

    value: Any
    plugin: Plugin


class Refused(Exception):
    """What a plug-in adds cannot be added; the message says why."""


_plugins: dict[str, Plugin] = {}
_additions: dict[str, dict[str, Addition]] = {}
_loading: list[Plugin] = []
_listeners: list[Callable[[], None]] = []


def add(kind: str, name: str, value: Any, taken: Iterable[str] = ()) -> None:
    """Add something of a kind under a name; nothing, where no plug-in is being loaded.

    So the file of a plug-in can also be imported like any other.

    Raises
    ------
    Refused
        When the name is none, or in use: by something of Talus (``taken``) or of a plug-in.
    """
    if not re.fullmatch(NAME, name):
        raise Refused(f"{kind} {name!r}: a name has up to 40 letters a-z, digits and _")
    if name in taken:
        raise Refused(f"{kind} {name}: Talus has one of this name")
    if not _loading:
        return
    held = _additions.setdefault(kind, {})
    if name in held:
        other = held[name].plugin
        same = " in this process; start another" if other.name == _loading[-1].name else ""
        raise Refused(f"{kind} {name}: {other} has one of this name{same}")
    held[name] = Addition(value, _loading[-1])


def additions(kind: str) -> dict[str, Addition]:
    """Return what plug-ins have added of a kind, by name."""
    return dict(_additions.get(kind, {}))


def codes(*kinds: str) -> str:
    """Return names and hashes of what is added of kinds: a text that changes when any of it does.

    Empty without any.
    """
    return " ".join(
        f"{name}.{one.plugin.code}"
        for kind in kinds
        for name, one in sorted(additions(kind).items())
    )


def whenever(function: Callable[[], None]) -> None:
    """Call a function now, and whenever what plug-ins add changes."""
    _listeners.append(function)
    function()


def changed() -> None:
    """Tell those who want to know that what plug-ins add has changed."""
    for function in _listeners:
        function()


def fault(kind: str, name: str, error: BaseException, of: str = "") -> InputError:
    """Return the error of something that a plug-in has added as one line, with its place there."""
    plugin = _additions[kind][name].plugin
    return InputError(f"{plugin}: {kind} {name}{of}: {_told(error, Path(plugin.place))}")


@contextmanager
def blamed(kind: str, name: str, of: str = "") -> Iterator[None]:
    """Tell whatever goes wrong in a block as the mistake of something that a plug-in has added."""
    try:
        yield
    except (Exception, SystemExit) as error:
        raise fault(kind, name, error, of) from None


def compile_fault(error: Exception) -> InputError | None:
    """Return what numba could not compile of a plug-in as one line; none for other errors."""
    if not type(error).__module__.startswith("numba."):
        return None
    text = str(error)
    for plugin in _plugins.values():
        place = re.search(rf'File "[^"]*{re.escape(plugin.name)}", line (\d+)', text)
        if place:
            lines = [line.strip() for line in text[: place.start()].splitlines() if line.strip()]
            return InputError(f"{plugin}: line {place[1]}: cannot be compiled: {lines[-1]}")
    return None


def places() -> list[str]:
    """Return what another process loads the plug-ins of this one by, in order."""
    return [one.place for one in _plugins.values()]


def load(names: Iterable[str], folder: Path, source: str) -> tuple[Plugin, ...]:
    """Load plug-ins, those that are loaded already aside, and return them all.

    Parameters
    ----------
    names : iterable of str
        Files in ``folder``, with their suffix, and names of installed plug-ins.
    folder : Path
        Where the files lie.
    source : str
        File and key that name them, for messages: ``study.yaml: plugins``.

    Raises
    ------
    InputError
        For one that is not there, cannot be imported, adds nothing, or a name that is in use.
    """
    found = []
    for index, name in enumerate(names):

        def refused(why: str, index: int = index, name: str = name) -> InputError:
            return InputError.of_value(f"{source}[{index}]", "", name, f"{ALLOWED}; {why}")

        one = _found(name, folder, refused)
        if one.plugin.code not in _plugins:
            _run(one, refused)
        found.append(_plugins[one.plugin.code])
    return tuple(found)


def load_from_environment() -> None:
    """Load the plug-ins that ``TALUS_PLUGINS`` names."""
    for entry in filter(None, os.environ.get(VARIABLE, "").split(os.pathsep)):
        name, _, code = entry.rpartition("@") if _PINNED.search(entry) else (entry, "", "")
        (one,) = load([name], Path(), VARIABLE)
        if code and one.code != code:
            raise InputError(f"{one}: edited since this study was started; start it again")


def load_plugins(*names: str | Path) -> None:
    """Load plug-ins into this process: files, or names of installed ones.

    What they add can then be used in `simulate`, `Flow` and `points`.

    Raises
    ------
    InputError
        For one that is not there, cannot be imported, adds nothing, or a name that is in use.
    """
    load(map(str, names), Path(), "load_plugins")


class _Found(NamedTuple):
    """A plug-in that is not loaded yet: its ``file``, the ``module`` it becomes, and its ``text``.

    That of an installed one is left to Python to find.
    """

    plugin: Plugin
    file: Path
    module: str
    text: bytes | None = None


def _found(name: str, folder: Path, refused: Callable[[str], InputError]) -> _Found:
    """Return a plug-in by the name that a study has for it."""
    if name.endswith(_FILE):
        path = (folder / name).absolute()
        try:
            text = read_regular(path)
        except OSError as error:
            raise refused(f"{path}: {error.strerror or error}") from None
        code = _hash([(path.name, text)])
        # The name is new with each content: types of compiled code are known by it.
        module = f"talus_plugin_{re.sub('[^a-zA-Z0-9]', '_', path.stem)}_{code}"
        return _Found(Plugin(path.name, str(path), code), path, module, text)
    entries = entry_points(group=GROUP)
    if name not in entries.names:
        installed = ", ".join(sorted(entries.names)) or "none"
        raise refused(f"installed: {installed}")
    module = entries[name].module
    spec = find_spec(module.partition(".")[0])
    if spec is None or spec.origin is None:
        raise refused(f"no module {module}")
    file = Path(spec.origin)
    files = file.parent.rglob(f"*{_FILE}") if spec.submodule_search_locations else [file]
    code = _hash((path.name, path.read_bytes()) for path in sorted(files))
    return _Found(Plugin(name, name, code), file, module)


def _hash(files: Iterable[tuple[str, bytes]]) -> str:
    """Return a hash of the names and contents of files."""
    digest = hashlib.sha256()
    for name, text in files:
        digest.update(name.encode() + text)
    return digest.hexdigest()[:_CODE_DIGITS]


def _run(found: _Found, refused: Callable[[str], InputError]) -> None:
    """Run the code of a plug-in, which adds what it has; nothing of it stays after an error."""
    plugin, file, module, text = found
    before = {kind: dict(held) for kind, held in _additions.items()}
    _loading.append(plugin)
    why = ""
    try:
        sys.modules.pop(module, None)
        if text is None:
            import_module(module)
        else:
            # The very text of which the hash is, and no compiled file of an earlier one.
            made = sys.modules[module] = ModuleType(module)
            made.__file__ = str(file)
            exec(compile(text, str(file), "exec"), made.__dict__)
    except Refused as error:
        why = str(error)
    except KeyboardInterrupt:
        raise
    except BaseException as error:
        why = _told(error, file)
    finally:
        _loading.pop()
    new = {kind: held.keys() - before.get(kind, {}).keys() for kind, held in _additions.items()}
    told = [f"{kind} {name}" for kind, names in new.items() for name in sorted(names)]
    if why or not told:
        _additions.clear()
        _additions.update(before)
        sys.modules.pop(module, None)
        raise refused(why or "it adds nothing")
    _plugins[plugin.code] = plugin
    changed()
    print(f"plug-in {plugin.place} ({plugin.code}): {', '.join(told)}", file=sys.stderr)


def _told(error: BaseException, file: Path) -> str:
    """Return an error in words, with the line of a file that it comes from."""
    try:
        words = str(error)
    except Exception:
        words = "an error without words"
    return f"{_line_of(error, file)}{type(error).__name__}: {words}"


def _line_of(error: BaseException, file: Path) -> str:
    """Return where in a file an error comes from."""
    lines = [
        frame.lineno
        for frame in traceback.extract_tb(error.__traceback__)
        if Path(frame.filename) == file
    ]
    return f"line {lines[-1]}: " if lines else ""
