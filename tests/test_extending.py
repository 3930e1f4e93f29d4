"""The examples of docs/extending.md: from made-up runs to dataset, figures, verdicts, report."""

import importlib
import json
import re
import shutil
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import sim
from sim.base.additions import shipped
from sim.base.errors import InputError
from sim.base.plugins import load_plugins, places
from sim.claims import judge
from sim.claims.evidence import readings_of
from sim.claims.verdict_files import build as build_claims
from sim.dataset.build import build
from sim.dataset.rows import reader_hash
from sim.engine.contact import Partners, law_of
from sim.engine.identity import cache_directory
from sim.engine.systems.start import vibration
from sim.figures.render import draw_figures
from sim.parameters import ChuteParameters, Parameters, parse_point, point_id
from sim.parameters.choices import extended, parameter
from sim.parameters.laws import LAW
from sim.report.compare import show
from sim.report.page import build as build_report
from sim.report.publish import publish
from sim.study.load import Study, load_study, parse_study
from sim.study.papers import paper_values
from tests.made.processes import ROOT, plugin_claims, restore_plugins, run_lines, without_plugins
from tests.made.runs import write_run

EXAMPLES = ROOT / "docs" / "examples"
FILES = sorted(EXAMPLES.rglob("*.py"))
GUIDE = (ROOT / "docs" / "extending.md").read_text(encoding="utf-8")
BLOCKS = {
    kind: re.findall(rf"^```{kind}\n(.*?)^```", GUIDE, flags=re.MULTILINE | re.DOTALL)
    for kind in ("python", "yaml")
}


@pytest.fixture(autouse=True)
def _forget() -> Iterator[None]:
    with restore_plugins():
        yield


@pytest.fixture(autouse=True)
def _no_claims_of_papers(monkeypatch) -> None:
    monkeypatch.setattr(judge, "claims", plugin_claims)


@pytest.fixture
def folder(tmp_path, monkeypatch) -> Path:
    """Return a folder with the examples, in which everything happens."""
    ignored = shutil.ignore_patterns("__pycache__")
    shutil.copytree(EXAMPLES, tmp_path, ignore=ignored, dirs_exist_ok=True)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def make_runs(study: Study) -> None:
    for point in study.points.values():
        parameters: Parameters = point.parameters
        speed = 0.4 * np.array([0.99, 1.0, 1.01]) * (1.3 if parameters.angle == 18 else 1.0)
        packing = np.where(np.arange(8) < 3, 0.5, 0.0) * np.ones((3, 1))
        held = {"packing_profile": (("replicate", "height"), packing, {"units": "1"})}
        write_run(Path("results/own/runs"), parameters, speed, arrays=held)


@pytest.fixture
def made(folder) -> Path:
    """Return the results of the study of the examples, all but figures and report."""
    make_runs(load_study("own.yaml"))
    build("own.yaml")
    build_claims("own.yaml")
    return folder / "results" / "own"


def test_the_examples_go_the_whole_way(made, folder):
    with xr.open_dataset(made / "dataset.nc") as dataset:
        slip = dataset["base_slip"]
        assert slip.attrs["units"] == "1" and slip.attrs["long_name"].startswith("velocity of the")
        # The lowest slice is the only one below a diameter, and half as fast as the mean.
        assert np.allclose(slip, 0.5)
    draw_figures(
        ["slip", "spread"],
        made / "dataset.nc",
        made / "figures",
        code="x",
        study_path=Path("own.yaml"),
    )
    assert "Boxes: quartiles" in (made / "figures" / "spread.caption.txt").read_text()
    table = (made / "figures" / "slip.csv").read_text()
    assert "velocity of the lowest diameter over the mean velocity [1]" in table
    (own,) = (
        c for c in json.loads((made / "claims.json").read_text())["claims"] if c["paper"] == "own"
    )
    assert own["id"] == "steeper_is_faster" and own["verdict"] == "reproduced"
    page = build_report("own.yaml").read_text()
    claims = page[page.index('id="own-claims"') :].partition("</section>")[0]
    assert "Fixed length" in claims and "onverged" not in claims
    assert "What this study claims" in page and "Steeper flows are faster" in page
    assert "base_slip.py" in page and "Plug-ins" in page
    published = publish("own.yaml", target=folder / "published")
    assert (published / "steeper.py").is_file()


def test_an_edited_observable_is_computed_again_and_nothing_else_is_old(made, folder):
    before = reader_hash()
    with restore_plugins():
        edited = (folder / "base_slip.py").read_text().replace("/ run[", "/ 2 / run[")
        (folder / "base_slip.py").write_text(edited)
        # As another process would find it.
        with without_plugins():
            build("own.yaml")
            assert reader_hash() != before
    with xr.open_dataset(made / "dataset.nc") as dataset:
        assert np.allclose(dataset["base_slip"], 0.25)


def test_a_mistake_in_a_plugin_is_one_line_and_harms_no_run_file(folder):
    wrong = (folder / "base_slip.py").read_text().replace('run["height"]', 'run["hight"]')
    (folder / "base_slip.py").write_text(wrong)
    make_runs(load_study("own.yaml"))
    with pytest.raises(InputError, match=r"observable base_slip of chute.*: line 15: KeyError"):
        build("own.yaml")
    assert not list(Path("results/own/runs").glob("*.damaged"))


@pytest.mark.parametrize(
    ("line", "why"),
    [
        ('height = run["height"]; height /= 2', "ValueError: output array is read-only"),
        ("raise SystemExit(0)", "SystemExit: 0"),
    ],
)
def test_an_observable_changes_nothing_that_others_read_and_ends_nothing(folder, line, why):
    text = (folder / "base_slip.py").read_text()
    (folder / "base_slip.py").write_text(
        text.replace("def base_slip(run):", f"def base_slip(run):\n    {line}")
    )
    make_runs(load_study("own.yaml"))
    with pytest.raises(InputError, match=rf"observable base_slip of chute.*: line 15: {why}"):
        build("own.yaml")


@pytest.mark.parametrize(
    ("right", "wrong", "why"),
    [
        ("* law.modulus * edge * overlap", "* law.moduls", "cannot be compiled: .*moduls"),
        ("remembers=1", "remembers=2", "2 as remembers says, is no tuple of 2 floats: got"),
    ],
)
def test_what_cannot_be_compiled_is_told_with_its_line(folder, right, wrong, why):
    """With one contact in place of a run, whose loops would take a minute to get that far."""
    path = folder / "hertz_mindlin.py"
    path.write_text(path.read_text().replace(right, wrong, 1))
    lines = (
        "import sys, numpy as np\n"
        "from sim.__main__ import main\n"
        "from sim.engine import command\n"
        "def one_contact(**options):\n"
        "    from sim.claims.experiments import contact_path\n"
        "    from sim.engine.contact import Partners, law_of\n"
        "    from sim.engine.contact.functions import PartnerLaw\n"
        "    from sim.parameters import parse_point\n"
        "    p = parse_point({'system': 'chute', 'law': 'hertz_mindlin'}, 'p')\n"
        "    law = PartnerLaw(law_of(p, Partners(0.4, 1e-6, 1e-5)), 5e-4, 1e-6)\n"
        "    contact_path(law, np.ones(1), np.ones((1, 3)), np.ones((1, 3)))\n"
        "command.run = one_contact\n"
        "sys.exit(main(['run', 'p.yaml', '-o', 'r.nc']))\n"
    )
    done = run_lines(folder, lines, TALUS_PLUGINS="hertz_mindlin.py")
    said = rf"^error: plug-in hertz_mindlin.py .*: line \d+: .*{why}"
    assert done.returncode == 2 and re.search(said, done.stderr, re.MULTILINE), done.stderr
    assert "Traceback" not in done.stderr


def test_a_figure_is_old_when_its_plugin_is_edited(folder):
    spec = load_study("own.yaml").plots
    (folder / "boxes.py").write_text((folder / "boxes.py").read_text() + "# edited\n")
    with without_plugins():
        other = load_study("own.yaml").plots
    assert repr(spec["slip"]) == repr(other["slip"])
    assert repr(spec["spread"]) != repr(other["spread"])


def test_the_guide_shows_the_examples_and_its_other_snippets_work(folder, monkeypatch):
    texts = [path.read_text() for path in FILES if f"(examples/{path.name})" not in GUIDE]
    assert set(texts) <= set(BLOCKS["python"])
    monkeypatch.syspath_prepend(folder)
    for block in BLOCKS["python"]:
        if block not in texts:
            exec(block, {})
    studies = [block for block in BLOCKS["yaml"] if "series:" in block]
    for number, block in enumerate(studies):
        (folder / f"{number}.yaml").write_text(block)
        study = load_study(f"{number}.yaml")
        assert study.plots
    assert studies


def test_points_tell_the_law_and_its_code(folder):
    def ids() -> set[str]:
        study = {"study": "s", "plugins": ["hertz_mindlin.py"]}
        chute = {"name": "a", "system": "chute", "grid": {"law": ["walton_braun", "hertz_mindlin"]}}
        return set(parse_study(study | {"series": [chute]}, "s.yaml").points)

    with without_plugins():
        first = ids()
    usual = point_id(ChuteParameters())
    assert usual in first
    (own,) = first - {usual}
    assert re.search(r"-law-hertz_mindlin\.[0-9a-f]{8}-", own)
    (folder / "hertz_mindlin.py").write_text((folder / "hertz_mindlin.py").read_text() + "#\n")
    with without_plugins():
        assert first & ids() == {usual}


def test_a_law_whose_collision_takes_no_time_is_told_with_its_line(folder):
    path = folder / "hertz_mindlin.py"
    path.write_text(path.read_text().replace("return 2.87 *", "return 0 *"))
    load_plugins("hertz_mindlin.py")
    with pytest.raises(InputError, match=r"law hertz_mindlin: ValueError: a collision takes 0.0 s"):
        parse_point({"system": "chute", "law": "hertz_mindlin"}, "point")


def test_what_a_law_ignores_is_not_left_as_in_a_paper_and_one_mass_is_one(folder):
    path = folder / "hertz_mindlin.py"
    more = "remembers=1,\n    ignores=('restitution',),\n    one_mass=True,"
    path.write_text(path.read_text().replace("remembers=1,", more))
    load_plugins("hertz_mindlin.py")
    texts = [
        paper_values([parse_point({"system": "chute", "law": law}, "p")])["Walton (1993), chute"]
        for law in ("walton_braun", "hertz_mindlin", "drag")
    ]
    assert ["e = 0.85" in one for one in texts] == [True, False, True]
    assert ["μ = 0.4" in one for one in texts] == [True, True, False]
    for name in ("bumps", "diameter_spread"):
        with pytest.raises(
            InputError, match=rf"{name}: got 0.1; allowed: 0 with law: hertz_mindlin$"
        ):
            parse_point({"system": "chute", "law": "hertz_mindlin", name: 0.1}, "p")


def test_a_law_that_ships_may_add_parameters(monkeypatch):
    stick = parameter(0.5, unit="1", description="a share", ge=0)
    law = shipped("law")["drag"].model_copy(update={"parameters": {"stick": stick}})
    monkeypatch.setitem(shipped("law"), "drag", law)
    chute = extended(ChuteParameters, LAW)
    assert chute(law="drag", stick=0.7).stick == 0.7 and chute().stick == 0.5
    with pytest.raises(ValueError, match="unless law is drag, whose it is"):
        chute(stick=0.7)


@pytest.mark.parametrize(
    ("text", "got"),
    [("{'a': 1}", "{'a': 1}"), ("(1.0, 2.0)", "(1, 2)"), ("HertzMindlin(1.0, '2', 0, 0)", "")],
)
def test_a_law_that_makes_no_numbers_is_told(folder, text, got):
    path = folder / "hertz_mindlin.py"
    path.write_text(path.read_text().replace("    nu = p.", f"    return {text}\n    nu = p."))
    load_plugins("hertz_mindlin.py")
    point = parse_point({"system": "chute", "law": "hertz_mindlin"}, "point")
    said = f"law hertz_mindlin: TypeError: make returns a NamedTuple of numbers: got {got}"
    with pytest.raises(InputError, match=re.escape(said)):
        law_of(point, Partners(0.4, 1e-6, 1e-5))


def test_a_motion_that_makes_no_numbers_is_told(folder):
    path = folder / "ellipse.py"
    path.write_text(path.read_text().replace("return Ellipse(", "return str("))
    load_plugins("ellipse.py")
    point = parse_point({"system": "belt", "motion": "ellipse"}, "point")
    with pytest.raises(InputError, match=r"motion ellipse: .*NamedTuple of numbers: got '1\.57"):
        vibration(point, 20.0)


def test_two_plugins_have_no_parameter_in_common(folder):
    text = (folder / "hertz_mindlin.py").read_text()
    (folder / "other.py").write_text(text.replace('    "hertz_mindlin"', '    "other"'))
    load_plugins("hertz_mindlin.py")
    with pytest.raises(InputError, match="parameter grain_modulus: law hertz_mindlin has it"):
        load_plugins("other.py")


def test_a_law_is_no_reading_of_the_paper():
    assert readings_of("chute").control_reason({"law": "hertz_mindlin.00000000"})


def test_an_engine_at_work_takes_no_new_law(folder):
    """Its compiled code would be kept for processes that do not know the law."""
    importlib.import_module("sim.engine.compile")
    load_plugins("hertz_mindlin.py")
    with pytest.raises(InputError, match="before the first flow of a process"):
        sim.Flow(law="hertz_mindlin")


def test_results_of_a_law_that_is_not_there_are_read_but_not_compared(folder):
    with without_plugins():
        study = {"study": "s", "plugins": ["hertz_mindlin.py"]}
        grid = {"grain_modulus": [1e6, 2e6]}
        chute = {"name": "a", "system": "chute", "base": {"law": "hertz_mindlin"}, "grid": grid}
        Path("s.yaml").write_text(json.dumps(study | {"series": [chute]}))
        for point in load_study("s.yaml").points.values():
            write_run(Path("results/s/runs"), point.parameters)
        build("s.yaml")
    found = sim.load("results/s")
    assert not places()
    assert found.dataset["grain_modulus"].values.tolist() == [1e6, 2e6]
    with pytest.raises(InputError, match=r"law: got 'hertz_mindlin.*TALUS_PLUGINS"):
        show(Path("results/s"), Path("results/s"), "velocity", (), "text")


def test_compiled_code_of_a_law_has_a_folder_of_its_own(folder, monkeypatch):
    (folder / "cache").mkdir(mode=0o700)
    monkeypatch.setenv("TALUS_CACHE_DIR", str(folder / "cache"))
    usual = cache_directory()
    load_plugins("boxes.py", "steeper.py")
    assert cache_directory() == usual
    load_plugins("hertz_mindlin.py")
    with_law = cache_directory()
    load_plugins("ellipse.py")
    assert len({usual, with_law, cache_directory()}) == 3
    assert cache_directory(with_plugins=False) == usual
