"""How a stretch of time steps ended: codes shared by compiled kernels and Python."""

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
