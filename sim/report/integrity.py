"""Check that figures, tables and verdicts of a study are intact and match its dataset."""

from pathlib import Path

from sim.base.seals import checked_read
from sim.dataset.boundaries import format_csv
from sim.dataset.results import Results
from sim.figures.figure_records import require_unchanged
from sim.figures.render import derive_texts
from sim.report.claims import read_claims, require_table
from sim.study.load import Study


def require_intact(study: Study, results: Results, folder: Path) -> None:
    """Raise an error unless figures, tables and verdicts are unchanged and match the dataset.

    The data and captions of figures and the table of boundaries are derived again from the dataset,
    which takes little time.

    Raises
    ------
    InputError
        Where a file is missing.
    DamagedError
        For the first file that differs; it is set aside.
    """
    require_unchanged(study.entries.values(), folder / "figures")
    for name, spec in study.entries.items():
        data, caption = derive_texts(spec, results)
        _require_text(folder / f"figures/{name}.csv", data, "table of a figure")
        _require_text(folder / f"figures/{name}.caption.txt", caption, "caption")
    if study.boundaries:
        _require_text(folder / "boundaries.csv", format_csv(study, results.boundaries), "table")
    require_table(folder)
    _require_points(folder / "claims.json", set(results.dataset["point"].values.tolist()))


def _require_text(path: Path, expected: str, kind: str) -> None:
    with checked_read(path, kind, replaceable=True):
        if path.read_text(encoding="utf-8") != expected:
            raise ValueError("not what the dataset gives")


def _require_points(path: Path, points: set[str]) -> None:
    """Raise an error where verdicts rest on points that the dataset lacks."""
    variants = [variant for claim in read_claims(path) for variant in claim["variants"]]
    judged = {
        point for variant in variants for check in variant["checks"] for point in check["points"]
    }
    with checked_read(path, "table of verdicts", replaceable=True):
        if not points.issuperset(judged):
            raise ValueError("verdicts on points that the dataset has not")
