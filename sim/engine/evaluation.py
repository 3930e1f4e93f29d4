"""One call of a plug-in's function, which stands in place of a replicate of a flow."""

import time
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from sim.base.additions import attribute_errors_to, plain_name
from sim.engine.systems.recorder import Record
from sim.parameters import Parameters, point_id
from sim.parameters.laws import FUNCTION_NAME, RNG


class Evaluation:
    """Replicate number ``number`` of a point of a function, run and written as one of a flow."""

    def __init__(self, parameters: Parameters, number: int):
        self.parameters: Any = parameters
        self.number = number
        self.system = self
        self.series: dict[str, Any] = {}
        self.coordinates: dict[str, Any] = {}
        self.provenance: dict[str, str] = {}

    def run(self, report_steps: Callable[[int], None], *_: Any) -> Record:
        """Call the function; an error in it names the plug-in and its line there."""
        p, option = self.parameters, self.parameters.option(FUNCTION_NAME)
        arguments = {name: getattr(p, name) for name in option.parameters}
        if option.is_random:
            # Of its own for each point: noise that all points share would be no noise.
            code = int(point_id(p).rpartition("-")[2], 16)
            arguments[RNG] = np.random.default_rng((p.seed, self.number, code))
        wall, work = time.monotonic(), time.process_time()
        name = plain_name(p.function)
        with attribute_errors_to(FUNCTION_NAME, name):
            values = self._by_name(option.make(**arguments), option.returns)
        report_steps(1)
        outcome = {"status": "completed", "reason": "", "regime": "steady", "quality": "reliable"}
        costs = {
            "wall_time": time.monotonic() - wall,
            "loop_time": time.process_time() - work,
            "replicate_seed": self.number,
            "steps": 1,
        }
        return Record({}, scalars={**outcome, "stopped": "length", **costs, **values})

    @staticmethod
    def _by_name(returned: Any, names: tuple[str, ...]) -> dict[str, float]:
        """Return the numbers that a function returns by name; refuse anything else."""
        if not isinstance(returned, Mapping):
            if len(names) > 1:
                raise TypeError(f"it returns a mapping of {', '.join(names)} to numbers")
            returned = {names[0]: returned}
        if unknown := sorted(set(returned) - set(names)):
            raise TypeError(f"it returns {unknown[0]}, which it does not declare")
        return {name: float(returned.get(name, np.nan)) for name in names}
