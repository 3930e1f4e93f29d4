"""Publishing a study: a folder with all that a reader needs, small enough for a repository."""

import hashlib
import json
import shutil
from collections.abc import Sequence
from pathlib import Path

from sim.base.errors import InputError
from sim.base.files import require_writable
from sim.dataset.agreement import require_agreement
from sim.dataset.results import Results, load_results
from sim.report.claims import read_claims
from sim.report.gallery import beside
from sim.report.integrity import require_intact
from sim.report.page import render
from sim.report.runs import adopted_datasets
from sim.study.extra_amounts import extra_amounts_file
from sim.study.load import Study, load_study

#: Where published studies lie, beside the results of everybody's own.
PUBLISHED = Path("results/published")

#: What a published study consists of besides its figures.
NEEDED = ("dataset.nc", "claims.json", "claims.csv")

#: What is made for it, and the checksums of all files.
MADE = PROVENANCE, REPORT, CHECKSUMS = "provenance.json", "report.html", "SHA256SUMS"

#: Largest size of all published studies together, bytes.
LARGEST = 40_000_000


def publish(
    study_path: str | Path, results: str | Path = "results", target: Path = PUBLISHED
) -> Path:
    """Copy report, figures, dataset and verdicts of a study to ``<target>/<study>``.

    Of figures that do not move only the pictures that scale are published. The study file and
    those of its parts go with them, ``provenance.json``: versions, hash of the engine's sources,
    dates and cost, and ``SHA256SUMS``, the checksums of all, for ``sha256sum --check``. The report
    links its figures, which would be there twice otherwise. What was published of the study before
    is replaced after all is copied.

    Returns
    -------
    Path
        The folder written.

    Raises
    ------
    InputError
        When something is missing, damaged or not of the study as its file is now, when something
        else lies in the place, or when all published studies together would be too large.
    """
    study = load_study(study_path, results)
    folder = Path(results) / study.name
    bought = [extra_amounts_file(folder).name] if extra_amounts_file(folder).is_file() else []
    names = [*_published_files(study), *bought]
    _require_there(folder, names)
    _require_distinct(study.sources, names)
    output, temporary = target / study.name, target / f".{study.name}.part"
    require_writable(target, "--to")
    _require_replaceable(output, folder, target)
    found = load_results(folder / "dataset.nc")
    require_agreement(study, found, folder / "dataset.nc")
    require_intact(study, found, folder)
    claims = read_claims(folder / "claims.json")
    page = render(study, found, folder / "figures", claims, beside)
    made = json.dumps(provenance(found), indent=1, ensure_ascii=False, allow_nan=False)
    shutil.rmtree(temporary, ignore_errors=True)
    try:
        (temporary / "figures").mkdir(parents=True)
        for name in names:
            shutil.copyfile(folder / name, temporary / name)
        for file in study.sources:
            shutil.copyfile(file, temporary / file.name)
        (temporary / PROVENANCE).write_text(made + "\n", encoding="utf-8")
        (temporary / REPORT).write_text(page, encoding="utf-8")
        write_checksums(temporary)
        _require_small(temporary, output, target)
        _replace(temporary, output)
    finally:
        shutil.rmtree(temporary, ignore_errors=True)
    return output


def _published_files(study: Study) -> list[str]:
    """Return the names of the result files of a study that are published as they are."""
    figures = (
        f"figures/{name}{end}"
        for name, spec in study.entries.items()
        for end in spec.suffixes
        if spec.animated or end != ".png"
    )
    return [*NEEDED, *(["boundaries.csv"] if study.boundaries else []), *figures]


def _require_there(folder: Path, names: Sequence[str]) -> None:
    """Refuse results of a study that has not been run to its end."""
    for name in names:
        if not (folder / name).is_file():
            raise InputError(f"{folder / name}: missing; run the study to its end first")


def _require_distinct(files: Sequence[Path], names: Sequence[str]) -> None:
    """Refuse study files that are named like something else that is published."""
    taken = {Path(name).parts[0] for name in (*names, *MADE, "boundaries.csv")}
    for file in files:
        if file.name in taken:
            allowed = f"another name, as {file.name} is published of every study"
            raise InputError.of_value(file, "", file.name, allowed)


def _require_replaceable(output: Path, folder: Path, target: Path) -> None:
    """Refuse to put a published study in the place of results, or of anything but another one."""
    own, place = folder.resolve(), output.resolve()
    apart = not (place.is_relative_to(own) or own.is_relative_to(place))
    published = not output.exists() or (output / PROVENANCE).is_file()
    # A link would be put aside in the place of what it leads to.
    if output.is_symlink() or not (apart and published):
        allowed = (
            f"a folder whose {output.name} is new or an earlier publication, not results or a link"
        )
        raise InputError.of_value("--to", "", str(target), allowed)


def write_checksums(folder: Path) -> None:
    """Write the checksums of all files in a folder to a file there."""
    files = sorted(path for path in folder.rglob("*") if path.is_file() and path.name != CHECKSUMS)
    lines = [
        f"{hashlib.sha256(path.read_bytes()).hexdigest()}  {path.relative_to(folder).as_posix()}\n"
        for path in files
    ]
    (folder / CHECKSUMS).write_text("".join(lines), encoding="utf-8")


def _require_small(temporary: Path, output: Path, target: Path) -> None:
    """Refuse a folder that makes all published studies together too large."""
    others = [
        path
        for path in target.iterdir()
        if path.is_dir() and path != output and not path.name.startswith(".")
    ]
    total = sum(map(size, [temporary, *others]))
    if total > LARGEST:
        allowed = f"at most {LARGEST / 1e6:g} MB"
        raise InputError.of_value(target, "", f"{total / 1e6:.1f} MB", allowed)


def _replace(temporary: Path, output: Path) -> None:
    """Put a folder in the place of another, which is gone only when the new one is there."""
    aside = output.with_name(f".{output.name}.old")
    shutil.rmtree(aside, ignore_errors=True)
    if output.exists():
        output.replace(aside)
    temporary.replace(output)
    shutil.rmtree(aside, ignore_errors=True)


def size(folder: Path) -> int:
    """Return the size of all files in a folder, bytes."""
    return sum(path.stat().st_size for path in folder.rglob("*") if path.is_file())


def provenance(results: Results) -> dict[str, object]:
    """Return size, cost, dates and versions of a dataset for ``provenance.json``."""
    data = results.dataset
    return {
        "study": data.attrs["study"],
        "title": data.attrs["title"],
        "points": data.sizes["point"],
        "runs": int((data["status"] != "").sum()),
        "points from adopted datasets": adopted_datasets(results),
        "failed runs": int((data["status"] == "failed").sum()),
        "time steps": int(data["steps"].sum()),
        "core hours": round(float(data["wall_time"].sum()) / 3600, 2),
        "from": data.attrs["first_run"],
        "to": data.attrs["last_run"],
        "engine": data.attrs["engine_version"],
        "numerics": data.attrs["numerics"],
        "hash of the engine's sources": data.attrs["source_hash"],
        "libraries": data.attrs["versions"],
    }
