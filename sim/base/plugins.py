"""Plug-ins: a file or folder beside a study, or an installed package, adding to what Talus knows.

A plug-in is Python code, and loading it runs it. Only a study file or a person
(`talus.load_plugins`, ``TALUS_PLUGINS``) can name plug-ins; results cannot. Each one loaded is
reported on standard error. Its additions are identified by the hash of its content.
"""

import hashlib
import os
import re
import sys
from collections.abc import Callable, Collection, Iterable
from functools import cache
from importlib import import_module
from importlib.metadata import EntryPoint, entry_points
from importlib.util import find_spec
from inspect import signature
from pathlib import Path
from pkgutil import iter_modules
from types import ModuleType
from typing import Annotated, Any, NamedTuple, TypeVar

from pydantic import BaseModel, BeforeValidator, ConfigDict, TypeAdapter, ValidationError
from pydantic_core import PydanticCustomError

from sim.base.additions import (
    FILE,
    TALUS,
    AdditionError,
    Plugin,
    addition_labels,
    attribute_additions_to,
    error_text,
    notify_listeners,
)
from sim.base.errors import InputError, count_text, in_short, key_path, printable
from sim.base.files import read_regular
from sim.base.messages import input_error, near

#: Entry-point group in which installed packages name their modules.
GROUP = "talus.plugins"

#: Environment variable with the plug-ins that each process loads at its start, separated by colons.
#: The workflow sets it for the jobs of a study.
VARIABLE = "TALUS_PLUGINS"

#: Pattern of a plug-in's name in a study file, and the same in words.
PATTERN = r"^[A-Za-z_][A-Za-z0-9_-]*(\.py)?$"
ALLOWED = (
    "a Python file beside the study, as my_law.py, a folder there with an __init__.py, or the name "
    "of an installed plug-in"
)

#: Beginning of the line by which a process says on standard error which plug-in it has loaded.
NOTICE = "plug-in "

_CODE_DIGITS = 8

#: The file of a folder that is run.
_INIT = "__init__.py"

#: Ending of a name with a hash.
_PINNED = re.compile(rf"@[0-9a-f]{{{_CODE_DIGITS}}}$")

_plugins: dict[str, Plugin] = {}


def places() -> list[str]:
    """Return the places of the loaded plug-ins, in order, for another process to load them."""
    return [plugin.place for plugin in _plugins.values()]


def load(names: Iterable[str], folder: Path, source: str) -> tuple[Plugin, ...]:
    """Load those plug-ins that are not loaded yet, and return all of them.

    They are files in ``folder``, with their suffix, folders there, and names of installed plug-ins.
    ``source`` is the file and key that name them, for messages: ``study.yaml: plugins``.

    Raises
    ------
    InputError
        When one is missing, cannot be imported, adds nothing, or adds a name that is in use.
    """
    loaded = []
    for index, name in enumerate(names):

        def error_of(why: str, index: int = index, name: str = name) -> InputError:
            return InputError.of_value(f"{source}[{index}]", "", name, f"{ALLOWED}; {why}")

        source_code = _find(name, folder, error_of)
        if source_code.plugin.code not in _plugins:
            _run(source_code, error_of)
        loaded.append(_plugins[source_code.plugin.code])
    return tuple(loaded)


def load_from_environment() -> None:
    """Load the plug-ins that ``TALUS_PLUGINS`` names."""
    for entry in filter(None, os.environ.get(VARIABLE, "").split(os.pathsep)):
        name, _, code = entry.rpartition("@") if _PINNED.search(entry) else (entry, "", "")
        (plugin,) = load([name], Path(), VARIABLE)
        if code and plugin.code != code:
            raise InputError(f"{plugin}: edited since this study was started; start it again")


def module_names(package: str) -> tuple[str, ...]:
    """Return the names of the modules and packages in a package of Talus, sorted."""
    return tuple(sorted(module.name for module in iter_modules([str(_folder_of(package))])))


def _folder_of(package: str) -> Path:
    return Path(__file__).parents[2].joinpath(*package.split("."))


def load_shipped(package: str) -> None:
    """Import the modules of a package of Talus, which add to it by the calls that plug-ins make.

    Raises `InputError` for a call of a module that is refused, or lacks an argument, with its line
    there.
    """
    with attribute_additions_to(TALUS):
        for name in module_names(package):
            try:
                import_module(f"{package}.{name}")
            except (AdditionError, TypeError) as error:
                file = _folder_of(package) / f"{name}.py"
                raise InputError(f"{file}: {error_text(error, file)}") from None


def load_plugins(*names: str | Path) -> None:
    """Load plug-ins into this process: files, or names of installed ones; see `load`.

    Their additions can then be used in `simulate`, `Flow` and `points`.
    """
    load(map(str, names), Path(), "load_plugins")


class _SourceCode(NamedTuple):
    """The code of a plug-in: its ``file``, the name of its ``module``, and its ``text``.

    The text of an installed plug-in is None: Python imports it. Lines of errors are sought in the
    ``place``, the file or the folder.
    """

    plugin: Plugin
    file: Path
    module: str
    place: Path
    text: bytes | None = None


def _contents(folder: Path) -> tuple[Path, ...]:
    """Return the files in a folder that are neither hidden nor made by Python."""
    places = {one: one.relative_to(folder).parts for one in sorted(folder.rglob("*"))}
    return tuple(
        one
        for one, parts in places.items()
        if one.is_file() and not any(part[0] == "." or part == "__pycache__" for part in parts)
    )


def _find(name: str, folder: Path, error_of: Callable[[str], InputError]) -> _SourceCode:
    """Return the code of a plug-in by its name; ``error_of`` turns a reason into an error."""
    place = (folder / name).absolute()
    file, entries = place, entry_points(group=GROUP)
    if not name.endswith(FILE):
        if name in entries.names:
            return _installed(name, entries[name], error_of)
        file = place / _INIT
        if not file.is_file():
            raise error_of(f"installed: {near(name, sorted(entries.names)) or 'none'}")
    root, files = place, _contents(place)
    if file == place:
        root, files = place.parent, (file,)
    try:
        texts = {one: read_regular(one) for one in files}
    except OSError as error:
        raise error_of(f"{error.filename or place}: {error.strerror or error}") from None
    code = _hash((str(one.relative_to(root)), text) for one, text in texts.items())
    # Each content has its own module name, by which types of compiled code are told apart.
    module = f"talus_plugin_{re.sub('[^a-zA-Z0-9]', '_', place.stem)}_{code}"
    plugin = Plugin(place.name, str(place), code, files)
    return _SourceCode(plugin, file, module, place, texts[file])


def _installed(name: str, entry: EntryPoint, error_of: Callable[[str], InputError]) -> _SourceCode:
    module = entry.value
    try:
        module = entry.module
        spec = find_spec(module.partition(".")[0])
        if spec is None or spec.origin is None:
            raise error_of(f"no module {module}")
        file = Path(spec.origin)
        files = file.parent.rglob(f"*{FILE}") if spec.submodule_search_locations else [file]
        code = _hash((path.name, read_regular(path)) for path in sorted(files))
    except (OSError, ValueError, AttributeError) as error:
        raise error_of(f"{module}: {error}") from None
    return _SourceCode(Plugin(name, name, code), file, module, file)


def _hash(files: Iterable[tuple[str, bytes]]) -> str:
    digest = hashlib.sha256()
    for name, text in files:
        digest.update(name.encode() + text)
    return digest.hexdigest()[:_CODE_DIGITS]


def _run(source_code: _SourceCode, error_of: Callable[[str], InputError]) -> None:
    plugin = source_code.plugin
    try:
        with attribute_additions_to(plugin):
            _execute(source_code)
            if not (labels := addition_labels(plugin)):
                raise AdditionError("it adds nothing")
    except KeyboardInterrupt:
        raise
    except BaseException as error:
        sys.modules.pop(source_code.module, None)
        raise error_of(error_text(error, source_code.place)) from None
    _plugins[plugin.code] = plugin
    notify_listeners()
    print(
        printable(f"{NOTICE}{plugin.place} ({plugin.code}): {', '.join(labels)}"), file=sys.stderr
    )


def _execute(source_code: _SourceCode) -> None:
    # With the modules of a folder, which add to Talus as they are imported.
    for name in [one for one in sys.modules if f"{one}.".startswith(f"{source_code.module}.")]:
        del sys.modules[name]
    if source_code.text is None:
        import_module(source_code.module)
        return
    # Exactly the hashed text is run, never a compiled file of an earlier one.
    module = sys.modules[source_code.module] = ModuleType(source_code.module)
    module.__file__ = str(source_code.file)
    if source_code.file != source_code.place:
        module.__path__ = [str(source_code.place)]
    exec(compile(source_code.text, str(source_code.file), "exec"), module.__dict__)


_Dataclass = TypeVar("_Dataclass")
_Model = TypeVar("_Model", bound=BaseModel)

#: Largest number of letters in a text of a plug-in.
LONGEST = 200

#: Units that a plug-in may name, with a prefix of the SI where they have one.
_UNITS = "m g s A K mol cd rad degree Hz N Pa J W C V F ohm S T H degC percent min h day"
_UNIT = rf"(1|(da|[yzafpnuµmcdhkMGTPEZY])?({_UNITS.replace(' ', '|')})((\^|\*\*)?-?[1-9])?)"
_PRODUCT = re.compile(rf"{_UNIT}( ?[ ./*] ?{_UNIT})*")


class Declared(BaseModel):
    """What a plug-in declares, whose types are the checks; see `declared`."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True, allow_inf_nan=True)


def declared(model: type[_Model], what: str, **fields: Any) -> _Model:
    """Return a model with these fields; `AdditionError` names the first wrong one in one line."""
    try:
        return model(**fields)
    except ValidationError as error:
        missing = [str(one["loc"][0]) for one in error.errors() if one["type"] == "missing"]
        text = (
            f"{what}: without {', '.join(missing)}" if missing else input_error(error, model, what)
        )
        raise AdditionError(str(text)) from None


def allowed(words: str, holds: Callable[[Any], object]) -> BeforeValidator:
    """Return the part of a type that refuses what does not hold; ``words`` say what is allowed."""

    def check(value: Any) -> Any:
        if not holds(value):
            context = {"key": "", "got": [value], "allowed": words}
            raise PydanticCustomError("rule", "{allowed}", context)
        return value

    return BeforeValidator(check)


def takes(number: int) -> BeforeValidator:
    """Return the part of a type that refuses what is no function of so many arguments."""
    words = f"a function of {count_text(number, 'argument')}"
    return allowed(words, lambda one: callable(one) and _can_take(one, number))


def one_line(longest: int = LONGEST) -> BeforeValidator:
    """Return the part of a type that refuses what is no line of text of so many letters."""
    return allowed(
        f"one line of text, at most {longest} letters, without control characters or direction "
        "marks",
        lambda text: isinstance(text, str) and text.isprintable() and len(text) <= longest,
    )


#: Part of a type that refuses empty text.
NOT_EMPTY = allowed("text, not empty", bool)

#: Text on one line, and not empty; a unit that UDUNITS reads; names.
Line = Annotated[str, one_line()]
Words = Annotated[Line, NOT_EMPTY]
Unit = Annotated[
    str,
    allowed(
        "1 for a pure number, or a product of powers as kg m s-2, of " + ", ".join(_UNITS.split()),
        lambda unit: isinstance(unit, str) and _PRODUCT.fullmatch(unit),
    ),
]
Names = Annotated[
    tuple[str, ...],
    allowed(
        "a tuple of names",
        lambda names: isinstance(names, tuple) and all(isinstance(one, str) for one in names),
    ),
]

_adapter = cache(TypeAdapter)


def with_declared_types(what: str, one: _Dataclass) -> _Dataclass:
    """Return a dataclass whose values have the declared types; refuse what cannot have them."""
    model: Any = type(one)
    try:
        valid: _Dataclass = _adapter(model).validate_python(vars(one))
        return valid
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        words = first["msg"].removeprefix("Input should be ").replace("Field required", "one more")
        got, path = in_short(first["input"]), key_path(first["loc"])
        raise AdditionError(f"{what}.{path}: got {got}; allowed: {words}") from None


def require_function(what: str, function: Any, takes: int, named: Collection[str] = ()) -> None:
    """Refuse anything that cannot be called with ``takes`` arguments and those of some names."""
    if not callable(function):
        raise AdditionError(f"{what} is a function: got {in_short(function)}")
    if not _can_take(function, takes, named):
        names = ", ".join([count_text(takes, "argument"), *named])
        raise AdditionError(f"{what} takes {names}: got {in_short(str(signature(function)))}")


def _can_take(function: Callable[..., Any], number: int, named: Collection[str] = ()) -> bool:
    try:
        signature(function).bind(*range(number), **dict.fromkeys(named))
    except TypeError:
        return False
    except ValueError:
        pass  # a function written in C may have no signature
    return True


def require_one_of(what: str, value: Any, choices: Collection[str]) -> None:
    """Refuse anything but one of the choices."""
    if not (isinstance(value, str) and value in choices):
        options = near(str(value), choices)
        raise AdditionError(f"{what} is one of {options}: got {in_short(value)}")
