"""Ranges in a grid: evenly spaced values, equivalent to a list of them."""

import pytest

from sim.base.errors import InputError
from sim.study.entries import MAX_VALUES, expand_range
from sim.study.load import parse_study


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
