"""Publish a study: a folder with everything a reader needs, small enough for a repository."""

import hashlib
import json
import shutil
from collections.abc import Sequence
from pathlib import Path
from stat import S_ISREG

from sim.base.errors import InputError
from sim.base.files import require_writable, temporary_folder
from sim.base.seals import checked_read
from sim.dataset.boundaries import format_csv
from sim.dataset.results import Results, load_current
from sim.figures.figure_records import require_unchanged
from sim.figures.render import derive_texts
from sim.report.claims import read_claims, require_table
from sim.report.crate import CITATION, CRATE_FILE, read_citation, require_rocrate, write_crate
from sim.report.gallery import relative_link
from sim.report.page import render
from sim.report.runs import adopted_datasets
from sim.study.extra_amounts import extra_amounts_file
from sim.study.load import Study, load_study

#: Folder of the published studies, beside the results of other studies.
PUBLISHED = Path("results/published")

#: Result files of a published study besides its figures.
RESULT_FILES = ("dataset.nc", "claims.json", "claims.csv", "verdicts.csv")

#: Files that are generated: provenance, report, the checksums of all files, and the crate.
PROVENANCE, REPORT, CHECKSUMS = "provenance.json", "report.html", "SHA256SUMS"
GENERATED_FILES = PROVENANCE, REPORT, CHECKSUMS, CRATE_FILE

#: Largest size of all published studies together, bytes.
MOST_BYTES = 40_000_000


def publish(
    study_path: str | Path,
    results: str | Path = "results",
    target: Path = PUBLISHED,
    crate: bool = False,
) -> Path:
    """Copy report, figures, dataset and verdicts of a study to ``<target>/<study>``.

    Still figures are published as SVG only. The study file and the files of its parts are copied,
    too. ``provenance.json`` has versions, hash of the engine's sources, dates and cost, and
    ``SHA256SUMS`` has the checksums of all files, for ``sha256sum --check``. The report links its
    figures, so that they are stored once. With ``crate``, ``ro-crate-metadata.json`` describes the
    folder as an RO-Crate. An earlier publication of the study is replaced after everything is
    copied.

    Returns
    -------
    Path
        The folder written.

    Raises
    ------
    InputError
        When a file is missing, damaged or outdated, when something else occupies the target, when
        all published studies together would be too large, or when a crate lacks authors.
    """
    if crate:
        require_rocrate()
    citation = read_citation(CITATION) if crate else None
    study = load_study(study_path, results)
    folder = Path(results) / study.name
    extra_files = [extra_amounts_file(folder).name] if extra_amounts_file(folder).is_file() else []
    names = [*_published_files(study), *extra_files]
    _require_files(folder, names)
    _require_distinct(study.sources, names)
    output = target / study.name
    require_writable(target, "--to")
    _require_replaceable(output, folder, target)
    dataset_results = load_current(study, folder)
    require_intact(study, dataset_results, folder)
    claims = read_claims(folder / "claims.json")
    page = render(study, dataset_results, folder / "figures", claims, relative_link)
    origin = provenance(dataset_results)
    provenance_text = json.dumps(origin, indent=1, ensure_ascii=False, allow_nan=False)
    target.mkdir(parents=True, exist_ok=True)
    with temporary_folder(output) as part:
        temporary = part / study.name
        (temporary / "figures").mkdir(parents=True)
        for name in names:
            (temporary / name).parent.mkdir(exist_ok=True)
            shutil.copyfile(folder / name, temporary / name)
        for file in study.sources:
            shutil.copyfile(file, temporary / file.name)
        (temporary / PROVENANCE).write_text(provenance_text + "\n", encoding="utf-8")
        (temporary / REPORT).write_text(page, encoding="utf-8")
        if citation:
            write_crate(temporary, study.path.name, origin, citation)
        write_checksums(temporary)
        _require_small(temporary, output, target)
        _replace(temporary, output)
    return output


def _published_files(study: Study) -> list[str]:
    """Return the names of the result files of a study that are published unchanged."""
    figures = (
        f"figures/{name}{end}"
        for name, spec in study.entries.items()
        for end in spec.suffixes
        if spec.animated or end != ".png"
    )
    boundaries = ["boundaries.csv"] if study.boundaries else []
    return [*RESULT_FILES, *boundaries, *(one.file for one in study.questions), *figures]


def _require_files(folder: Path, names: Sequence[str]) -> None:
    """Raise an error where a result file is missing: the study has not been run to its end."""
    for name in names:
        if not (folder / name).is_file():
            raise InputError(f"{folder / name}: missing; run the study to its end first")


def _require_distinct(files: Sequence[Path], names: Sequence[str]) -> None:
    """Raise an error where a study file has the name of another published file."""
    published_names = {Path(name).parts[0] for name in (*names, *GENERATED_FILES, "boundaries.csv")}
    for file in files:
        if file.name in published_names:
            allowed = f"another name, as {file.name} is published of every study"
            raise InputError.of_value(file, "", file.name, allowed)


def _require_replaceable(output: Path, folder: Path, target: Path) -> None:
    """Raise an error where the publication would replace results or anything else but another."""
    study_folder, destination = folder.resolve(), output.resolve()
    is_apart = not (
        destination.is_relative_to(study_folder) or study_folder.is_relative_to(destination)
    )
    is_publication = not output.exists() or (output / PROVENANCE).is_file()
    # A link would be set aside instead of its target.
    if output.is_symlink() or not (is_apart and is_publication):
        allowed = (
            f"a folder whose {output.name} is new or an earlier publication, not results or a link"
        )
        raise InputError.of_value("--to", "", str(target), allowed)


def write_checksums(folder: Path) -> None:
    """Write the checksums of all files in a folder to ``SHA256SUMS`` there."""
    # Not `is_file`, which takes a file for none where a file system fails.
    paths = (path for path in folder.rglob("*") if S_ISREG(path.stat().st_mode))
    files = sorted(path for path in paths if path.name != CHECKSUMS)
    lines = [
        f"{hashlib.sha256(path.read_bytes()).hexdigest()}  {path.relative_to(folder).as_posix()}\n"
        for path in files
    ]
    (folder / CHECKSUMS).write_text("".join(lines), encoding="utf-8")


def _require_small(temporary: Path, output: Path, target: Path) -> None:
    """Raise an error where all published studies together would be too large."""
    others = [
        path
        for path in target.iterdir()
        if path.is_dir() and path != output and not path.name.startswith(".")
    ]
    total = sum(map(folder_size, [temporary, *others]))
    if total > MOST_BYTES:
        allowed = f"at most {MOST_BYTES / 1e6:g} MB"
        raise InputError.of_value(target, "", f"{total / 1e6:.1f} MB", allowed)


def _replace(temporary: Path, output: Path) -> None:
    """Replace a folder by another; the old one is removed once the new one is in place.

    After a kill at any moment the one or the other is there, perhaps as ``.<name>.old``.
    """
    old = output.with_name(f".{output.name}.old")
    if output.exists():
        shutil.rmtree(old, ignore_errors=True)
        output.replace(old)
    temporary.replace(output)
    shutil.rmtree(old, ignore_errors=True)


def folder_size(folder: Path) -> int:
    """Return the total size of all files in a folder, bytes."""
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
