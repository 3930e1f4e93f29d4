"""Whether figures, tables and verdicts of a study are intact and those of its dataset."""

from pathlib import Path

from sim.base.damage import checked_read
from sim.dataset.boundaries import as_csv
from sim.dataset.results import Results
from sim.figures.drawn import require_unchanged
from sim.figures.render import derived
from sim.report.claims import read_claims, require_table
from sim.study.load import Study


def require_intact(study: Study, results: Results, folder: Path) -> None:
    """Refuse figures, tables and verdicts that have changed or are not those of the dataset.

    What can be derived from the dataset in little time is derived again: the data and the captions
    of figures, and the table of boundaries.

    Raises
    ------
    InputError
        Where a file is missing.
    DamagedError
        Naming the first file that is not as it should be, which is set aside.
    """
    require_unchanged(study.entries.values(), folder / "figures")
    for name, spec in study.entries.items():
        data, caption = derived(spec, results)
        _require_text(folder / f"figures/{name}.csv", data, "table of a figure")
        _require_text(folder / f"figures/{name}.caption.txt", caption, "caption")
    if study.boundaries:
        _require_text(folder / "boundaries.csv", as_csv(study, results.boundaries), "table")
    require_table(folder)
    _require_points(folder / "claims.json", set(results.dataset["point"].values.tolist()))


def _require_text(path: Path, expected: str, kind: str) -> None:
    with checked_read(path, kind, replaceable=True):
        if path.read_text(encoding="utf-8") != expected:
            raise ValueError("not what the dataset gives")


def _require_points(path: Path, points: set[str]) -> None:
    """Refuse verdicts on other points than those of the dataset."""
    variants = [variant for claim in read_claims(path) for variant in claim["variants"]]
    judged = {point for one in variants for check in one["checks"] for point in check["points"]}
    with checked_read(path, "table of verdicts", replaceable=True):
        if not points.issuperset(judged):
            raise ValueError("verdicts on points that the dataset has not")
