"""Refinement against known thresholds: width, rounds, both directions, undecided points."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sim.study.model import (
    PARTS,
    BoundaryEstimate,
    divide_range,
    further_rounds,
    locate_boundary,
    next_values,
)


def search(classify, low: float, high: float, tolerance: float) -> tuple[BoundaryEstimate, dict]:
    """Refine for the promised number of rounds; return the boundary estimate and all sides."""
    sides = {value: classify(value) for value in divide_range(low, high)}
    for _ in range(further_rounds(low, high, tolerance)):
        new = next_values(sides, tolerance)
        assert not set(new) & set(sides)
        sides |= {value: classify(value) for value in new}
    assert next_values(sides, tolerance) == []
    return locate_boundary(sides, tolerance), sides


@given(
    low=st.floats(0, 50),
    width=st.floats(0.5, 50),
    share=st.floats(0.001, 0.999),
    fineness=st.floats(1, 2000),
    rising=st.booleans(),
)
def test_a_threshold_is_found_within_the_tolerance(low, width, share, fineness, rising):
    high, tolerance = low + width, width / fineness
    threshold = low + share * width
    names = ("below", "above") if rising else ("above", "below")
    boundary, sides = search(lambda value: names[value >= threshold], low, high, tolerance)
    assert boundary.verdict == "found"
    assert (boundary.below, boundary.above) == names
    assert boundary.low <= threshold <= boundary.high
    assert boundary.high - boundary.low <= tolerance * (1 + 1e-6)
    assert len(sides) <= PARTS + 1 + (PARTS - 1) * further_rounds(low, high, tolerance)


def test_rounds_are_known_beforehand_and_values_are_canonical():
    tolerances = (5, 2.5, 2.4, 0.625, 0.25)
    assert [further_rounds(10, 20, tolerance) for tolerance in tolerances] == [0, 0, 1, 1, 2]
    assert further_rounds(0.1, 0.5, 0.1) == 0
    assert divide_range(0.1, 0.5) == [0.1, 0.2, 0.3, 0.4, 0.5]


def test_an_open_zone_is_closed_in_on():
    def classify(value):
        return None if 4.3 < value < 5.2 else "low" if value < 5 else "high"

    boundary, sides = search(classify, 0, 10, 0.1)
    assert boundary.verdict == "wide"
    assert 4.3 - 0.1 <= boundary.low <= 4.3
    assert 5.2 <= boundary.high <= 5.2 + 0.1
    assert sum(side is None for side in sides.values()) < 10
    # A single open point does not stop the search.
    boundary, _ = search(lambda x: None if x == 5 else "low" if x < 6 else "high", 0, 10, 0.1)
    assert boundary.verdict == "found" and boundary.low <= 6 <= boundary.high


def test_points_that_contradict_each_other_stay_inside():
    sides = {0.0: "low", 1.0: "high", 2.0: "low", 3.0: "high", 4.0: "high"}
    assert locate_boundary(sides, 0.5) == BoundaryEstimate("wide", "low", "high", 0.0, 3.0)
    assert next_values(sides, 0.5) == [0.25, 0.5, 0.75, 2.25, 2.5, 2.75]


@pytest.mark.parametrize(
    ("sides", "expected"),
    [
        (["a", "a", "a"], BoundaryEstimate("none", "a", "a")),
        (["a", None, None], BoundaryEstimate("open", "a", "a")),
        ([None, "a", "a"], BoundaryEstimate("open", "a", "a")),
        (["a", "b", "a"], BoundaryEstimate("several", "a", "a")),
        ([None, None, None], BoundaryEstimate("open", "", "")),
    ],
)
def test_without_a_boundary_nothing_is_refined(sides, expected):
    sides_by_value = dict(zip((1.0, 2.0, 3.0), sides, strict=True))
    assert locate_boundary(sides_by_value, 0.1) == expected
    assert next_values(sides_by_value, 0.1) == []
