"""The files that rounds of refinement leave behind: which points each has added to a study."""

import json
from pathlib import Path

from sim.base.errors import InputError
from sim.base.reading import reading
from sim.parameters import Parameters, parse_point, point_id


def read_round(path: Path) -> dict[str, Parameters]:
    """Read the points by id that a round has added; a damaged file is set aside.

    Raises
    ------
    InputError
        When there is no such file, or it is not one.
    """
    with reading(path, "round of refinement", replaceable=True):
        held = json.loads(path.read_text(encoding="utf-8"))
        try:
            points = {key: parse_point(values, path) for key, values in held.items()}
        except InputError as error:
            raise ValueError(error) from None
        wrong = [key for key, point in points.items() if key != point_id(point)]
        if wrong:
            raise ValueError(f"{wrong[0]} is not the id of its point")
        return points
