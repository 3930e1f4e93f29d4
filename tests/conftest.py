"""Profiles of hypothesis: the same examples in every run, or many new ones.

``pytest --hypothesis-profile=long tests/properties`` searches instead of repeating itself.
"""

from hypothesis import HealthCheck, settings

SLOW = [HealthCheck.too_slow, HealthCheck.filter_too_much, HealthCheck.large_base_example]

settings.register_profile("fixed", derandomize=True, deadline=None)
settings.register_profile("long", max_examples=1000, deadline=None, suppress_health_check=SLOW)
settings.load_profile("fixed")
