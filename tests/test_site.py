"""The site: what it shows is made of the code and complete, and it builds without a warning."""

import re
import subprocess
import sys
from pathlib import Path

import pytest
import yaml

import sim
from docs.site.pages import commands, variables
from sim.__main__ import COMMANDS
from sim.parameters import field_info
from tests.engine_motion.points import chute_point
from tests.made.processes import ROOT
from tests.made.runs import write_run

PAGES = {path.relative_to(ROOT / "docs").as_posix() for path in (ROOT / "docs").rglob("*.md")}


class Loader(yaml.SafeLoader):
    """Reads what concerns us of mkdocs.yml; what names Python objects is left out."""


Loader.add_multi_constructor("tag:yaml.org,2002:python/", lambda loader, suffix, node: None)


@pytest.fixture(scope="module")
def settings() -> dict:
    return yaml.load((ROOT / "mkdocs.yml").read_text(encoding="utf-8"), Loader)


def test_every_page_has_its_place(settings):
    named = {page for one in settings["nav"] for held in one.values() for page in listed(held)}
    made = {f"reference/{name}.md" for name in ("commands", "studies", "variables")}
    assert named == PAGES | made | {"index.md", "changelog.md", "contributing.md"}


def listed(held: str | list) -> list[str]:
    return [held] if isinstance(held, str) else [page for one in held for page in one.values()]


def test_all_commands_are_told_with_their_options():
    text = commands()
    assert re.findall(r"^## (\w+)$", text, re.MULTILINE) == list(COMMANDS)
    assert "usage: talus export" in text and "--replicate N" in text


def test_all_variables_of_a_run_are_told(tmp_path):
    netcdf = pytest.importorskip("netCDF4")
    told = set(re.findall(r"`(\w+)`", variables()))
    point = chute_point()
    with netcdf.Dataset(write_run(tmp_path, point)) as file:
        held = {name.removesuffix("_instantaneous") for name in file.variables}
    assert held - set(field_info(point)) <= told | {"particles", "time_step"} | set(point.limits)


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
            loaded = re.findall(r'<(?:script|link|img)\b[^>]*?(?:src|href)="([^"]*)"', text_of(page))
            assert not [one for one in loaded if one.startswith(("http:", "https:", "//"))]


def text_of(page: Path) -> str:
    return page.read_text(encoding="utf-8")
