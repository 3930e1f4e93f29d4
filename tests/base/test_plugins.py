"""Plug-ins: loaded where a study names them, refused in one line, never where results name one."""

import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from sim.base import plugins
from sim.base.additions import additions, codes
from sim.base.errors import InputError
from sim.base.plugins import load
from sim.study.load import load_study
from tests.made.processes import ROOT, restore_plugins, without_plugins

RIGHT = """\
import sim
@sim.observable("answer", system="chute", unit="1", meaning="the answer")
def answer(run):
    return 42
"""
STUDY = "study: s\nplugins: [{}]\nseries: [{{name: a, system: chute}}]\n"


@pytest.fixture(autouse=True)
def _restore() -> Iterator[None]:
    with restore_plugins():
        yield


def write_study(folder: Path, text: str = RIGHT, name: str = "mine.py") -> Path:
    (folder / name).write_text(text)
    path = folder / "s.yaml"
    path.write_text(STUDY.format(name))
    return path


def test_a_study_loads_its_plugins_once_and_says_so(tmp_path, capsys):
    study = load_study(write_study(tmp_path), None)
    again = load_study(tmp_path / "s.yaml", None)
    assert study.plugins == again.plugins and set(additions("observable")) == {"answer"}
    code = study.plugins[0].code
    assert capsys.readouterr().err == f"plug-in {tmp_path}/mine.py ({code}): observable answer\n"
    assert codes("observable") == f"answer.{code}" and codes("plot") == ""
    assert study.sources == (tmp_path / "s.yaml", tmp_path / "mine.py")


def test_parts_bring_their_plugins(tmp_path):
    write_study(tmp_path)
    whole = tmp_path / "whole.yaml"
    whole.write_text("study: w\nparts: [s.yaml]\n")
    assert [plugin.name for plugin in load_study(whole, None).plugins] == ["mine.py"]


@pytest.mark.parametrize("unit", ["1", "m/s", "N m-1", "kg m^2 s**-2", "kPa.s", "degree", "1/s"])
def test_units_are_products_of_powers(tmp_path, unit):
    load_study(write_study(tmp_path, RIGHT.replace('"1"', repr(unit))), None)
    assert additions("observable")["answer"].value.variable.unit == unit


def test_an_edited_plugin_needs_a_new_process(tmp_path):
    path = write_study(tmp_path)
    load_study(path, None)
    write_study(tmp_path, RIGHT.replace("42", "43"))
    with pytest.raises(InputError, match="has one of this name in this process; start another"):
        load_study(path, None)


def test_a_job_takes_no_other_text_than_that_with_which_its_study_was_started(
    tmp_path, monkeypatch
):
    (plugin,) = load_study(write_study(tmp_path), None).plugins
    monkeypatch.setenv(plugins.VARIABLE, plugin.pinned_name)
    with without_plugins():
        plugins.load_from_environment()
        assert set(additions("observable")) == {"answer"}
    write_study(tmp_path, RIGHT.replace("42", "43"))
    with (
        without_plugins(),
        pytest.raises(InputError, match=r"mine.py .*: edited since this study was started"),
    ):
        plugins.load_from_environment()


@pytest.mark.parametrize(
    ("entry", "code", "words"),
    [
        ("not_there", "", "no module not_there"),
        ("talus_odd", "import sys\nsys.exit(3)\n", "SystemExit: 3"),
        ("talus_odd", "raise KeyError('x')\n", "KeyError: 'x'"),
        ("talus_odd:missing.thing", "x = 1\n", "it adds nothing"),
        ("talus_odd", "def (", "SyntaxError"),
        ("sys", "", "built-in"),
        ("a b c:::", "", "a b c"),
    ],
)
def test_entry_points_that_misbehave_are_one_line(entry, code, words, tmp_path, monkeypatch):
    metadata = tmp_path / "talus_odd-1.0.dist-info"
    metadata.mkdir()
    (metadata / "METADATA").write_text("Metadata-Version: 2.1\nName: talus_odd\nVersion: 1.0\n")
    (metadata / "entry_points.txt").write_text(f"[talus.plugins]\nodd = {entry}\n")
    (tmp_path / "talus_odd.py").write_text(code)
    monkeypatch.syspath_prepend(str(tmp_path))
    with restore_plugins(), pytest.raises(InputError, match=re.escape(words)):
        load(["odd"], tmp_path, "study.yaml: plugins")


def test_installed_packages_add_by_their_entry_points(tmp_path, monkeypatch):
    package = tmp_path / "talus_answers"
    package.mkdir()
    (package / "__init__.py").write_text("")
    (package / "own.py").write_text(RIGHT)
    metadata = tmp_path / "talus_answers-1.dist-info"
    metadata.mkdir()
    (metadata / "METADATA").write_text("Metadata-Version: 2.1\nName: talus_answers\nVersion: 1\n")
    (metadata / "entry_points.txt").write_text("[talus.plugins]\nanswers = talus_answers.own\n")
    monkeypatch.syspath_prepend(tmp_path)
    (plugin,) = load(["answers"], Path(), "here")
    assert plugin.place == "answers" and not plugin.files
    assert set(additions("observable")) == {"answer"}
    # All of the package counts.
    (package / "__init__.py").write_text("x = 1\n")
    with pytest.raises(InputError, match="start another"):
        load(["answers"], Path(), "here")


def test_commands_load_what_the_environment_names(tmp_path):
    write_study(tmp_path)
    command = [sys.executable, "-m", "sim", "schema"]
    for place, code, text in (("mine.py", 0, "plug-in"), ("none.py", 2, "error: TALUS_PLUGINS[0]")):
        environment = {plugins.VARIABLE: str(tmp_path / place), "PATH": "/bin"}
        done = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True)
        assert done.returncode == code and done.stderr.startswith(text)


def test_a_plugin_that_is_imported_adds_nothing(tmp_path, monkeypatch):
    (tmp_path / "mine_alone.py").write_text(RIGHT)
    monkeypatch.syspath_prepend(tmp_path)
    import mine_alone  # type: ignore[import-not-found]

    assert mine_alone.answer(None) == 42 and not additions("observable")


def test_a_wrong_call_of_a_module_that_ships_is_one_line(monkeypatch):
    def broken(_):
        raise TypeError("law() missing 1 required keyword-only argument: 'collision_time'")

    monkeypatch.setattr(plugins, "import_module", broken)
    with pytest.raises(InputError, match=r"laws/drag\.py: TypeError: law\(\) missing 1"):
        plugins.load_shipped("sim.laws")
