"""A study of points with different systems and shapes of arrays, with made-up run files."""

from collections.abc import Collection
from pathlib import Path
from typing import Any

import numpy as np

from sim.dataset import sources
from sim.dataset.build import build
from sim.parameters import Parameters, parse_point, point_id
from tests.made.runs import write_run

#: Points that differ in systems, replicates, slices, squares and variables.
POINTS = [
    {"system": "chute", "depth": 2},
    {"system": "chute", "depth": 5, "replicates": 3},
    {"system": "chute", "depth": 1, "friction": 0.5, "replicates": 2},
    {"system": "belt", "frequency": 30},
    {"system": "belt", "frequency": 80, "obstacle": 1.5, "replicates": 2},
    {"system": "belt", "frequency": 50, "width": 30, "replicates": 4},
]

#: The number of a point that figures show particle by particle: one on their way, one at rest.
SHOWN, PATHS, STATES = 4, "gallas_7a", "gallas_7b"


def arrays(parameters: Parameters) -> dict[str, object]:
    """Return arrays whose lengths depend on the point, and some that only some runs have."""
    count, slices = parameters.replicates, parameters.replicates + 3
    variables = {
        "height": ("height", np.arange(slices) * 1e-3),
        "velocity_profile": (("replicate", "height"), np.ones((count, slices))),
    }
    if parameters.system == "belt":
        squares = round(parameters.width)
        dims, field = ("replicate", "column", "level"), np.ones((count, squares, 2))
        variables |= {
            "column": ("column", np.arange(squares) * 1e-3),
            "level": ("level", [0.0, 1e-3]),
        }
        variables |= {"field_velocity": (dims, field), "field_density": (dims, field)}
        dims = ("replicate", "frame", "particle", "axis")
        variables |= {"position": (dims, np.ones((count, 2, 3, 2))), "axis": ("axis", ["x", "z"])}
        dims = ("replicate", "path_time", "particle", "axis")
        variables |= {
            "path": (dims, np.ones((count, 4, 3, 2))),
            "path_time": ("path_time", np.ones(4)),
        }
    elif count == 2:
        variables["transient_end"] = ("replicate", np.full(count, np.nan))
    return variables


class Mixed:
    """A study of some of the points, whose run files are all there."""

    def __init__(self, folder: Path):
        self.path, self.results = folder / "made.yaml", folder / "results"
        self.runs = self.results / "made" / "runs"
        self.output = self.results / "made" / "dataset.nc"
        self.points = [parse_point(values, "test") for values in POINTS]

    def write(self, number: int, velocity: float = 0.5) -> Path:
        """Write the run file of a point."""
        point = self.points[number]
        return write_run(
            self.runs, point, velocity, failed=[0] * (number == 1), arrays=arrays(point)
        )

    def save(self, *numbers: int, shown: str = "", bare: Collection[int] = ()) -> None:
        """Write the study file with points by their numbers; ``bare`` ones have no profiles."""
        series = ""
        for number in numbers:
            values = dict(POINTS[number])
            figures = [shown] * (bool(shown) and number == SHOWN)
            series += (
                f"  - {{name: s{number}, system: {values.pop('system')}, figures: {figures},"
                f" profiles: {number not in bare}, cases: [{values}]}}\n"
            )
        self.path.write_text(f"study: made\nseries:\n{series}")

    def build(self, *numbers: int, **options: Any) -> bytes:
        """Make the dataset of points by their numbers, in their order."""
        self.save(*numbers, **options)
        return build(self.path, self.results).read_bytes()

    def build_afresh(self, *numbers: int, **options: Any) -> bytes:
        """Make the dataset from run files alone, without rows of an earlier one."""
        (self.output.parent / sources.EARLIER_FILE).unlink(missing_ok=True)
        return self.build(*numbers, **options)


def ids(study: Mixed, *numbers: int) -> list[str]:
    """Return the ids of points by their numbers."""
    return [point_id(study.points[number]) for number in numbers]
