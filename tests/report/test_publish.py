"""Publishing: what readers need, whole, and small enough for a repository."""

import hashlib
import json
import re
from pathlib import Path

import pytest

from sim.__main__ import main
from sim.base.errors import InputError
from sim.base.seals import DamagedError
from sim.figures.pictures import RECORD_FILE
from sim.report import publish
from sim.study.figure_spec import FIGURES
from sim.study.load import ExtraAmounts, load_study, write_extra_amounts
from tests.made.processes import refusal


def pictures() -> list[str]:
    drawn = ("walton_2", "gallas_1a", "gallas_1b", "gallas_1c")
    return [f"figures/{name}{suffix}" for name in drawn for suffix in FIGURES[name].suffixes[1:]]


def names(folder: Path) -> set[str]:
    return {path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file()}


def test_everything_a_reader_needs_is_there_linked_and_can_be_checked(finished, tmp_path):
    study, results = finished
    output = publish.publish(study, results, tmp_path / "published")
    made = {"report.html", "dataset.nc", "claims.json", "verdicts.csv", "made.yaml"}
    assert names(output) == {*made, *pictures(), "provenance.json", "SHA256SUMS"}
    assert (output / "made.yaml").read_text() == study.read_text()
    origin = json.loads((output / "provenance.json").read_text())
    assert origin["study"] == "made" and origin["points"] > 10 and origin["failed runs"] == 3
    assert origin["from"] <= origin["to"] and origin["core hours"] > 0
    lines = (output / "SHA256SUMS").read_text().splitlines()
    checksums = {name: sum for sum, name in (line.split("  ") for line in lines)}
    assert checksums.keys() == names(output) - {"SHA256SUMS"}
    for name, checksum in checksums.items():
        assert hashlib.sha256((output / name).read_bytes()).hexdigest() == checksum
    page = (output / "report.html").read_text()
    linked = set(re.findall(r'(?:src|href)="(?!#|data:)([^"]*)"', page))
    assert linked == {name for name in pictures() if Path(name).suffix in (".svg", ".csv")}


def test_what_was_bought_to_decide_goes_with_it(finished, tmp_path):
    study, results = finished
    study.write_text(study.read_text() + "decide: {budget: 1, precision: 0.1}\n")
    amounts = {
        point.id: {"replicates": float(point.parameters.replicates)}
        for point in load_study(study, results).points.values()
    }
    study.write_text(re.sub(r"replicates: \d+", "replicates: 1", study.read_text()))
    write_extra_amounts(results / "made", ExtraAmounts(amounts, 0.0))
    output = publish.publish(study, results, tmp_path / "published")
    assert (output / "bought.json").is_file()


def test_publishing_again_replaces_all_of_it(finished, tmp_path):
    study, results = finished
    output = publish.publish(study, results, tmp_path / "published")
    for name in ("old.svg", "walton_2.csv"):
        (output / "figures" / name).write_text("old")
    publish.publish(study, results, tmp_path / "published")
    assert (output / "figures" / "walton_2.csv").read_text() != "old"
    assert not (output / "figures" / "old.svg").exists()
    assert [path.name for path in (tmp_path / "published").iterdir()] == ["made"]


def tree(folder: Path) -> dict[str, bytes]:
    return {str(path): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


@pytest.mark.parametrize(
    "place",
    ["results", "results/made", "results/link", ".", "other", "file", "lost", "linked", "led"],
)
def test_only_what_was_published_is_replaced(finished, tmp_path, monkeypatch, place, capsys):
    study, results = finished
    monkeypatch.chdir(tmp_path)
    (results / "link").symlink_to(".")
    if place == ".":
        # The results would be within the publication.
        monkeypatch.chdir((tmp_path / "results").rename(tmp_path / "made"))
        Path("results").symlink_to(".")
        place = ".."
    elif place == "other":
        (tmp_path / "other" / "made").mkdir(parents=True)
        (tmp_path / "other" / "made" / "precious").write_text("text")
    elif place == "file":
        (tmp_path / place).write_text("text")
    elif place == "lost":
        (tmp_path / place).symlink_to("nowhere")
    elif place in ("linked", "led"):
        publish.publish(study, results, tmp_path / place)
        (tmp_path / place / "made").rename(tmp_path / place / "elsewhere")
        (tmp_path / place / "made").symlink_to("elsewhere" if place == "linked" else "nowhere")
    before = tree(tmp_path)
    assert refusal(capsys, "publish", study, "--to", place).startswith("error: --to: got ")
    assert tree(tmp_path) == before


@pytest.mark.parametrize(
    ("old", "new", "named"),
    [
        ("frequency: [10, 20, 50, 80]", "frequency: [10, 20, 50, 90]", "point belt-"),
        ("replicates: 3", "replicates: 4", "replicates of belt-"),
        ("title: A made-up", "title: Another", "title"),
        ("name: rough", "name: smooth", "series of chute-"),
        ("0.85]}\n    figures: [walton_2]", "0.85]}", "figures of chute-"),
    ],
)
def test_a_study_changed_since_its_runs_is_refused(finished, monkeypatch, old, new, named, capsys):
    study, results = finished
    monkeypatch.chdir(study.parent)
    text = study.read_text()
    assert old in text
    study.write_text(text.replace(old, new))
    before = tree(results)
    for command in ("publish", "report", "claims"):
        line = refusal(capsys, command, study)
        assert line.startswith(f"error: {study}: {named}"), line
        assert line.endswith("run the study again")
    assert tree(results) == before


#: Ways to damage a file: nothing or half of it is left, its last line is lost, a bit is flipped.
DAMAGE = {
    "empty": lambda content: b"",
    "half": lambda content: content[: len(content) // 2],
    "line": lambda content: b"".join(content.splitlines(keepends=True)[:-1]),
    "bit": lambda content: content[:-99] + bytes([content[-99] ^ 1]) + content[-98:],
}


DAMAGED = [
    *(("dataset.nc", damage) for damage in DAMAGE),
    ("claims.json", "line"),
    *((f"figures/walton_2{end}", "bit") for end in (".csv", ".svg", ".png", ".caption.txt")),
]


@pytest.mark.parametrize(
    ("command", "name", "damage"),
    [
        *((command, *one) for command in ("publish", "report") for one in DAMAGED),
        *(("publish", f"{name}.csv", "half") for name in ("claims", "verdicts")),
    ],
)
def test_what_is_damaged_is_named_and_set_aside(
    finished, monkeypatch, name, command, damage, capsys
):
    study, results = finished
    monkeypatch.chdir(study.parent)
    path = Path("results") / "made" / name
    path.write_bytes(DAMAGE[damage](path.read_bytes()))
    line = refusal(capsys, command, study)
    assert line.startswith(f"error: {path}: damaged") and "rerun the study" in line
    assert not path.exists() and path.with_name(f"{path.name}.damaged").exists()
    assert not (results / "published").exists()


@pytest.mark.parametrize("name", ["boundaries.csv", "claims.json", "figures", "SHA256SUMS"])
def test_a_study_file_named_like_what_is_published_is_refused(finished, monkeypatch, name, capsys):
    study, results = finished
    monkeypatch.chdir(study.parent)
    study = study.rename(study.with_name(name))
    line = refusal(capsys, "publish", study)
    assert line.startswith(f"error: {study}: got '{name}'; allowed: another name")
    assert not (results / "published").exists()


def test_an_unfinished_study_is_refused(finished, tmp_path):
    study, results = finished
    (results / "made" / "figures" / RECORD_FILE).unlink()
    with pytest.raises(DamagedError, match=r"walton_2.*\.drawn\.json does not know it"):
        publish.publish(study, results, tmp_path / "published")
    (results / "made" / "claims.json").unlink()
    with pytest.raises(InputError, match=r"claims.json: missing; run the study to its end"):
        publish.publish(study, results, tmp_path / "published")
    assert not (tmp_path / "published").exists()


def test_too_much_is_refused_and_what_was_published_stays(finished, tmp_path, monkeypatch, capsys):
    study, _ = finished
    monkeypatch.chdir(tmp_path)
    target = tmp_path / "published"
    options = ["publish", str(study), "--to", str(target)]
    assert main(options) == 0
    (target / "other").mkdir()
    (target / "other" / "report.html").write_bytes(bytes(2000))
    monkeypatch.setattr(publish, "MOST_BYTES", publish.folder_size(target / "made") + 1500)
    before = tree(target)
    assert "allowed: at most" in refusal(capsys, *options)
    assert tree(target) == before
    assert {path.name for path in target.iterdir()} == {"made", "other"}
