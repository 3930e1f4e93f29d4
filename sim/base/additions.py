"""What plug-ins have added to Talus, by kind and name, and whose mistake an error of it is."""

import inspect
import re
import traceback
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from sim.base.errors import InputError

#: What the name of something that a plug-in adds may be.
NAME = r"^[a-z][a-z0-9_]{0,39}$"

#: An error in a text of numba.
_ERROR = re.compile(r"^\s*(\w+(?:Error|Exception): .*)$", re.MULTILINE)

#: How the name of a plug-in ends that is a file beside a study.
FILE = ".py"


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
        return self.name.endswith(FILE)

    def __str__(self) -> str:
        return f"plug-in {self.name} ({self.code})"


@dataclass(frozen=True)
class Addition:
    """Something that a plug-in adds, and the plug-in."""

    value: Any
    plugin: Plugin


class Refused(Exception):
    """What a plug-in adds cannot be added; the message says why."""


_additions: dict[str, dict[str, Addition]] = {}
_loading: list[Plugin] = []
_listeners: list[Callable[[], None]] = []


@contextmanager
def adding(plugin: Plugin) -> Iterator[None]:
    """Take what is added in a block for that of a plug-in; nothing of it stays after an error."""
    before = {kind: dict(held) for kind, held in _additions.items()}
    _loading.append(plugin)
    try:
        yield
    except BaseException:
        _additions.clear()
        _additions.update(before)
        raise
    finally:
        _loading.pop()


def add(kind: str, name: str, value: Any, taken: Iterable[str] = ()) -> None:
    """Add something of a kind under a name; nothing, where no plug-in is being loaded.

    So the file of a plug-in can also be imported like any other.

    Raises
    ------
    Refused
        When the name is none, or in use: by something of Talus (``taken``) or of a plug-in.
    """
    require_name(kind, name)
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


def require_name(kind: str, name: Any) -> None:
    """Refuse what can be no name of something that a plug-in adds."""
    if not (isinstance(name, str) and re.fullmatch(NAME, name)):
        raise Refused(f"{kind} {name!r}: a name has up to 40 letters a-z, digits and _")


def added_by(plugin: Plugin) -> list[str]:
    """Return kinds and names of what a plug-in has added."""
    return [
        f"{kind} {name}"
        for kind, held in _additions.items()
        for name, one in sorted(held.items())
        if one.plugin == plugin
    ]


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
    return InputError(f"{plugin}: {kind} {name}{of}: {words_of(error, Path(plugin.place))}")


@contextmanager
def blamed(kind: str, name: str, of: str = "") -> Iterator[None]:
    """Tell whatever goes wrong in a block as the mistake of something that a plug-in has added."""
    try:
        yield
    except (Exception, SystemExit) as error:
        raise fault(kind, name, error, of) from None


def code_fault(error: Exception) -> InputError | None:
    """Return what is wrong with code of a plug-in as one line; none for other errors.

    That is what numba could not compile, or what compiled code has raised.
    """
    every = [one for held in _additions.values() for one in held.values()]
    if type(error).__module__.startswith("numba."):
        return next(filter(None, (_uncompiled(one, str(error)) for one in every)), None)
    last = Path(traceback.extract_tb(error.__traceback__)[-1].filename)
    blamed_for = [one.plugin for one in every if Path(one.plugin.place) == last]
    return InputError(f"{blamed_for[0]}: {words_of(error, last)}") if blamed_for else None


def _uncompiled(one: Addition, text: str) -> InputError | None:
    """Return the line that says why something could not be compiled, if it is what numba tells."""
    place = re.search(rf'File "[^"]*{re.escape(one.plugin.name)}", line (\d+)', text)
    if place:
        lines = [line.strip() for line in text[: place.start()].splitlines() if line.strip()]
        return InputError(f"{one.plugin}: line {place[1]}: cannot be compiled: {lines[-1]}")
    # Of names that are not defined numba tells no place, but the function.
    for function in filter(inspect.isfunction, vars(one.value).values()):
        if f"<function {function.__name__} at {id(function):#x}>" in text:
            line, errors = function.__code__.co_firstlineno, _ERROR.findall(text)
            return InputError(f"{one.plugin}: line {line}: cannot be compiled: {errors[-1]}")
    return None


def words_of(error: BaseException, file: Path) -> str:
    """Return an error in words, with the line of a file that it comes from."""
    try:
        words = str(error)
    except Exception:
        words = "an error without words"
    kind = "" if isinstance(error, Refused) else f"{type(error).__name__}: "
    return f"{_line_of(error, file)}{kind}{words}"


def _line_of(error: BaseException, file: Path) -> str:
    """Return where in a file an error comes from."""
    lines = [
        frame.lineno
        for frame in traceback.extract_tb(error.__traceback__)
        if Path(frame.filename) == file
    ]
    return f"line {lines[-1]}: " if lines else ""
