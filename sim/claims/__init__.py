"""What papers and studies claim, judged from a dataset.

What a judge may use is here, and stays: ``from talus.claims import above, trend, Untestable``.
"""

from importlib import import_module
from typing import Any

#: What a judge may use, by the module that has it.
FOR_JUDGES = {
    "evidence": ("Evidence",),
    "place": ("Place", "ANY", "with_interval", "replicate_mean", "quotient", "select_replicated"),
    "checks": (
        *("above", "below", "within", "reported", "judge_parts", "at_least"),
        *("remove_votes", "withhold", "correct_for"),
    ),
    "inference": (
        *("trend", "reported_order", "outranks", "same_by_rank", "share_above", "reported_share"),
        "smallest_mean",
    ),
    "verdict": ("Check", "Untestable", "Unbounded", "Ambiguous"),
}

_MODULES = {name: module for module, names in FOR_JUDGES.items() for name in names}

# With both, `help(talus.claims)` tells all of them.
__all__ = [*_MODULES]


def __getattr__(name: str) -> Any:
    if name not in _MODULES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_MODULES[name]}"), name)


def __dir__() -> list[str]:
    return [*globals(), *_MODULES]
