"""Types of the parameters of plug-ins' laws and motions, by which numba picks their functions."""

from sim.base.additions import codes
from sim.base.errors import InputError
from sim.engine.cache import CODED_KINDS
from sim.engine.compile import PLUGGED

#: Those known so far.
adopted: set[type] = set()


def adopt(kind: type) -> bool:
    """Make a type known; return whether it was not before.

    Raises
    ------
    InputError
        Where the engine was loaded before the plug-in: code compiled with it would be kept where
        processes look that have not loaded it.
    """
    if kind in adopted:
        return False
    if codes(*CODED_KINDS) != PLUGGED:
        raise InputError(
            "a plug-in with a law or a motion is loaded before the first flow of a process, and "
            "imports nothing of sim.engine; start another process"
        )
    adopted.add(kind)
    return True
