"""The site: what it shows is made of the code and complete, and it builds without a warning."""

import re
import subprocess
import sys

import pytest
import xarray as xr
import yaml

import sim
from docs.site.pages import commands, licences, variables
from sim.base.command_line import COMMANDS, JOBS
from sim.parameters import SYSTEMS, field_info
from tests.made.figures import make_built_study
from tests.made.processes import ROOT

PAGES = {path.relative_to(ROOT / "docs").as_posix() for path in (ROOT / "docs").rglob("*.md")}


class Loader(yaml.SafeLoader):
    """Reads what concerns us of mkdocs.yml; what names Python objects is left out."""


Loader.add_multi_constructor("tag:yaml.org,2002:python/", lambda loader, suffix, node: None)


@pytest.fixture(scope="module")
def settings() -> dict:
    return yaml.load((ROOT / "mkdocs.yml").read_text(encoding="utf-8"), Loader)


def test_every_page_has_its_place(settings):
    named = {page for one in settings["nav"] for held in one.values() for page in listed(held)}
    made = {f"reference/{name}.md" for name in ("commands", "licences", "studies", "variables")}
    made |= {f"{name}.md" for name in ("changelog", "contributing", "index", "verdicts", "verify")}
    assert named == PAGES | made


def listed(held: str | list) -> list[str]:
    return [held] if isinstance(held, str) else [page for one in held for page in one.values()]


def test_all_commands_are_told_with_their_options():
    text = commands()
    names = [*COMMANDS, *(f"job {name}" for name in JOBS)]
    assert re.findall(r"^## ([\w -]+)$", text, re.MULTILINE) == names
    assert "Usage: talus export" in text and "--replicate N" in text


def test_every_package_that_studies_need_has_its_licence():
    rows = re.findall(r"^\| (\S+) \| (\S+) \| (\S.*) \|$", licences(), re.MULTILINE)[2:]
    pins = (ROOT / "requirements.lock").read_text().split()
    assert [f"{name}=={version}" for name, version, _ in rows] == pins
    assert not [name for name, _, licence in rows if licence == "not stated"]


@pytest.fixture(scope="module")
def told() -> set[str]:
    return set(re.findall(r"`(\w+)`", variables()))


@pytest.mark.parametrize("given", [{"system": "belt", "beads": 10, "width": 5}, {"depth": 1.5}])
def test_all_variables_of_a_run_are_told(given, told):
    run = sim.simulate(**given, transient=1, average=2, trajectory=1, progress=False)
    held = {name.removesuffix("_instantaneous") for name in map(str, run.variables)}
    assert held - set(field_info(SYSTEMS[run.attrs["system"]])) <= told


def test_all_variables_of_a_dataset_are_told(tmp_path, told):
    _, results = make_built_study(tmp_path)
    with xr.open_dataset(results / "made" / "dataset.nc") as dataset:
        held = set(map(str, dataset.variables))
    assert held - {name for model in SYSTEMS.values() for name in field_info(model)} <= told


def test_all_that_python_offers_is_told():
    text = (ROOT / "docs" / "reference" / "api.md").read_text(encoding="utf-8")
    told = {name.rpartition(".")[2] for name in re.findall(r"^::: (.*)$", text, re.MULTILINE)}
    assert set(sim.__all__) - {"__version__"} <= told


def test_the_site_builds_without_a_warning_and_needs_nothing_else(tmp_path):
    pytest.importorskip("mkdocs")
    build = [sys.executable, "-m", "mkdocs", "build", "--strict", "--quiet", "--site-dir", tmp_path]
    done = subprocess.run(build, cwd=ROOT, capture_output=True, text=True)
    assert (done.returncode, done.stdout + done.stderr) == (0, "")
    for page in tmp_path.rglob("*.html"):
        if "results" not in page.parts:
            text = page.read_text(encoding="utf-8")
            loaded = re.findall(r'<(?:script|link|img)\b[^>]*?(?:src|href)="([^"]*)"', text)
            assert not [one for one in loaded if one.startswith(("http:", "https:", "//"))]
    for paper in ("paper_walton", "paper_gallas"):
        report = tmp_path / "results" / "published" / paper / "report.html"
        shown = re.findall(r'(?:href|src)="(figures/[^"]*)"', report.read_text(encoding="utf-8"))
        assert shown and not [one for one in shown if not (report.parent / one).is_file()]
