"""A stranger's paper, as docs/extending.md tells, gets figure, verdict, table and report."""

import json
import shutil
from pathlib import Path

import pytest

from sim.base.errors import InputError
from sim.claims.claim import claims
from sim.study.catalogue import FIGURES
from sim.study.load import load_study
from sim.study.papers import papers
from tests.made.plugins import restore_plugins
from tests.made.processes import ROOT
from tests.made.project import planned_jobs, snakemake

EXAMPLES, STUDY, CLAIM = ROOT / "docs" / "examples", "silbert.yaml", "silbert_steeper"


def bring_paper(folder: Path) -> Path:
    """Copy the paper and its study, with short runs, into a folder; return the study."""
    shutil.copytree(EXAMPLES / "silbert", folder / "silbert")
    text = (EXAMPLES / STUDY).read_text(encoding="utf-8")
    short = text.replace("transient: 300, average: 100", "transient: 10, average: 10")
    assert short != text
    (folder / STUDY).write_text(short, encoding="utf-8")
    return folder / STUDY


@pytest.fixture(scope="module")
def tree(tmp_path_factory) -> Path:
    """Return a folder in which the study of the paper has run to its end."""
    tree = tmp_path_factory.mktemp("paper")
    bring_paper(tree)
    process = snakemake(tree, study=STUDY)
    assert process.returncode == 0, process.stderr
    return tree


def test_the_paper_gets_figure_verdict_table_and_report(tree):
    results = tree / "results" / "silbert"
    (claim,) = [
        one
        for one in json.loads((results / "claims.json").read_text())["claims"]
        if one["paper"] == "silbert"
    ]
    assert claim["id"] == CLAIM and claim["verdict"] in ("reproduced", "inconclusive")
    assert claim["criterion"] == "V rises over at least 3 angles (Jonckheere's trend test)"
    assert CLAIM in (results / "claims.csv").read_text()
    caption = (results / "figures" / "silbert_slopes.caption.txt").read_text()
    assert caption.startswith("Silbert et al. (2001), steady flows. Mean velocity V")
    assert len((results / "figures" / "silbert_slopes.csv").read_text().splitlines()) == 4
    report = (results / "report.html").read_text()
    assert "Silbert et al. (2001), steady flows" in report
    assert f'id="claim-{CLAIM}" data-paper="silbert"' in report


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("silbert/judges.py", {"claims": 1, "report": 1}),
        ("silbert/claims.yaml", {"claims": 1, "report": 1}),
    ],
)
def test_an_edit_of_the_paper_judges_anew_and_runs_nothing(tree, name, expected):
    path, before = tree / name, (tree / name).read_text()
    try:
        path.write_text(before + "# edited\n")
        assert planned_jobs(tree, study=STUDY) == expected
    finally:
        path.write_text(before)


def load(folder: Path) -> None:
    """Load the study with everything that its paper says."""
    with restore_plugins():
        load_study(folder / STUDY, None)
        list(FIGURES)
        claims()


def test_the_paper_is_loaded_beside_those_that_ship(tmp_path):
    bring_paper(tmp_path)
    with restore_plugins():
        load_study(tmp_path / STUDY, None)
        assert list(papers()) == ["walton", "gallas", "silbert"]
        assert FIGURES["silbert_slopes"].kind == "curves"
        assert [claim.id for claim in claims()][-1] == CLAIM
    assert list(papers()) == ["walton", "gallas"]
    assert "silbert_slopes" not in FIGURES and claims()[-1].id == "G36"


@pytest.mark.parametrize(
    ("name", "old", "new", "message"),
    [
        ("paper.yaml", "system: chute", "system: slide", "system.*'slide'"),
        ("paper.yaml", "author:", "autor:", "paper.yaml: a(utor|uthor)"),
        ("paper.yaml", "name: silbert", "name: walton", "Talus has one of this name"),
        ("figures.yaml", "kind: curves", "kind: waves", r"figures.yaml: figures\[0\].kind"),
        ("figures.yaml", "x: angle", "x: angel", r"figures.yaml: figures\[0\].x: got 'angel'"),
        ("figures.yaml", "silbert_slopes", "walton_2", "a name that no other figure has"),
        ("claims.yaml", "judges.steeper", "judges.flatter", "claims.yaml: .*flatter"),
        ("claims.yaml", "{least}", "{most}", "claims.yaml: judge silbert_steeper: .*most"),
        ("claims.yaml", "{least: 3}", "{fewest: 3}", "claims.yaml: judge silbert_steeper"),
        ("claims.yaml", f"id: {CLAIM}", "id: W1", "claims.yaml: judge 'W1': a name has"),
        ("claims.yaml", "claims:", "claim:", "claims.yaml: .*claims, a list, and nothing else"),
        (
            "judges.py",
            "import trend",
            "import trends",
            "claims.yaml: judges.py line 3: .*trends",
        ),
        ("__init__.py", "sim.paper(", "sim.papre(", "plugins.0.*line 5: AttributeError"),
    ],
)
def test_a_mistake_in_the_paper_is_one_line(tmp_path, name, old, new, message):
    bring_paper(tmp_path)
    path = tmp_path / "silbert" / name
    text = path.read_text(encoding="utf-8")
    assert old in text
    path.write_text(text.replace(old, new), encoding="utf-8")
    with pytest.raises(InputError, match=message) as error:
        load(tmp_path)
    assert "\n" not in str(error.value)
    assert list(papers()) == ["walton", "gallas"]
