"""Hints at the intended value in messages about a study file."""

from pathlib import Path

import pytest

from sim.base.errors import InputError
from sim.base.yaml import read_yaml
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
