"""Keys of a study file: ranges of values, and hints at the intended value in messages."""

from pathlib import Path

import pytest

from sim.base.errors import InputError
from sim.base.yaml import read_yaml
from sim.study.entries import MAX_VALUES, expand_range
from sim.study.load import parse_study


def error_message(**series) -> str:
    mapping = {"study": "s", "series": [{"name": "a", "system": "chute"} | series]}
    with pytest.raises(InputError) as caught:
        parse_study(mapping, "s.yaml", None)
    return str(caught.value).removeprefix("s.yaml: series[0].")


@pytest.mark.parametrize(
    ("series", "message"),
    [
        (
            {"base": {"friction": [0.3, 0.4]}},
            "base.friction: got [0.3, 0.4]; allowed: a number >= 0; a list of values belongs under "
            "grid",
        ),
        (
            {"grid": {"frequency": [3]}},
            "grid.frequency: unknown key, got [3]; frequency is a parameter of the belt and the "
            "conveyor",
        ),
        (
            {"friction": 3},
            "friction: unknown key, got 3; parameters belong under base, grid or cases",
        ),
        (
            {"figures": ["gallas_1a"]},
            "figures[0]: got 'gallas_1a'; allowed: a figure of the chute; gallas_1a is one of the "
            "belt",
        ),
        (
            {"base": {"friction": "0,3"}},
            "base.friction: got '0,3'; allowed: a number >= 0; a number has a decimal point, not a "
            "comma",
        ),
    ],
)
def test_a_message_says_what_was_meant(series, message):
    assert error_message(**series) == message


@pytest.mark.parametrize(
    ("others", "message"),
    [
        (
            {"decide": {"budget": 1, "claims": ["ZZ"]}},
            "decide.claims[0]: got 'ZZ'; allowed: W1 to W26, G1 to G36, all, or the name of a "
            "judge of a plug-in",
        ),
        ({"parts": [1]}, "parts[0]: got 1; allowed: a file's name"),
    ],
)
def test_a_message_on_an_entry_of_a_list_says_what_an_entry_may_be(others, message):
    mapping = {"study": "s", "series": [{"name": "a", "system": "chute"}]} | others
    with pytest.raises(InputError) as caught:
        parse_study(mapping, "s.yaml", None)
    assert str(caught.value) == f"s.yaml: {message}"


def test_a_decimal_comma_within_braces_is_told(tmp_path: Path):
    path = tmp_path / "s.yaml"
    path.write_text("base: {friction: 0,3}\n")
    with pytest.raises(InputError, match="expected text as a key; a number has a decimal point"):
        read_yaml(path)


def points(grid: dict) -> list[str]:
    series = {"name": "a", "system": "chute", "grid": grid}
    return list(parse_study({"study": "s", "series": [series]}, "s.yaml", None).points)


@pytest.mark.parametrize(
    ("range_mapping", "values"),
    [
        ({"start": 0.3, "stop": 0.6, "step": 0.1}, [0.3, 0.4, 0.5, 0.6]),
        ({"start": 0.3, "stop": 0.65, "step": 0.1}, [0.3, 0.4, 0.5, 0.6]),
        ({"start": 0.6, "stop": 0.4, "step": -0.1}, [0.6, 0.5, 0.4]),
        ({"start": 1, "stop": 2, "num": 5}, [1, 1.25, 1.5, 1.75, 2]),
    ],
)
def test_a_range_is_the_list_of_its_values(range_mapping, values):
    assert points({"friction": range_mapping}) == points({"friction": values})


def test_whole_numbers_stay_whole():
    assert points({"seed": {"start": 1, "stop": 5, "num": 3}}) == points({"seed": [1, 3, 5]})


@pytest.mark.parametrize(
    ("range_mapping", "message"),
    [
        ({"start": 1, "num": 4}, "friction: got {'num': 4, 'start': 1}; allowed: a list of"),
        ({"start": 1, "stop": 2, "num": 1}, r"friction\.num: got 1; allowed: an integer in \[2"),
        ({"start": 1, "stop": 2, "step": 0}, r"friction\.step: got 0; allowed: a step from start"),
        ({"start": 1, "stop": 2, "step": -1}, r"friction\.step: got -1; allowed: a step from"),
        ({"start": True, "stop": 2, "num": 4}, "friction: got .*; allowed: a list of values, {"),
        (
            {"start": 0, "stop": 1, "step": 1 / MAX_VALUES},
            r"friction\.step: got 0.0001; allowed: a",
        ),
        ({"start": "a", "stop": 2, "num": 4}, "friction: got .*; allowed: a list of values, {"),
        ({"start": 1, "stop": -1, "num": 2}, r"friction\[1\]: got -1; allowed: a number >= 0"),
    ],
)
def test_a_wrong_range_is_refused(range_mapping, message):
    with pytest.raises(InputError, match=rf"series\[0\]\.grid\.{message}"):
        points({"friction": range_mapping})


def test_what_is_no_range_is_left_to_others():
    assert expand_range([1, 2]) == [1, 2] and expand_range("a") == "a"
