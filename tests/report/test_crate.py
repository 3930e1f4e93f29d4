"""A publication as an RO-Crate, and what Zenodo reads of the repository."""

import hashlib
import json

import pytest
import yaml

from sim.base.errors import InputError
from sim.report import publish
from sim.report.publish import read_citation, write_crate
from tests.made.processes import ROOT, refusal

ORIGIN = {
    "study": "made",
    "title": "A study",
    "points": 2,
    "runs": 6,
    "core hours": 0.5,
    "from": "2026-11-23T08:15:41+00:00",
    "to": "2026-11-24T00:15:46+00:00",
    "engine": "0.1.0",
    "numerics": "1",
    "libraries": "python 3.11.7 numpy 2.4.6",
}

AUTHORS = [
    {
        "family-names": "Doe",
        "given-names": "Ada",
        "orcid": "https://orcid.org/0000-0002-1825-0097",
        "affiliation": "Institute of Grains",
    },
    {"family-names": "Roe"},
    {"name": "A group"},
]


@pytest.fixture
def crate(tmp_path):
    """Write a crate of a small publication; return it as the library reads it."""
    reader = pytest.importorskip("rocrate.rocrate")
    (tmp_path / "figures").mkdir()
    for name in ("made.yaml", "dataset.nc", "report.html", "figures/walton_2.svg"):
        (tmp_path / name).write_text(name)
    citation = {"title": "Grains", "license": "CC-BY-4.0", "authors": AUTHORS}
    write_crate(tmp_path, "made.yaml", ORIGIN, citation)
    return reader.ROCrate(tmp_path)


def test_a_crate_says_who_made_it_under_which_licence_and_how(crate):
    assert (crate.name, crate.license.id) == ("A study", "https://spdx.org/licenses/CC-BY-4.0")
    ada, *others = crate.root_dataset["author"]
    assert (ada.id, ada.type, ada["name"]) == (AUTHORS[0]["orcid"], "Person", "Ada Doe")
    assert ada["affiliation"] == "Institute of Grains"
    named = [(one["name"], one.type) for one in others]
    assert named == [("Roe", "Person"), ("A group", "Organization")]
    (action,) = crate.get_by_type("CreateAction")
    assert [one.id for one in action["object"]] == ["made.yaml"]
    assert [one.id for one in action["result"]] == ["dataset.nc", "report.html"]
    assert (action["startTime"], action["endTime"]) == (ORIGIN["from"], ORIGIN["to"])
    assert action["name"] == "talus study made.yaml"
    program = action["instrument"]
    assert (program["name"], program["softwareVersion"]) == ("Talus", "0.1.0")
    assert program["softwareRequirements"] == ORIGIN["libraries"]
    assert program["additionalProperty"]["value"] == "1"
    numbers = {one["name"]: one["value"] for one in crate.root_dataset["additionalProperty"]}
    assert numbers == {"points": "2", "runs": "6", "core hours": "0.5"}
    files = {one.id: one for one in crate.get_by_type("File")}
    assert files.keys() == {"made.yaml", "dataset.nc", "report.html", "figures/walton_2.svg"}
    assert files["dataset.nc"]["encodingFormat"] == "application/netcdf"
    assert files["figures/walton_2.svg"]["contentSize"] == str(len("figures/walton_2.svg"))
    assert all(one["description"] for one in files.values())


def test_a_published_study_becomes_a_crate_with_the_authors_of_the_folder(
    finished, tmp_path, monkeypatch, capsys
):
    reader = pytest.importorskip("rocrate.rocrate")
    study, results = finished
    monkeypatch.chdir(tmp_path)
    message = refusal(capsys, "publish", str(study), "--crate")
    assert message.startswith(f"error: CITATION.cff: no such file in {tmp_path}, where the comm")
    assert not (tmp_path / "results" / "published").exists()
    (tmp_path / "CITATION.cff").write_text((ROOT / "CITATION.cff").read_text())
    output = publish.publish(study, results, tmp_path / "published", crate=True)
    crate = reader.ROCrate(output)
    (author,) = crate.root_dataset["author"]
    assert author["name"] == "Talus developers"
    described = {one.id for one in crate.get_by_type("File")}
    there = {one.relative_to(output).as_posix() for one in output.rglob("*") if one.is_file()}
    assert described == there - {"SHA256SUMS", "ro-crate-metadata.json"}
    sums = (output / "SHA256SUMS").read_text()
    text = (output / "ro-crate-metadata.json").read_bytes()
    assert f"{hashlib.sha256(text).hexdigest()}  ro-crate-metadata.json" in sums


@pytest.mark.parametrize(
    "changed",
    [
        *({"title": None}, {"license": ["MIT"]}, {"license": "a b/../c"}, {"license": "MIT\n"}),
        {"authors": [{"name": "A", "orcid": "./"}]},
        {"authors": [{"name": name, "orcid": AUTHORS[0]["orcid"]} for name in "AB"]},
        *({"authors": one} for one in ([], ["A"], [{"name": None}], [{"family-names": " "}])),
        {"authors": [{"orcid": "x"}]},
    ],
)
def test_a_citation_without_what_a_crate_needs_is_refused(tmp_path, changed):
    path, (key,) = tmp_path / "CITATION.cff", changed
    known = {"title": "Grains", "license": "MIT", "authors": [{"name": "A group"}]}
    path.write_text(yaml.safe_dump(known | changed))
    with pytest.raises(InputError, match=rf"CITATION.cff: {key}: got .*; allowed: (the|a list of)"):
        read_citation(path)


def test_zenodo_reads_what_the_citation_says():
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    deposit = json.loads((ROOT / ".zenodo.json").read_text(encoding="utf-8"))
    assert deposit == {
        "title": citation["title"],
        "version": citation["version"],
        "license": citation["license"],
        "upload_type": "software",
        "description": f"<p>{citation['abstract']}</p>",
        "keywords": citation["keywords"],
        "creators": [{"name": author["name"]} for author in citation["authors"]],
    }
