"""A published study as an RO-Crate: who made it, under which licence, and how.

``ro-crate-metadata.json`` follows RO-Crate 1.1 (https://w3id.org/ro/crate/1.1); the action that
made the data follows the profile Process Run Crate. The library ``rocrate`` writes and reads it.
"""

import re
from collections.abc import Mapping
from mimetypes import guess_type
from pathlib import Path
from typing import Any

from sim.base.errors import InputError
from sim.base.program import __version__
from sim.base.yaml import read_yaml

#: File of authors and licence, in the folder where the command is called.
CITATION = Path("CITATION.cff")

#: Name that the format gives to the description of a crate.
CRATE_FILE = "ro-crate-metadata.json"

#: Version of the format.
VERSION = "1.1"

#: Profile of crates that say which command made which data.
PROFILE = "https://w3id.org/ro/wfrun/process/0.5"

#: What the keys of a citation must hold.
_KEYS = {
    "title": (str, "the title of what is published"),
    "license": (str, "the name of a licence at spdx.org, as CC-BY-4.0"),
    "authors": (list, "a list of authors, each with family-names or name"),
}

#: Identifiers at spdx.org and orcid.org, which become addresses.
_LICENCE = re.compile(r"[A-Za-z0-9][A-Za-z0-9.+-]{0,99}")
_ORCID = re.compile(r"https://orcid\.org/(\d{4}-){3}\d{3}[\dX]")

#: Media type and meaning of the files of a publication, by suffix.
_FILES = {
    ".nc": ("application/netcdf", "all numbers of the study, a row per point"),
    ".yaml": ("application/yaml", "study file: the whole input, or a part of it"),
    ".py": ("text/x-python", "plug-in of the study"),
    ".json": ("application/json", "verdicts, provenance, or what was bought to decide claims"),
    ".csv": ("text/csv", "table"),
    ".svg": ("image/svg+xml", "figure"),
    ".gif": ("image/gif", "animation"),
    ".html": ("text/html", "report"),
    ".png": ("image/png", "still picture of an animation"),
    ".txt": ("text/plain", "caption of a figure"),
}


def read_citation(path: Path) -> dict[str, Any]:
    """Return authors, licence and title of a file in the Citation File Format.

    Raises
    ------
    InputError
        When the file is missing, or lacks one of them.
    """
    if not path.is_file():
        message = f"no such file in {path.absolute().parent}, where the command was called"
        raise InputError(f"{path}: {message}; --crate takes authors and licence from it")
    given = read_yaml(path)
    citation = given if isinstance(given, dict) else {}
    for key, (kind, allowed) in _KEYS.items():
        if not isinstance(citation.get(key), kind) or not citation[key]:
            raise InputError.of_value(path, key, citation.get(key), allowed)
    if not _LICENCE.fullmatch(citation["license"]):
        raise InputError.of_value(path, "license", citation["license"], _KEYS["license"][1])
    orcids: set[str] = set()
    for number, author in enumerate(citation["authors"]):
        names = author.keys() & {"name", "family-names"} if isinstance(author, dict) else ()
        if not names or not all(_is_name(author[key]) for key in names):
            raise InputError.of_value(path, f"authors[{number}]", author, _KEYS["authors"][1])
        orcid = author.get("orcid")
        if orcid and (orcid in orcids or not _ORCID.fullmatch(str(orcid))):
            allowed = "an address of this author alone, as https://orcid.org/0000-0002-1825-0097"
            raise InputError.of_value(path, f"authors[{number}].orcid", orcid, allowed)
        orcids.add(str(orcid))
    return citation


def _is_name(value: Any) -> bool:
    return isinstance(value, str) and bool(value.strip()) and value.isprintable()


def require_rocrate() -> None:
    """Raise `InputError` where the library that writes crates is not installed."""
    try:
        import rocrate  # noqa: F401
    except ImportError:
        raise InputError("--crate: needs the package rocrate; pip install rocrate") from None


def write_crate(
    folder: Path, study_file: str, provenance: Mapping[str, Any], citation: Mapping[str, Any]
) -> None:
    """Describe all files of a published study in ``ro-crate-metadata.json``.

    Parameters
    ----------
    folder : Path
        Folder of the publication, whole but for its checksums.
    study_file : str
        Name of the study file in it.
    provenance : mapping
        Content of ``provenance.json``.
    citation : mapping
        Authors and licence, see `read_citation`.
    """
    from rocrate.rocrate import ROCrate

    crate = ROCrate(folder, init=True, version=VERSION)
    _describe_publication(crate, provenance, citation)
    _describe_files(crate, folder)
    _describe_computation(crate, study_file, provenance)
    crate.metadata.write(folder)


def _entity(crate: Any, identifier: str, kind: str, **properties: Any) -> Any:
    """Add something that is no file to a crate, and return it."""
    from rocrate.model import ContextEntity

    return crate.add(ContextEntity(crate, identifier, properties={"@type": kind, **properties}))


def _describe_publication(
    crate: Any, provenance: Mapping[str, Any], citation: Mapping[str, Any]
) -> None:
    """Describe the publication as a whole: title, authors, licence and size."""
    root, licence = crate.root_dataset, citation["license"]
    crate.name = provenance["title"] or provenance["study"]
    crate.description = f"Runs, figures and verdicts of the study {provenance['study']}."
    address = f"https://spdx.org/licenses/{licence}"
    crate.license = _entity(crate, address, "CreativeWork", name=licence)
    root["author"] = [
        _author(crate, number, author) for number, author in enumerate(citation["authors"], 1)
    ]
    root["conformsTo"] = _entity(crate, PROFILE, "CreativeWork", name="Process Run Crate")
    root["additionalProperty"] = [
        _property(crate, name, provenance) for name in ("points", "runs", "core hours")
    ]


def _author(crate: Any, number: int, author: Mapping[str, Any]) -> Any:
    """Add an author of a citation to a crate."""
    given, family = (str(author.get(key) or "") for key in ("given-names", "family-names"))
    name = str(author.get("name", f"{given} {family}".strip()))
    details = {"givenName": given, "familyName": family, "affiliation": author.get("affiliation")}
    return _entity(
        crate,
        str(author.get("orcid") or f"#author-{number}"),
        "Organization" if "name" in author else "Person",
        name=name,
        **{key: str(value) for key, value in details.items() if value},
    )


def _property(crate: Any, name: str, provenance: Mapping[str, Any]) -> Any:
    """Add a number or a text of the provenance to a crate."""
    identifier = f"#{name.replace(' ', '-')}"
    return _entity(crate, identifier, "PropertyValue", name=name, value=str(provenance[name]))


def _describe_files(crate: Any, folder: Path) -> None:
    """Describe each file: its size, its media type and what it holds."""
    for path in sorted(path for path in folder.rglob("*") if path.is_file()):
        file = crate.get(path.relative_to(folder).as_posix())
        guess = guess_type(path.name)[0] or "application/octet-stream"
        media, meaning = _FILES.get(path.suffix, (guess, "file of the study"))
        file["name"], file["contentSize"] = path.name, str(path.stat().st_size)
        file["encodingFormat"], file["description"] = media, meaning


def _describe_computation(crate: Any, study_file: str, provenance: Mapping[str, Any]) -> None:
    """Describe what made the results: the program, its numerics, libraries and command."""
    program = _entity(
        crate,
        "#talus",
        "SoftwareApplication",
        name="Talus",
        softwareVersion=provenance["engine"],
        softwareRequirements=provenance["libraries"],
        additionalProperty=_property(crate, "numerics", provenance),
    )
    crate.add_action(
        program,
        "#study",
        object=[crate.get(study_file)],
        result=[crate.get(name) for name in ("dataset.nc", "report.html")],
        properties={
            "name": f"talus study {study_file}",
            "description": f"talus study {study_file} computed the runs; talus publish "
            f"{study_file} --crate, of version {__version__}, published them.",
            "startTime": provenance["from"],
            "endTime": provenance["to"],
        },
    )
