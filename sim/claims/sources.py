"""The plug-ins of a study, checked whole before anything runs: judges are called at the end."""

import ast
import builtins
import dis
import sys
from collections.abc import Collection, Iterable, Iterator
from inspect import isfunction
from pathlib import Path
from types import CodeType, ModuleType

from sim.base.additions import Plugin, additions
from sim.base.errors import InputError
from sim.base.messages import one_of
from sim.claims.claim import declare_claims
from sim.parameters import SYSTEMS
from sim.parameters.variables import observables, reserved_names
from sim.study.figure_spec import FIGURES
from sim.study.papers import PAPER, Paper


def require_plugins(plugins: Iterable[Plugin]) -> None:
    """Refuse the first mistake in the code of plug-ins, and in the files of their papers.

    Raises `InputError` for a name in a function that nothing defines, a parameter or number that
    judges ask for and none has, and for a wrong value, figure of the headline, claim or judge of a
    paper.
    """
    every = tuple(plugins)
    added: list[Paper] = [one.value for one in additions(PAPER).values() if one.plugin in every]
    for paper in added:
        _require_headline(paper)
        # Its values are read when they are asked for.
        _ = paper.values
        declare_claims(paper)
    files = {file for plugin in every for file in plugin.files}
    for module in list(sys.modules.values()):
        if (file := Path(getattr(module, "__file__", None) or "")) in files:
            _require_names(module, file)
            _require_known(file)


def _require_headline(paper: Paper) -> None:
    own = [name for name, spec in FIGURES.items() if spec.paper.startswith(f"{paper.quote}, ")]
    for number, name in enumerate(paper.headline):
        if name not in own:
            path = paper.folder / "paper.yaml"
            raise InputError.of_value(path, f"headline[{number}]", name, one_of(name, own))


def _require_names(module: ModuleType, file: Path) -> None:
    """Refuse a name in a function of a module that is neither there nor one of Python's."""
    functions = [one for one in vars(module).values() if isfunction(one)]
    codes = [one.__code__ for one in functions if one.__module__ == module.__name__]
    used = [one for code in codes for one in _globals(code)]
    known = {*vars(module), *vars(builtins), *(name for name, _, is_set in used if is_set)}
    for name, line, _ in used:
        if name not in known:
            raise InputError(f"{file}: line {line}: NameError: name {name!r} is not defined")


def _require_known(file: Path) -> None:
    """Refuse a system, parameter or number that a judge asks evidence for and that none has."""
    numbers = reserved_names() | observables().keys()
    for node in ast.walk(ast.parse(file.read_text("utf-8"))):
        match node:
            case ast.Call(
                func=ast.Attribute(value=ast.Name(id="evidence"), attr="at" | "line"),
                args=[ast.Constant(value=str() as system), *along],
                keywords=where,
            ):
                _require_one_of(file, node, system, SYSTEMS)
                names = [one.value for one in along if isinstance(one, ast.Constant)]
                for name in map(str, names + [one.arg for one in where if one.arg]):
                    _require_one_of(file, node, name, SYSTEMS[system].model_fields)
            case ast.Call(
                func=ast.Attribute(attr="value" | "values"),
                args=[ast.Constant(value=str() as name), *_],
            ):
                _require_one_of(file, node, name, numbers)


def _require_one_of(file: Path, node: ast.Call, name: str, names: Collection[str]) -> None:
    if name not in names:
        raise InputError.of_value(f"{file}: line {node.lineno}", "", name, one_of(name, names))


def _globals(code: CodeType) -> Iterator[tuple[str, int, bool]]:
    """Yield the global names in a function, each with its line and whether it is set there."""
    line = code.co_firstlineno
    for one in dis.get_instructions(code):
        line = (one.positions and one.positions.lineno) or line
        if one.opname.endswith("_GLOBAL"):
            yield one.argval, line, one.opname == "STORE_GLOBAL"
    for inner in code.co_consts:
        if isinstance(inner, CodeType):
            yield from _globals(inner)
