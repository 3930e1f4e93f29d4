"""The trajectory of a replicate: states of all particles at equal distances of time."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from sim.engine.dynamics.status import BlowUp
from sim.engine.observe.system import System
from sim.parameters.variables import variables


class Trajectory:
    """Takes a frame at the end of each ``samples``-th sample, none where that is 0.

    With room for so many ``contacts``, none where that is 0; frames have fewer, and are filled up.

    In single precision, like the formats that others read: a place in a cell of ten diameters is
    known to a millionth of a diameter.
    """

    def __init__(self, samples: int, contacts: int = 0):
        self._samples, self._contacts = samples, contacts
        self._frames: dict[str, list[np.ndarray]] = {}

    def due(self, taken: int) -> list[int]:
        """Return at how many samples the next frame is due, if any, after so many."""
        return [(taken // self._samples + 1) * self._samples] if self._samples else []

    def take(self, system: System, taken: int) -> None:
        """Take a frame of a system that has finished so many samples, if one is due."""
        if self._samples and taken % self._samples == 0:
            state = system.snapshot()
            if self._contacts:
                state |= self._of_contacts(system)
            for name, row in variables("trajectory").items():
                if row.of in state:
                    frame = np.array(state[row.of], np.float32)
                    self._frames.setdefault(name, []).append(frame)

    def _of_contacts(self, system: System) -> dict[str, np.ndarray]:
        """Return the contacts of the present state; those that are missing are not-a-number."""
        listed = system.contacts_now(self._contacts)
        if (number := int(listed.number[0])) > self._contacts:
            raise BlowUp(f"{number} contacts, more than {self._contacts}, which a frame holds")
        return {"contact_pair": listed.pair, "contact_force": listed.force}

    def frames(self) -> dict[str, np.ndarray]:
        """Return the frames so far, name -> (F, N, D); nothing before the first."""
        return {name: np.array(frames) for name, frames in self._frames.items()}

    def restore(self, held: Mapping[str, Any], taken: int) -> None:
        """Take over the frames of another trajectory after so many samples.

        Raises ``ValueError`` when they are not those of such a one.
        """
        wanted = taken // self._samples if self._samples else 0
        if any(len(frames) != wanted for frames in held.values()) or bool(held) != bool(wanted):
            raise ValueError("its frames are not those of the trajectory")
        self._frames = {name: list(frames) for name, frames in held.items()}
