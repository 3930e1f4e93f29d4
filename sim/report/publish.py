"""Publish a study: a folder with everything a reader needs, small enough for a repository."""

import hashlib
import json
import re
import shutil
from collections.abc import Callable, Mapping
from contextlib import nullcontext
from importlib.util import find_spec
from mimetypes import guess_type
from pathlib import Path
from stat import S_ISREG
from typing import Any
from urllib.parse import unquote

from sim.base.errors import InputError
from sim.base.files import require_writable, temporary_folder
from sim.base.program import __version__
from sim.base.seals import checked_read
from sim.base.yaml import read_yaml
from sim.dataset.boundaries import format_csv
from sim.dataset.results import Results, load_current
from sim.figures.pictures import require_unchanged
from sim.report.claims import read_claims, require_table
from sim.report.page import relative_link, render
from sim.study.load import Study, extra_amounts_file, folder_of_results, load_study

# A published study as an RO-Crate 1.1 (https://w3id.org/ro/crate/1.1): who made it, under which
# licence, and how, by the profile Process Run Crate.

#: File of authors and licence, in the folder where the command is called.
CITATION = Path("CITATION.cff")

#: Name that the format gives to the description of a crate, and its version.
CRATE_FILE, VERSION = "ro-crate-metadata.json", "1.1"

#: Profile of crates that say which command made which data.
PROFILE = "https://w3id.org/ro/wfrun/process/0.5"

#: Meaning of the files of a publication, by suffix, and media types that Python does not know.
_MEANINGS = {
    ".nc": "all numbers of the study, a row per point",
    ".yaml": "study file: the whole input, or a part of it",
    ".py": "plug-in of the study",
    ".json": "verdicts, provenance, or what was bought to decide claims",
    ".csv": "table",
    ".svg": "figure",
    ".gif": "animation",
    ".html": "report",
    ".png": "still picture of an animation",
    ".txt": "caption of a figure",
}
_MEDIA = {".nc": "application/netcdf", ".yaml": "application/yaml"}

#: Properties of an author, by the keys of a citation.
_AUTHOR = {"given-names": "givenName", "family-names": "familyName", "affiliation": "affiliation"}

_LICENCE = re.compile(r"[A-Za-z0-9][A-Za-z0-9.+-]{0,99}")
_ORCID = re.compile(r"https://orcid\.org/(\d{4}-){3}\d{3}[\dX]")


def _is_line(value: Any) -> bool:
    return isinstance(value, str) and bool(value.strip()) and value.isprintable()


def _are_authors(value: Any) -> bool:
    if not (isinstance(value, list) and value and all(isinstance(one, dict) for one in value)):
        return False
    names = [[one[key] for key in one.keys() & {"name", "family-names"}] for one in value]
    orcids = [str(one["orcid"]) for one in value if one.get("orcid")]
    are_names = all(own and all(map(_is_line, own)) for own in names)
    return are_names and all(map(_ORCID.fullmatch, orcids)) and len({*orcids}) == len(orcids)


#: What the keys of a citation must hold. Licences and ORCIDs become addresses.
_KEYS: dict[str, tuple[Callable[[Any], bool], str]] = {
    "title": (_is_line, "the title of what is published"),
    "license": (
        lambda value: isinstance(value, str) and bool(_LICENCE.fullmatch(value)),
        "the name of a licence at spdx.org, as CC-BY-4.0",
    ),
    "authors": (
        _are_authors,
        "a list of authors, each with family-names or name, and perhaps an orcid of its own, as "
        "https://orcid.org/0000-0002-1825-0097",
    ),
}


def read_citation(path: Path) -> dict[str, Any]:
    """Return authors, licence and title of a file in the Citation File Format.

    It is an `InputError` when the file is missing, or lacks one of them.
    """
    if not path.is_file():
        message = f"no such file in {path.absolute().parent}, where the command was called"
        raise InputError(f"{path}: {message}; --crate takes authors and licence from it")
    given = read_yaml(path)
    citation = given if isinstance(given, dict) else {}
    for key, (holds, allowed) in _KEYS.items():
        if not holds(citation.get(key)):
            raise InputError.of_value(path, key, citation.get(key), allowed)
    return citation


def write_crate(
    folder: Path, study_file: str, provenance: Mapping[str, Any], citation: Mapping[str, Any]
) -> None:
    """Describe all files of a published study in ``ro-crate-metadata.json``.

    The folder is whole but for its checksums. ``provenance`` is the content of
    ``provenance.json``, ``citation`` has authors and licence, see `read_citation`.
    """
    from rocrate.model import ContextEntity
    from rocrate.rocrate import ROCrate

    crate = ROCrate(folder, init=True, version=VERSION)

    def add(identifier: str, name: str, kind: str = "CreativeWork", **others: Any) -> Any:
        properties = {"@type": kind, "name": name, **others}
        return crate.add(ContextEntity(crate, identifier, properties))

    *numbers, numerics = (
        add(f"#{name.replace(' ', '-')}", name, "PropertyValue", value=str(provenance[name]))
        for name in ("points", "runs", "core hours", "numerics")
    )
    talus = add("#talus", "Talus", "SoftwareApplication")
    talus["softwareVersion"] = provenance["engine"]
    talus["softwareRequirements"] = provenance["libraries"]
    talus["additionalProperty"] = numerics
    command = f"talus study {study_file}"
    crate.add_action(
        talus,
        "#study",
        object=[crate.get(study_file)],
        result=[crate.get(name) for name in ("dataset.nc", REPORT)],
        properties={
            "name": command,
            "description": f"{command} computed the runs; talus publish {study_file} --crate, of "
            f"version {__version__}, published them.",
            "startTime": provenance["from"],
            "endTime": provenance["to"],
        },
    )
    licence = citation["license"]
    crate.name = provenance["title"] or provenance["study"]
    crate.description = f"Runs, figures and verdicts of the study {provenance['study']}."
    crate.license = add(f"https://spdx.org/licenses/{licence}", licence)
    root = crate.root_dataset
    authors = []
    for number, author in enumerate(citation["authors"], 1):
        known = {key: str(value) for key, value in author.items() if value}
        names = {to: known[key] for key, to in _AUTHOR.items() if key in known}
        whole = " ".join(names[to] for to in ("givenName", "familyName") if to in names)
        kind = "Organization" if "name" in known else "Person"
        identifier = known.get("orcid", f"#author-{number}")
        authors.append(add(identifier, known.get("name", whole), kind, **names))
    root["author"] = authors
    root["conformsTo"] = add(PROFILE, "Process Run Crate")
    root["additionalProperty"] = numbers
    for entity in crate.get_by_type("File"):
        path = folder / unquote(entity.id)
        media = _MEDIA.get(path.suffix) or guess_type(path.name)[0] or "application/octet-stream"
        entity["name"], entity["contentSize"] = path.name, str(path.stat().st_size)
        entity["encodingFormat"] = media
        entity["description"] = _MEANINGS.get(path.suffix, "file of the study")
    crate.metadata.write(folder)


#: Folder of the published studies, beside the results of other studies.
PUBLISHED = Path("results/published")

#: Result files of a published study besides its figures.
RESULT_FILES = ("dataset.nc", "claims.json", "verdicts.csv")

#: Files that are generated: provenance, report, the checksums of all files, and the crate.
PROVENANCE, REPORT, CHECKSUMS = "provenance.json", "report.html", "SHA256SUMS"
GENERATED_FILES = PROVENANCE, REPORT, CHECKSUMS, CRATE_FILE

#: Largest size of all published studies together, bytes.
MOST_BYTES = 42_000_000


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

    Returns the folder written.

    Raises `InputError` when a file is missing, damaged or outdated, when something else occupies
    the target, when all published studies together would be too large, or when a crate lacks
    authors.
    """
    if crate and not find_spec("rocrate"):
        raise InputError("--crate: needs the package rocrate; pip install rocrate")
    citation = read_citation(CITATION) if crate else None
    study = load_study(study_path, results)
    folder = folder_of_results(study, Path(results)) / study.name
    names = _published_files(study, folder)
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


def _published_files(study: Study, folder: Path) -> list[str]:
    """Return the names of the files that are copied; all are there, and none is a study's."""
    names = [*RESULT_FILES, *(one.file for one in study.questions)]
    names += ["boundaries.csv"] if study.boundaries else []
    names += [
        f"figures/{name}{end}"
        for name, spec in study.entries.items()
        for end in spec.suffixes
        if spec.animated or end != ".png"
    ]
    for name in names:
        if not (folder / name).is_file():
            raise InputError(f"{folder / name}: missing; run the study to its end first")
    bought = extra_amounts_file(folder)
    names += [bought.name] if bought.is_file() else []
    taken = {Path(name).parts[0] for name in (*names, *GENERATED_FILES, "boundaries.csv")}
    for file in study.sources:
        if file.name in taken:
            allowed = f"another name, as {file.name} is published of every study"
            raise InputError.of_value(file, "", file.name, allowed)
    return names


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
    others = (path for path in target.iterdir() if path.is_dir() and path != output)
    total = sum(map(folder_size, [temporary, *(one for one in others if one.name[0] != ".")]))
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
    """Raise `InputError` unless figures, tables and verdicts are as they were made.

    The first file that differs is set aside.
    """
    require_unchanged(study.entries.values(), folder / "figures")
    require_table(folder)
    table = folder / "boundaries.csv"
    with checked_read(table, "table", replaceable=True) if study.boundaries else nullcontext():
        if study.boundaries and table.read_text("utf-8") != format_csv(study, results.boundaries):
            raise ValueError("not what the dataset gives")
