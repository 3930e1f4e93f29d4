"""Whether figures, tables and verdicts of a study are complete and those of its dataset."""

import csv
from pathlib import Path

from PIL import Image

from sim.base.reading import reading
from sim.dataset.boundaries import as_csv
from sim.dataset.results import Results
from sim.figures.render import derived
from sim.report.claims import read_claims
from sim.study.catalogue import FIGURES
from sim.study.load import Study

#: The last byte of a GIF.
_TRAILER = b";"

#: Columns of the table of verdicts that the verdicts themselves give.
_COLUMNS = (
    "claim",
    "verdict on the claim",
    "protocol",
    "reading",
    "verdict",
    "verdict on the check",
)


def require_whole(study: Study, results: Results, folder: Path) -> None:
    """Refuse figures, tables and verdicts that are damaged or not those of the dataset.

    What can be derived from the dataset in little time is derived again: the data and the captions
    of figures, and the table of boundaries. Of pictures and verdicts it is seen that they are
    complete.

    Raises
    ------
    DamagedError
        Naming the first such file, which is set aside.
    """
    for name in study.figures:
        data, caption = derived(FIGURES[name], results)
        _require_text(folder / f"figures/{name}.csv", data, "table of a figure")
        _require_text(folder / f"figures/{name}.caption.txt", caption, "caption")
        if FIGURES[name].animated:
            _require_animation(folder / "figures" / name)
    if study.boundaries:
        _require_text(folder / "boundaries.csv", as_csv(study, results.boundaries), "table")
    _require_verdicts(folder, set(results.dataset["point"].values.tolist()))


def _require_text(path: Path, expected: str, kind: str) -> None:
    with reading(path, kind, replaceable=True):
        if path.read_text(encoding="utf-8") != expected:
            raise ValueError("not what the dataset gives")


def _require_animation(path: Path) -> None:
    """Refuse an animation or its first picture that end early."""
    gif, still = path.with_suffix(".gif"), path.with_suffix(".png")
    with reading(still, "picture", replaceable=True), Image.open(still) as picture:
        picture.verify()
    with reading(gif, "animation", replaceable=True), Image.open(gif):
        if not gif.read_bytes().endswith(_TRAILER):
            raise ValueError("it ends early")


def _require_verdicts(folder: Path, points: set[str]) -> None:
    """Refuse verdicts on other points, or whose table has other rows than they have checks."""
    claims = read_claims(folder / "claims.json")
    with reading(folder / "claims.json", "table of verdicts", replaceable=True):
        rows = []
        for claim in claims:
            for variant in claim["variants"]:
                shared = (claim["id"], claim["verdict"], variant["protocol"], variant["reading"])
                checks = variant["checks"] or [{"verdict": "", "points": ()}]
                rows += [(*shared, variant["verdict"], check["verdict"]) for check in checks]
                if not points.issuperset(point for check in checks for point in check["points"]):
                    raise ValueError("verdicts on points that the dataset has not")
    path = folder / "claims.csv"
    with reading(path, "table of verdicts", replaceable=True):
        text = path.read_text(encoding="utf-8")
        held = [
            tuple(row.get(name, "") for name in _COLUMNS)
            for row in csv.DictReader(text.splitlines())
        ]
        if held != rows or not text.endswith("\n"):
            raise ValueError("other rows than claims.json has")
