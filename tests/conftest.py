"""Profiles of hypothesis, and the order of the tests.

``pytest --hypothesis-profile=long tests/properties`` searches instead of repeating the same
examples in every run.
"""

from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

SLOW = [HealthCheck.too_slow, HealthCheck.filter_too_much, HealthCheck.large_base_example]

settings.register_profile(
    "fixed", derandomize=True, deadline=None, suppress_health_check=[HealthCheck.too_slow]
)
settings.register_profile("long", max_examples=1000, deadline=None, suppress_health_check=SLOW)
settings.load_profile("fixed")

#: Files that come first: two that compile the loops of all others, each for a worker of its own,
#: then those that take longest, lest one of them be left to the end.
FIRST = (
    "engine/dynamics/test_chute_reference.py",
    "engine/dynamics/test_belt_reference.py",
    "workflow/test_workflow.py",
    "workflow/test_refinement.py",
    "workflow/test_drill.py",
    "workflow/test_repairs.py",
)


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Put the tests of the files of FIRST before the others."""
    place = {Path(__file__).parent / name: number for number, name in enumerate(FIRST)}
    items.sort(key=lambda item: place.get(item.path, len(place)))
