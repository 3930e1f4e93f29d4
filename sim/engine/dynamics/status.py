"""How a stretch of time steps ended: codes shared by compiled kernels and Python."""

import numpy as np

OK = 0
LIST_FULL = 1
NOT_FINITE = 2
OVERLAP = 3


REASONS = {
    NOT_FINITE: "a position is not finite",
    OVERLAP: "an overlap exceeds overlap_limit",
}


class BlowUp(RuntimeError):
    """The motion has become unphysical; the message is the reason."""


def require_motion(status: int, position: np.ndarray, when: str) -> None:
    """Raise ``BlowUp`` unless a stretch of steps has ended well, with finite positions."""
    if status == OK and not np.isfinite(position).all():
        status = NOT_FINITE
    if status != OK:
        raise BlowUp(f"{REASONS[status]} at step {when}")
