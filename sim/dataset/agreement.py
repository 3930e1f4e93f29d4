"""Whether the dataset of a study is that of its study file as it is now."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from sim.base.errors import InputError
from sim.dataset.results import Results
from sim.parameters import amounts
from sim.study.load import Study

#: What names a boundary in a study and in its dataset.
_ASKED = ("name", "of", "along")


def require_agreement(study: Study, results: Results, path: Path) -> None:
    """Refuse a dataset that another study file has made, or the same one before it was edited.

    Parameters
    ----------
    study : Study
        The study.
    results : Results
        Its dataset, with the points of all rounds of refinement.
    path : Path
        Where that lies, for the message.

    Raises
    ------
    InputError
        Naming the study file and what differs.
    """
    for what, ours, theirs in _compared(study, results):
        if ours != theirs:
            raise InputError(f"{study.path}: {what}: not as in {path}; run the study again")


def _compared(study: Study, results: Results) -> Iterator[tuple[str, Any, Any]]:
    """Yield what is compared: its name, its value in the study, and that in the dataset."""
    dataset = results.dataset
    yield "study", study.name, dataset.attrs.get("study")
    yield "title", study.title or study.name, dataset.attrs.get("title")
    held = dataset["point"].values.tolist() if "point" in dataset.coords else []
    # Those that rounds of refinement have added come last.
    held = held[: len(study.points)] if study.rounds else held
    for point in sorted(study.points.keys() ^ set(held)):
        yield f"point {point}", point in study.points, point in held
    yield "order of points", list(study.points), held
    for what in ("series", "figures"):
        for point, text in zip(study.points.values(), dataset[what].values, strict=False):
            ours, theirs = set(getattr(point, what)), set(str(text).split())
            # A boundary may have passed through a point of another series since.
            yield f"{what} of {point.id}", ours, theirs & ours if study.rounds else theirs
    for index, point in enumerate(study.points.values()):
        for name, value in amounts(point.parameters).items():
            yield f"{name} of {point.id}", value, float(dataset[name].values[index])
    asked = [tuple(getattr(one, name) for name in _ASKED) for one in study.boundaries]
    table = results.boundaries
    yield "boundaries", asked, list(zip(*(table[name] for name in _ASKED), strict=True))
