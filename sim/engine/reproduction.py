"""The point file that shows a failure again, beside the run file of a point that failed."""

from collections.abc import Sequence
from pathlib import Path

from sim.base.files import replacing
from sim.parameters import Parameters, as_yaml, point_id

FIRST_LINE = "# A point that failed; this file reproduces the failure:"


def keep(folder: Path, parameters: Parameters, reasons: Sequence[str]) -> None:
    """Write ``<point id>.failed.yaml`` if a replicate failed; remove an earlier one if none did.

    Parameters
    ----------
    folder : Path
        Folder of the run file.
    parameters : Parameters
        The point.
    reasons : sequence of str
        Why each replicate failed; empty for those that did not.
    """
    path = folder / f"{point_id(parameters)}.failed.yaml"
    failed = [number for number, reason in enumerate(reasons) if reason]
    if failed:
        with replacing(path) as temporary:
            temporary.write_text(_text(path.name, parameters, failed, reasons), encoding="utf-8")
    else:
        path.unlink(missing_ok=True)


def _text(name: str, parameters: Parameters, failed: list[int], reasons: Sequence[str]) -> str:
    """Return a point with no more replicates than it takes to get to the first that failed."""
    fewer = parameters.model_copy(update={"replicates": failed[0] + 1})
    lines = [
        FIRST_LINE,
        f"#   python -m sim run {name} -o failure.nc",
        *(f"# replicate {number}: {reasons[number]}" for number in failed),
    ]
    return "\n".join(lines) + "\n" + as_yaml(fewer)
