"""The trajectory of a replicate: states of all particles at equal time intervals."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from sim.engine.dynamics.status import BlowUp
from sim.engine.systems.replica import Replica
from sim.parameters.variables import variables_of


class Trajectory:
    """Takes a frame at the end of every ``samples``-th sample, no frames where that is 0.

    Each frame has space for ``contacts`` contacts, none where that is 0; unused rows are
    not-a-number. Frames are in single precision, like the formats of other programs: a position in
    a cell of ten diameters is accurate to a millionth of a diameter.
    """

    def __init__(self, samples: int, contacts: int = 0):
        self._samples, self._contacts = samples, contacts
        self._frames: dict[str, list[np.ndarray]] = {}

    def next_frame(self, count: int) -> list[int]:
        """Return the number of samples at the next frame after ``count`` samples, if any."""
        return [(count // self._samples + 1) * self._samples] if self._samples else []

    def take(self, system: Replica, count: int) -> None:
        """Take a frame of a system after ``count`` samples, if one is due."""
        if self._samples and count % self._samples == 0:
            state = system.snapshot()
            if self._contacts:
                state |= self._contact_arrays(system)
            for name, row in variables_of("trajectory").items():
                if row.of in state:
                    frame = np.array(state[row.of], np.float32)
                    self._frames.setdefault(name, []).append(frame)

    def _contact_arrays(self, system: Replica) -> dict[str, np.ndarray]:
        """Return the contacts of the present state; unused rows are not-a-number."""
        contacts = system.current_contacts(self._contacts)
        if (number := int(contacts.number[0])) > self._contacts:
            raise BlowUp(f"{number} contacts, more than {self._contacts}, which a frame holds")
        return {"contact_pair": contacts.pair, "contact_force": contacts.force}

    def frames(self) -> dict[str, np.ndarray]:
        """Return the frames so far, name -> (F, N, D); empty before the first."""
        return {name: np.array(frames) for name, frames in self._frames.items()}

    def restore(self, frames: Mapping[str, Any], count: int) -> None:
        """Replace the frames by those of another trajectory after ``count`` samples.

        Raises ``ValueError`` when the frames do not fit.
        """
        expected = count // self._samples if self._samples else 0
        is_complete = all(len(values) == expected for values in frames.values())
        if not is_complete or bool(frames) != bool(expected):
            raise ValueError("its frames are not those of the trajectory")
        self._frames = {name: list(values) for name, values in frames.items()}
