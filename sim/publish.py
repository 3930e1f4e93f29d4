"""Publishing a study: a folder with all that a reader needs, small enough for a repository."""

import json
import shutil
from pathlib import Path

import xarray as xr

from sim.errors import InputError
from sim.stored import reading
from sim.study import load_study

#: Where published studies lie, beside the results of everybody's own.
PUBLISHED = Path("results/published")

#: What a published study consists of, and what it may have.
NEEDED = ("report.html", "dataset.nc", "claims.json", "claims.csv", "figures")
FURTHER = ("boundaries.csv",)

#: Largest size of all published studies together, bytes.
LARGEST = 25_000_000


def publish(
    study_path: str | Path, results: str | Path = "results", target: Path = PUBLISHED
) -> Path:
    """Copy report, figures, dataset and verdicts of a study to ``<target>/<study>``.

    The study file goes with them, and ``provenance.json``: versions, hash of the engine's sources,
    dates and cost. What was published of the study before is replaced at once, after all is copied.

    Returns
    -------
    Path
        The folder written.

    Raises
    ------
    InputError
        When something is missing, or all published studies together would be too large.
    """
    study = load_study(study_path, results)
    folder = Path(results) / study.name
    for name in NEEDED:
        if not (folder / name).exists():
            raise InputError(f"{folder / name}: missing; run the study to its end first")
    output, draft = target / study.name, target / f".{study.name}.part"
    shutil.rmtree(draft, ignore_errors=True)
    draft.mkdir(parents=True)
    for name in (*NEEDED, *FURTHER):
        _copy(folder / name, draft / name)
    shutil.copyfile(study.path, draft / "study.yaml")
    text = json.dumps(provenance(folder / "dataset.nc"), indent=1, ensure_ascii=False)
    (draft / "provenance.json").write_text(text + "\n", encoding="utf-8")
    others = [path for path in target.iterdir() if path.is_dir() and path not in (output, draft)]
    total = sum(map(size, [draft, *others]))
    if total > LARGEST:
        shutil.rmtree(draft)
        allowed = f"at most {LARGEST / 1e6:g} MB"
        raise InputError.of_value(target, "", f"{total / 1e6:.1f} MB", allowed)
    shutil.rmtree(output, ignore_errors=True)
    draft.replace(output)
    return output


def _copy(source: Path, copy: Path) -> None:
    if source.is_dir():
        shutil.copytree(source, copy, copy_function=shutil.copyfile)
    elif source.exists():
        shutil.copyfile(source, copy)


def size(folder: Path) -> int:
    """Return the size of all files in a folder, bytes."""
    return sum(path.stat().st_size for path in folder.rglob("*") if path.is_file())


def provenance(dataset: Path) -> dict[str, object]:
    """Return what a reader wants to know of how a dataset was made."""
    with (
        reading(dataset, "dataset", replaceable=False),
        xr.open_dataset(dataset, engine="netcdf4") as data,
    ):
        return {
            "study": data.attrs["study"],
            "title": data.attrs["title"],
            "points": data.sizes["point"],
            "runs": int((data["status"] != "").sum()),
            "failed runs": int((data["status"] == "failed").sum()),
            "time steps": int(data["steps"].sum()),
            "core hours": round(float(data["wall_time"].sum()) / 3600, 2),
            "from": data.attrs["first_run"],
            "to": data.attrs["last_run"],
            "engine": data.attrs["engine_version"],
            "hash of the engine's sources": data.attrs["source_hash"],
            "libraries": data.attrs["versions"],
        }
