"""How a stretch of time steps ended: codes shared by compiled kernels and Python."""

from typing import Any

import numpy as np

from sim.engine.compile import exact

OK = 0
LIST_FULL = 1
NOT_FINITE = 2
OVERLAP = 3


REASONS = {
    NOT_FINITE: "a position is not finite",
    OVERLAP: "an overlap exceeds overlap_limit",
}


class BlowUp(RuntimeError):
    """The motion has become unphysical; the message is the reason.

    ``samples`` are what the same call has measured before that, if anything.
    """

    def __init__(self, reason: str, samples: Any = None):
        super().__init__(reason)
        self.samples = samples


def outcome(status: int, position: np.ndarray) -> str:
    """Return what is wrong after a stretch of steps with this status, or an empty text."""
    if status == OK and not all_finite(position):
        status = NOT_FINITE
    return REASONS.get(status, "")


@exact
def all_finite(position):
    """Return whether all positions are finite."""
    wrong = 0
    for value in position.flat:
        wrong += not np.isfinite(value)
    return wrong == 0
