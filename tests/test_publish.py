"""Publishing: what readers need, whole, and small enough for a repository."""

import json
import re
from pathlib import Path

import pytest

from sim import publish
from sim.cli import main
from sim.errors import InputError
from sim.figures import FIGURES
from sim.study import load_study
from tests.factories import make_study
from tests.report.made import write_claims


@pytest.fixture
def finished(tmp_path):
    """A made-up study with everything that a workflow leaves."""
    study, results = make_study(tmp_path)
    folder = results / "made"
    (folder / "figures").mkdir()
    made = {".svg": '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 4 3"/>', ".csv": "a\n1\n"}
    for name in ("report.html", "claims.csv", *pictures(), "figures/old.svg"):
        (folder / name).write_text(made.get(Path(name).suffix, name))
    write_claims(folder / "claims.json", list(load_study(study, results).points))
    assert main(["dataset", str(study), "--results", str(results)]) == 0
    return study, results


def pictures() -> list[str]:
    drawn = ("walton_2", "gallas_1a", "gallas_1b", "gallas_1c")
    return [f"figures/{name}{suffix}" for name in drawn for suffix in FIGURES[name].suffixes[1:]]


def test_everything_a_reader_needs_is_there(finished, tmp_path):
    study, results = finished
    output = publish.publish(study, results, tmp_path / "published")
    names = {path.relative_to(output).as_posix() for path in output.rglob("*") if path.is_file()}
    assert names == {
        "report.html",
        "dataset.nc",
        "claims.json",
        "claims.csv",
        *pictures(),
        "made.yaml",
        "provenance.json",
    }
    assert (output / "made.yaml").read_text() == study.read_text()
    origin = json.loads((output / "provenance.json").read_text())
    assert origin["study"] == "made" and origin["points"] > 10 and origin["failed runs"] == 3
    assert origin["from"] <= origin["to"] and origin["core hours"] > 0


def test_the_report_links_its_figures_and_holds_everything_else(finished, tmp_path):
    output = publish.publish(*finished, tmp_path / "published")
    page = (output / "report.html").read_text()
    linked = set(re.findall(r'(?:src|href)="(?!#|data:)([^"]*)"', page))
    assert linked == {f"figures/{name}" for name in shown()}
    assert all((output / name).is_file() for name in linked)


def shown() -> list[str]:
    return [Path(name).name for name in pictures() if Path(name).suffix in (".svg", ".csv")]


def test_publishing_again_replaces_all_of_it(finished, tmp_path):
    study, results = finished
    output = publish.publish(study, results, tmp_path / "published")
    (output / "figures" / "old.svg").write_text("old")
    (results / "made" / "claims.csv").write_text("new")
    publish.publish(study, results, tmp_path / "published")
    assert (output / "claims.csv").read_text() == "new"
    assert not (output / "figures" / "old.svg").exists()
    assert [path.name for path in (tmp_path / "published").iterdir()] == ["made"]


def test_an_unfinished_study_is_refused(finished, tmp_path):
    study, results = finished
    (results / "made" / "claims.json").unlink()
    with pytest.raises(InputError, match=r"claims.json: missing; run the study to its end"):
        publish.publish(study, results, tmp_path / "published")
    assert not (tmp_path / "published").exists()


def test_too_much_is_refused_and_what_was_published_stays(finished, tmp_path, monkeypatch, capsys):
    study, results = finished
    target = tmp_path / "published"
    options = ["publish", str(study), "--results", str(results), "--to", str(target)]
    assert main(options) == 0
    (target / "other").mkdir()
    (target / "other" / "report.html").write_bytes(bytes(2000))
    monkeypatch.setattr(publish, "LARGEST", publish.size(target / "made") + 1500)
    (results / "made" / "claims.csv").write_text("new")
    assert main(options) == 2
    assert "allowed: at most" in capsys.readouterr().err
    assert (target / "made" / "claims.csv").read_text() == "a\n1\n"
    assert {path.name for path in target.iterdir()} == {"made", "other"}
