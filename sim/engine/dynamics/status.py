"""How a series of time steps ended: codes shared by compiled kernels and Python."""

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

    ``samples`` are those that the same call took before that, if any.
    """

    def __init__(self, reason: str, samples: Any = None):
        super().__init__(reason)
        self.samples = samples


def failure_reason(status: int, position: np.ndarray) -> str:
    """Return the reason for a failure after steps with this status, or an empty text."""
    if status == OK and not is_finite(position):
        status = NOT_FINITE
    return REASONS.get(status, "")


@exact
def is_finite(position):
    """True where all positions are finite."""
    bad_values = 0
    for value in position.flat:
        bad_values += not np.isfinite(value)
    return bad_values == 0
