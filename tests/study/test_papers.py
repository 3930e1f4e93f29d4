"""A paper's own values: where they stand in a study, in evidence and in what is told."""

import json
import shutil
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace

import pandas as pd
import pytest

from sim.base.plugins import load_plugins
from sim.claims.evidence import Evidence, combined_readings, paper_of
from sim.claims.place import Points
from sim.claims.verdict import Untestable
from sim.figures.plot import parameter_label, units_of_parameters
from sim.parameters import parse_point, point_id
from sim.report.points import warnings
from sim.study.load import parse_study
from sim.study.papers import paper_values, papers
from tests.made.processes import ROOT, restore_plugins, without_plugins
from tests.made.results import made_point, made_results

#: Values of a paper, two of them of its law alone.
OWN = {
    "friction": 0.5,
    "law": "hertz",
    "attraction": "clipped",
    "tangential_unloading": "rescaled",
    "cell": 8.0,
}


@pytest.fixture(autouse=True)
def folder(tmp_path) -> Iterator[Path]:
    """Return a folder with the paper, which is loaded."""
    with restore_plugins():
        load_paper(tmp_path, OWN)
        yield tmp_path


def load_paper(
    folder: Path, values: dict, name: str = "mine", files: dict | None = None, **keys: str
):
    """Write and load a paper with values of its own, and with further files."""
    words = {"name": name, "author": "Own", "quote": "Own (2000)", "system": "chute"} | keys
    texts = {"paper.yaml": json.dumps(words | {"defaults": {"chute": values}})}
    texts["__init__.py"] = "import talus\n\ntalus.paper(__name__)\n"
    (folder / name).mkdir()
    for file, text in (texts | (files or {})).items():
        (folder / name / file).write_text(text)
    load_plugins(folder / name)


def only_point(base: dict, **keys):
    series = [{"name": "a", "system": "chute", "base": base}]
    study = parse_study({"study": "s", "series": series} | keys, "s.yaml", None)
    (point,) = study.points.values()
    return point.parameters


@pytest.mark.parametrize(
    ("keys", "base", "expected"),
    [
        ({"paper": "mine"}, {}, OWN),
        ({"paper": "mine"}, {"friction": 0.3}, OWN | {"friction": 0.3}),
        ({"paper": "mine", "defaults": {"chute": {"cell": 6}}}, {}, OWN | {"cell": 6}),
        # What is the law's own goes with it.
        (
            {"paper": "mine"},
            {"law": "walton_braun"},
            {"friction": 0.5, "cell": 8.0, "law": "walton_braun"},
        ),
        (
            {"paper": "mine"},
            {"law": "spring_dashpot"},
            {"friction": 0.5, "cell": 8.0, "law": "spring_dashpot", "attraction": "clipped"},
        ),
        ({"paper": "walton"}, {}, {}),
        ({}, {}, {}),
    ],
)
def test_a_study_that_names_a_paper_has_its_values_where_it_gives_none(keys, base, expected):
    point = only_point(base, **keys)
    assert point_id(point) == point_id(parse_point({"system": "chute"} | expected, "p"))


def test_evidence_that_names_nothing_is_at_the_values_of_the_claims_paper():
    points = [
        made_point("chute", {"velocity": 1.0}, depth=3),
        made_point("chute", {"velocity": 2.0}, depth=3, **OWN),
        made_point("chute", {"velocity": 3.0}, depth=3, friction=0.5, cell=8),
    ]
    results = made_results(*points)
    usual, own = (
        Evidence(results, "published", points=Points(results, one))
        for one in (None, papers()["mine"])
    )
    assert usual.at("chute", depth=3).velocity.nominal_value == pytest.approx(1)
    assert own.at("chute", depth=3).velocity.nominal_value == pytest.approx(2)
    # Of another law, the paper's values for its own law are not asked.
    place = own.at("chute", depth=3, law="walton_braun")
    assert place.velocity.nominal_value == pytest.approx(3)
    with pytest.raises(Untestable, match=r"at depth 3, friction 0\.4, all else as in"):
        own.at("chute", depth=3, friction=0.4)
    for name, system, found in (
        ("mine", "chute", "mine"),
        ("mine", "belt", "gallas"),
        ("", "chute", "walton"),
        ("", "conveyor", ""),
    ):
        assert getattr(paper_of(system, name), "name", "") == found
    # Runs at its values are of no other reading.
    assert combined_readings(results, "chute", papers()["mine"])[0] == {}
    laws = [one.get("law") for one in combined_readings(results, "chute", papers()["mine"])]
    assert laws == [None, "walton_braun"]


def test_what_is_left_at_a_papers_values_is_told_of_that_paper():
    points = [only_point({"depth": n}, paper="mine") for n in (2, 4)]
    told = paper_values(points, "mine")
    assert told["Own (2000), chute"][:2] == ["μ = 0.5", "law hertz"]
    assert not any(text.startswith("μ ") for text in told["Walton (1993), chute"])
    assert "Own (2000), chute" not in paper_values(points)


def law_id(folder: Path, edits: dict[str, str]) -> str:
    """Return the id of a point with a law of a folder whose files are edited."""
    own = folder / "grains"
    shutil.rmtree(own, ignore_errors=True)
    own.mkdir()
    law = (ROOT / "docs" / "examples" / "hertz_mindlin.py").read_text()
    texts = {
        "__init__.py": "import talus\n\nfrom . import laws\n\ntalus.paper(__name__)\n",
        "laws.py": f"from .numbers import ONE\n{law}",
        "numbers.py": "ONE = 1\n",
        "judges.py": "def judge(evidence):\n    return []\n",
        "paper.yaml": "name: grains\nauthor: A\nquote: A (2000)\nsystem: chute\n",
    }
    texts |= {name: text for name, text in edits.items() if name[0] != "+"}
    for name, text in texts.items():
        (own / name).write_text(text + edits.get(f"+{name}", ""))
    with without_plugins():
        load_plugins(own)
        return point_id(parse_point({"system": "chute", "law": "hertz_mindlin"}, "p"))


@pytest.mark.parametrize(
    ("edit", "makes_others"),
    [
        ({"+judges.py": "# edited\n"}, False),
        ({"+paper.yaml": "headline: []\n"}, False),
        ({"claims.yaml": "claims: []\n"}, False),
        ({"+__init__.py": "# edited\n"}, False),
        ({"+laws.py": "# edited\n"}, True),
        ({"+numbers.py": "# edited\n"}, True),
    ],
)
def test_a_law_in_the_folder_of_a_paper_has_a_hash_of_its_own(folder, edit, makes_others):
    assert (law_id(folder, {}) != law_id(folder, edit)) is makes_others
    # A law that may read any file is told by all of them.
    reads = {"+laws.py": "PLACE = __file__\n"}
    assert law_id(folder, reads) != law_id(folder, reads | edit)


def test_a_law_that_is_declared_where_all_is_imported_has_the_hash_of_all(folder):
    text = "import talus\n\nfrom . import judges\nfrom .laws import make\n\ntalus.paper(__name__)\n"
    law = (ROOT / "docs" / "examples" / "hertz_mindlin.py").read_text()
    whole = {"__init__.py": f"{text}\n{law}", "laws.py": "def make(p, partners):\n    return 0\n"}
    assert law_id(folder, whole) != law_id(folder, whole | {"+judges.py": "# edited\n"})


def natural(keys: dict, base: dict, **plot):
    """Return a study of two stiffnesses with a plot, in natural units if its keys say so."""
    series = [{"name": "a", "system": "chute", "base": base, "grid": {"stiffness": [1e4, 2e4]}}]
    plots = [{"name": "v", "x": "stiffness", **plot}]
    return parse_study({"study": "s", "series": series, "plots": plots} | keys, "s.yaml", None)


def test_natural_units_are_a_particle_of_one_and_are_shown_but_where_a_plot_names_others(folder):
    load_paper(folder, {"friction": 0.5}, "light", units="natural")
    for keys in ({"units": "natural"}, {"paper": "light"}):
        study = natural(keys, {})
        assert study.units == study.plots["v"].units == "natural"
        for point in study.points.values():
            one = point.parameters
            assert (one.diameter, one.mass, one.gravity, one.time_unit) == (1, 1, 1, 1)
        assert not [text for text in warnings(study, folder) if "if you mean" in text]
        rows = pd.DataFrame([vars(one.parameters) for one in study.points.values()])
        data = SimpleNamespace(rows=rows, spec=study.plots["v"])
        assert parameter_label("chute", "stiffness", units_of_parameters(data)).endswith("σ)")
    assert natural({"units": "natural"}, {}, units="si").plots["v"].units == "si"
    study = natural({"units": "si", "paper": "light"}, {"gravity": 9.8})
    assert study.units == "si" and papers()["light"].values["chute"]["gravity"] == 1
    usual = natural({}, {})
    assert usual.units == usual.plots["v"].units == "si"
    # A plot in natural units of particles in metres has parameters as the study file has them.
    rows = pd.DataFrame([vars(one.parameters) for one in usual.points.values()])
    data = SimpleNamespace(rows=rows, spec=natural({}, {}, units="natural").plots["v"])
    assert units_of_parameters(data) == "si"


def test_a_papers_own_points_stand_in_its_own_figure(folder):
    words = {
        "about": "Fig. 1",
        "title": "V",
        "lead": "V.",
        "named": ["depth"],
        "says": "The paper.",
    }
    beside = [
        {"label": "Fig. 1", "points": [[20, 0.1], [22, 0.2]]},
        {"label": "table", "file": "v.csv", "x": "angle", "y": "v"},
    ]
    figure = words | {"name": "theirs", "x": "angle", "curves": "depth", "beside": beside}
    table = "angle [degree],v [m/s]\n21,0.3\n"
    figures = {"figures.yaml": json.dumps({"figures": [figure]}), "v.csv": table}
    load_paper(folder, {"friction": 0.5}, "seen", files=figures)
    grid = {"angle": [20, 22]}
    series = [{"name": "a", "system": "chute", "grid": grid, "figures": ["theirs"]}]
    study = parse_study({"study": "s", "series": series}, "s.yaml", None)
    found = {label: points for label, points, _ in study.entries["theirs"].foreign}
    assert found == {"Fig. 1": ((20, 0.1), (22, 0.2)), "table": ((21, 0.3),)}
