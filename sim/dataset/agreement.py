"""Check that the dataset of a study was made from its present study file."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from sim.base.errors import InputError
from sim.dataset.results import Results
from sim.parameters import amounts
from sim.study.load import Study

#: Fields that identify a boundary in a study and in its dataset.
_BOUNDARY_KEYS = ("name", "of", "along")


def require_agreement(study: Study, results: Results, path: Path) -> None:
    """Refuse a dataset that was made from another study file, or from this one before an edit.

    Parameters
    ----------
    study : Study
        The study.
    results : Results
        Its dataset, with the points of all rounds of refinement.
    path : Path
        Path of the dataset, for the message.

    Raises
    ------
    InputError
        When they differ; the message names the study file and the difference.
    """
    for label, ours, theirs in _comparisons(study, results):
        if ours != theirs:
            raise InputError(f"{study.path}: {label}: not as in {path}; run the study again")


def _comparisons(study: Study, results: Results) -> Iterator[tuple[str, Any, Any]]:
    """Yield the label of each compared value, the value in the study, and that in the dataset."""
    dataset = results.dataset
    yield "study", study.name, dataset.attrs.get("study")
    yield "title", study.title or study.name, dataset.attrs.get("title")
    ids = dataset["point"].values.tolist() if "point" in dataset.coords else []
    # The points that rounds of refinement have added come last.
    ids = ids[: len(study.points)] if study.rounds else ids
    for point in sorted(study.points.keys() ^ set(ids)):
        yield f"point {point}", point in study.points, point in ids
    yield "order of points", list(study.points), ids
    for kind in ("series", "figures"):
        for point, text in zip(study.points.values(), dataset[kind].values, strict=False):
            ours, theirs = set(getattr(point, kind)), set(str(text).split())
            # A round may have added a point of another series to a boundary.
            yield f"{kind} of {point.id}", ours, theirs & ours if study.rounds else theirs
    for index, point in enumerate(study.points.values()):
        for name, value in amounts(point.parameters).items():
            yield f"{name} of {point.id}", value, float(dataset[name].values[index])
    keys = [
        tuple(getattr(boundary, name) for name in _BOUNDARY_KEYS) for boundary in study.boundaries
    ]
    table = results.boundaries
    yield "boundaries", keys, list(zip(*(table[name] for name in _BOUNDARY_KEYS), strict=True))
