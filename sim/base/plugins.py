"""Plug-ins: a file beside a study, or an installed package, that adds to what Talus knows.

A plug-in is Python code, and loading it runs it. So only those are loaded that a study file names,
or a person (`sim.load_plugins`, ``TALUS_PLUGINS``), never one that results name, and each is told
on standard error. What it adds is known by the hash of its content: edited, it is another.
"""

import hashlib
import os
import re
import sys
from collections.abc import Callable, Iterable
from contextvars import copy_context
from importlib import import_module
from importlib.metadata import entry_points
from importlib.util import find_spec
from pathlib import Path
from types import ModuleType
from typing import NamedTuple

from sim.base.additions import FILE, Plugin, Refused, added_by, adding, changed, words_of
from sim.base.errors import InputError
from sim.base.files import read_regular
from sim.base.process import process_kept
from sim.base.words import printable

#: Where installed packages name their modules.
GROUP = "talus.plugins"

#: Names the plug-ins that every process loads at once, between colons: the jobs of a study do.
VARIABLE = "TALUS_PLUGINS"

#: What a study file may name, and that in words.
PATTERN = r"^[A-Za-z_][A-Za-z0-9_-]*(\.py)?$"
ALLOWED = "a Python file beside the study, as my_law.py, or the name of an installed plug-in"

_CODE_DIGITS = 8

#: The end of a name with a hash.
_PINNED = re.compile(rf"@[0-9a-f]{{{_CODE_DIGITS}}}$")

_plugins: dict[str, Plugin] = {}


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
    if name.endswith(FILE):
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
    files = file.parent.rglob(f"*{FILE}") if spec.submodule_search_locations else [file]
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
    plugin = found.plugin
    try:
        with adding(plugin), process_kept():
            # A context of its own: how NumPy and decimals round and warn stays as it was, too.
            copy_context().run(_execute, found)
            if not (told := added_by(plugin)):
                raise Refused("it adds nothing")
    except KeyboardInterrupt:
        raise
    except BaseException as error:
        sys.modules.pop(found.module, None)
        raise refused(words_of(error, found.file)) from None
    _plugins[plugin.code] = plugin
    changed()
    print(printable(f"plug-in {plugin.place} ({plugin.code}): {', '.join(told)}"), file=sys.stderr)


def _execute(found: _Found) -> None:
    """Run the code of a plug-in as a module."""
    sys.modules.pop(found.module, None)
    if found.text is None:
        import_module(found.module)
        return
    # The very text of which the hash is, and no compiled file of an earlier one.
    made = sys.modules[found.module] = ModuleType(found.module)
    made.__file__ = str(found.file)
    exec(compile(found.text, str(found.file), "exec"), made.__dict__)
