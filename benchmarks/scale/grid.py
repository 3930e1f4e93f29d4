"""The study that is measured: belts on a grid of frequencies and amplitudes."""

from pathlib import Path
from typing import Any

import yaml

#: Amplitudes to a frequency.
ROW = 100


def write_study(
    folder: Path, rows: int, belt: dict[str, Any], added: int = 0, **others: Any
) -> Path:
    """Write a study of so many rows of points and, in a series of their own, some more.

    ``belt`` holds what all its points have in common, ``others`` are further keys of the file.
    """
    grid = {
        "frequency": [20 + number for number in range(rows)],
        "amplitude": [1 + number / ROW for number in range(ROW)],
    }
    series = [{"name": "beds", "system": "belt", "grid": grid}]
    if added:
        frequencies = [20 + number for number in range(added)]
        more = {"base": {"amplitude": 3}, "grid": {"frequency": frequencies}}
        series.append({"name": "more", "system": "belt", **more})
    study = {"study": "scale", "defaults": {"belt": belt}, "series": series, **others}
    path = folder / "scale.yaml"
    path.write_text(yaml.safe_dump(study), encoding="utf-8")
    return path
