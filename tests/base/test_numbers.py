"""What a person gives as a number: in texts, by options and settings, and from NumPy."""

import ast
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr

import sim
from sim.base.errors import InputError
from sim.base.measured import parse_table
from sim.base.numbers import integer, number, plain
from sim.base.yaml import parse_yaml
from sim.engine.states import checkpoint_interval
from sim.parameters import parse_python_point, point_id
from sim.report.predict import _value
from tests.made.processes import refusal
from tests.test_rooms import MODULES, PACKAGE

#: Texts that Python takes for numbers, and a person does not.
NO_NUMBERS = ("2_12", "1e5_0", "\N{FULLWIDTH DIGIT TWO}", "nan", "inf", "Infinity")


@pytest.mark.parametrize("text", [*NO_NUMBERS, "1e999", "", "0x10", "1,5", "1 2", "--1", "."])
def test_what_is_no_decimal_number_is_refused(text):
    for read in (number, integer):
        with pytest.raises(ValueError, match="not a"):
            read(text)


@pytest.mark.parametrize("text", ["2", " +2.50 ", "-.5", "3.", "1e-3", "6E+23"])
def test_decimal_numbers_are_those_of_python(text):
    assert number(text) == float(text)


def table(text, monkeypatch, capsys):
    parse_table(f"a\n{text}\n", Path("exp.csv")).numbers("a", "1", low=-1e9, high=1e9)


def setting(text, monkeypatch, capsys):
    monkeypatch.setenv("TALUS_CHECKPOINT_SECONDS", text)
    checkpoint_interval()


def tag(text, monkeypatch, capsys):
    parse_yaml(f"seed: !!float {text}", "study.yaml")
    raise AssertionError(text)


def option(text, monkeypatch, capsys):
    for command, name in (("study", "--cores"), ("status", "--watch"), ("compare", "--share")):
        line = refusal(capsys, command, "study.yaml", f"{name}={text}")
        assert f"Invalid value for '{name}': {text!r} is not a" in line
    raise InputError(line)


@pytest.mark.parametrize("text", NO_NUMBERS)
@pytest.mark.parametrize("door", [table, setting, tag, option])
def test_no_door_reads_what_is_no_number(door, text, monkeypatch, capsys):
    with pytest.raises(InputError):
        door(text, monkeypatch, capsys)


@pytest.mark.parametrize("text", NO_NUMBERS)
def test_at_takes_no_such_text_for_a_number(text):
    assert _value(SimpleNamespace(choices={}), "friction", text) == text


#: Places that read no text of a person, or one that a pattern has let through.
EXCEPTIONS = {
    ("base/files.py", "int(match[1])"),
    ("base/messages.py", "int(match[2] or 1)"),
    ("base/seals.py", "int(words[1])"),
    ("base/yaml.py", "float(text.replace('.', ''))"),
    ("engine/states.py", "int(number)"),
    ("parameters/common.py", "map(float, p.initial_state.split('_')[1:])"),
    ("report/page.py", "map(float, box.split()[2:])"),
}

#: Names of texts, and their methods.
TEXTS = {"text", "word", "words", "match", "written", "raw", "argv", "environ"}
TEXTS |= {"split", "partition", "rpartition", "groups", "replace", "strip"}


def readings(code: str) -> Iterator[str]:
    """Yield where Python itself makes a number of what looks like a text, or an option does.

    A call is one of those in a block that expects ``ValueError``, or on what is named like a text.
    """

    def visit(node: ast.AST, guarded: bool) -> Iterator[str]:
        match node:
            case ast.Try(handlers=handlers):
                guarded = guarded or any("ValueError" in ast.unparse(one) for one in handlers)
            case ast.With(items=items):
                guarded = guarded or any("ValueError" in ast.unparse(one) for one in items)
            case ast.Call(func=ast.Name("int" | "float"), args=[given]) if guarded or is_text(
                given
            ):
                yield ast.unparse(node)
            case ast.Call(func=ast.Name("map"), args=[ast.Name("int" | "float"), given]):
                if guarded or is_text(given):
                    yield ast.unparse(node)
            case ast.Call(args=[*_, ast.Name("int" | "float")]) if "_argument" in ast.unparse(node):
                yield ast.unparse(node)
            case ast.keyword(arg="type", value=ast.Name("int" | "float")):
                yield ast.unparse(node)
        for child in ast.iter_child_nodes(node):
            yield from visit(child, guarded)

    def is_text(given: ast.AST) -> bool:
        named = (getattr(one, "id", getattr(one, "attr", "")) for one in ast.walk(given))
        return not TEXTS.isdisjoint(named)

    return visit(ast.parse(code), False)


@pytest.mark.parametrize(
    "code",
    [
        "try:\n    x = float(y)\nexcept ValueError:\n    pass",
        "with suppress(ValueError):\n    int(y)",
        "float(text)",
        "int(match[1])",
        "list(map(float, line.split()))",
        "_option('--cores', 'N', type=int)",
        "_argument('number', 'ROUND', int)",
        "float(os.environ['X'])",
    ],
)
def test_the_search_finds_readings(code):
    assert len(list(readings(code))) == 1


def test_texts_of_people_become_numbers_in_one_place():
    found = {
        (str(path.relative_to(PACKAGE)), place)
        for path in MODULES
        if path != PACKAGE / "base" / "numbers.py"
        for place in readings(path.read_text(encoding="utf-8"))
    }
    assert found == EXCEPTIONS


STUDY = {
    "study": "s",
    "series": [
        {
            "name": "a",
            "system": "chute",
            "base": {"replicates": 3, "cell": [4, 5], "orientations": False, "law": "hertz"},
            "grid": {"friction": [0.4, 0.1], "depth": [5.0]},
        }
    ],
}


def numpied(value, kinds):
    """Return a study with the numbers, words and switches of NumPy."""
    match value:
        case dict():
            return {key: numpied(one, kinds) for key, one in value.items()}
        case list() if all(isinstance(one, float) for one in value) and kinds["arrays"]:
            return np.array(value, kinds["float"])
        case list():
            return [numpied(one, kinds) for one in value]
    name = type(value).__name__
    return kinds[name](value) if kinds[name] else value


@pytest.mark.parametrize("real", [np.float64, np.float32, np.longdouble, np.array, xr.DataArray])
@pytest.mark.parametrize("arrays", [False, True])
def test_numbers_of_numpy_make_the_same_points(real, arrays):
    arrays = arrays and isinstance(real, type) and issubclass(real, np.generic)
    kinds = {"float": real, "int": np.int64, "bool": np.bool_, "str": np.str_, "arrays": arrays}
    assert list(sim.points(numpied(STUDY, kinds)).index) == list(sim.points(STUDY).index)
    usual = {"friction": 0.4, "replicates": 3, "orientations": False, "law": "hertz"}
    one = parse_python_point("simulate", "chute", usual)
    other = parse_python_point("simulate", np.str_("chute"), numpied(usual, kinds))
    assert point_id(one) == point_id(other) and one == other


def test_a_number_of_numpy_becomes_one_of_python():
    single, half = np.float32(0.1), np.float16(0.1)
    assert plain({"a": (single, [half]), np.str_("b"): np.arange(2)}) == {
        "a": (0.1, [0.1]),
        "b": [0, 1],
    }
    for value in (np.int8(3), np.bool_(True), np.str_("x"), np.array(2), 1.5, None):
        assert type(plain(value)) in (int, bool, str, float, type(None))
