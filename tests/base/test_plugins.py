"""Plug-ins: loaded where a study names them, refused in one line, never where results name one."""

import re
import subprocess
import sys
from collections.abc import Iterator
from contextlib import nullcontext
from pathlib import Path

import numpy as np
import pytest

from sim.base import plugins
from sim.base.additions import additions, codes
from sim.base.errors import InputError
from sim.base.plugins import load
from sim.study.load import load_study
from tests.made.plugins import restore_plugins, without_plugins
from tests.made.processes import ROOT

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


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("x = 1\n", "it adds nothing"),
        ("import sim\n1 / 0\n", "line 2: ZeroDivisionError: division by zero"),
        ("def (:\n", "SyntaxError: "),
        ("raise SystemExit(3)\n", "line 1: SystemExit: 3"),
        ("raise GeneratorExit\n", "line 1: GeneratorExit: "),
        (
            "class E(Exception):\n    def __str__(self):\n        1 / 0\nraise E\n",
            "line 4: E: an error without words",
        ),
        (
            "class E(Exception):\n    def __str__(self):\n        raise SystemExit\nraise E\n",
            "line 4: E: an error without words",
        ),
        (
            "import sim\n"
            "sim.judge('j', system='belt', title='a\\x1b', statement='s', criterion='c')(dict)\n",
            "title: got 'a\\x1b'; allowed: one line of text",
        ),
        *(
            (
                "import sim\nsim.motion('m', make=dict, state=dict, parameters={\n"
                f"  '{name}': sim.parameter(0.5, unit='1', description='d')}})\n",
                f"parameter {name}: Talus has one of this name",
            )
            for name in (
                "drift",
                "particles",
                "time_step",
                "option",
                "offered",
                "dict",
                "point",
            )
        ),
        ("import helpers_beside_it\n", "line 1: ModuleNotFoundError: No module named"),
        (RIGHT.replace('"answer"', '"velocity"'), "velocity: Talus has one of this name"),
        (RIGHT.replace('"answer"', '"angle"'), "angle: Talus has one of this name"),
        (RIGHT.replace('"answer"', '"Answer 1"'), "a name has up to 40 letters"),
        (RIGHT.replace('"chute"', '"drum"'), "system: got ('drum',); allowed: one of chute, belt"),
        (RIGHT.replace('"1"', '""'), "unit: got ''; allowed: 1 for a pure number"),
        (RIGHT + RIGHT, "observable answer: plug-in mine.py"),
        ("import sim\nsim.plot_kind('map', like='map')(print)\n", "map: Talus has one"),
        ("import sim\nsim.plot_kind('x', like='pie')(print)\n", "like is one of curves"),
        (
            "import sim\nsim.judge('j', system='belt', title='', statement='s', criterion='c')"
            "(dict)\n",
            "judge j: title: got ''; allowed: text, not empty",
        ),
    ],
)
def test_what_is_wrong_with_a_plugin_is_one_line_and_nothing_of_it_stays(tmp_path, text, why):
    with pytest.raises(InputError) as caught:
        load_study(write_study(tmp_path, text), None)
    message = str(caught.value)
    assert message.startswith(f"{tmp_path}/s.yaml: plugins[0]: got 'mine.py'; allowed: a Python")
    assert why in message and "\n" not in message
    assert not additions("observable") and not plugins.places()


JUDGE = "judge('j', system='belt', title='t', statement='s', criterion='c')"
MOTION = "motion('m', make=dict, state=dict, "
LAW = "law('l', make=dict, force=dict, energy=dict, collision_time=dict, "


@pytest.mark.parametrize(
    ("call", "why"),
    [
        (JUDGE.replace("'j'", "2"), "judge 2: a name has up to 40 letters"),
        (JUDGE.replace("'belt'", "{}"), "judge j: system is one of chute, belt, conveyor: got {}"),
        (JUDGE.replace("'c'", "3") + "(dict)", "j: criterion: got 3; allowed: one line"),
        (f"{JUDGE}(1)", "judge j is a function: got 1"),
        (f"{JUDGE[:-1]}, colour=1)(dict)", "judge j: colour: unknown key, got 1"),
        (
            f"{JUDGE[:-1]}, bounds={{'a': 1}})(lambda e: [])",
            "judge j takes 1 argument, a: got '(e)'",
        ),
        (
            JUDGE.replace("'c'", "'{b}', bounds={'a': 1}") + "(dict)",
            "judge j: bounds: got {'a': 1}; allowed: one that fits each brace of '{b}'",
        ),
        ("motion(2, make=dict, state=dict)", "motion 2: a name has up to 40 letters"),
        ("motion('m', make=1, state=dict)", "make: got 1; allowed: a function of 1 arg"),
        (MOTION + "parameters={'a': 5})", "parameters.a: got 5; allowed: what talus.p"),
        (MOTION + "parameters=['a'])", "parameters: got ['a']; allowed: a mapping of names"),
        (
            "law('l', make=dict, force=dict, energy=None, collision_time=dict)",
            "law l: energy: got nothing; allowed: a function",
        ),
        *(
            (
                f"{LAW}remembers={wrong})",
                f"law l: remembers: got {wrong.lower()}; allowed: an integer in [0, 32]",
            )
            for wrong in ("-1", "33", "1.5", "2.0", "True")
        ),
        (MOTION.replace("state=dict", "state=lambda a: a") + ")", "got <lambda>(a); allowed: a"),
        (
            "law('l', make=lambda p: p, force=dict, energy=dict, collision_time=dict)",
            "law l: make: got <lambda>(p); allowed: a function of 2 arguments",
        ),
        (
            "observable('o', system='belt', unit='1', meaning='m')(lambda: 0)",
            "observable o takes 1 argument: got '()'",
        ),
        ("parameter('a', unit='1', description='d')", "default: got 'a'; allowed: a number"),
        ("parameter(1, unit='1', description='d', gt='0')", "gt: got '0'; allowed: a number,"),
        ("parameter(1e999, unit='1', description='d')", "default: got inf; allowed: finite"),
        ("parameter(3, unit='1', description='d', le=2)", "default: got 3; allowed: a number in"),
        ("parameter(1, unit=1, description='d')", "unit: got 1; allowed: 1 for"),
        ("parameter(1, unit='m\\x1b[2J', description='d')", "unit: got 'm\\x1b[2J'; allowed: 1"),
        ("parameter(1, unit='1', description='a\\u202eb')", "description: got 'a\\u202eb'; al"),
        (
            "parameter(1, unit='1', description='d', symbol='\\n')",
            "symbol: got '\\n'; allowed: one",
        ),
        ("parameter(1, unit='bananas', description='d')", "powers as kg m s-2, of m, g, s, A, K"),
        ("observable('o', system='belt', unit='furlong', meaning='m')", "unit: got 'furlong'; al"),
        *(
            (
                f"{LAW}max_overlap={wrong})",
                f"max_overlap: got {wrong.replace('None', 'nothing')}; allowed: a number > 0",
            )
            for wrong in ("'x'", "None", "0", "-1")
        ),
        (LAW + "max_overlap=float('nan'))", "law l: max_overlap: got nan; allowed: a number > 0"),
        (LAW + "one_mass='no')", "law l: one_mass: got 'no'; allowed: true or false"),
        (LAW + "owns='friction')", "law l: owns: got 'friction'; allowed: a tuple of names"),
        (LAW + "description=3)", "law l: description: got 3; allowed: one line of text"),
        (
            LAW.replace("force=dict, energy=dict", "force=None, energy=None") + ")",
            "got nothing; al",
        ),
        ("motion('m', make=dict, state=None)", "motion m: state: got nothing; allowed: a function"),
        (MOTION + "owns=[1])", "motion m: owns: got [1]; allowed: a tuple of names"),
        (MOTION + "description='a\\x1bb')", "description: got 'a\\x1bb'; allowed: one"),
        *(
            (f"plot_kind('p', keys=sim.study.plot_kinds.Keys({keys}))", f"plot p: keys.{why}")
            for keys, why in (
                ("axes=('z',)", "axes[0]: got 'z'; allowed: 'x' or 'y'"),
                ("axes=('x', 'x')", "axes: got ('x', 'x'); allowed: each key once"),
                ("axes=('x',), observable='x'", "axes: got ('x',); allowed: each key once, and"),
                ("observable='y', second='y'", "second: got 'y'; allowed: another key than"),
                ("log=('colour',)", "log: got ('colour',); allowed: colour only where"),
                ("log=('height',)", "log[0]: got 'height'; allowed: 'x', 'y' or 'colour'"),
                ("others=('size',)", "others[0]: got 'size'; allowed: 'curves', 'colour'"),
                ("others=('beside',)", "others: got ('beside',); allowed: curves, panels, between"),
                ("systems=('drum',)", "systems: got 'drum'; allowed: one of chute, belt"),
                ("what='{} {}'", "what: got '{} {}'; allowed: one line of text, with {}"),
                ("over='{height}'", "over: got '{height}'; allowed: one line of text, with {}"),
                ("shows=print", "shows: got nothing; allowed: a function: system"),
                ("shows=lambda system: {'a': 1}", "shows: got {'a': 1}; allowed: a function"),
                ("particles=7", "particles: got 7; allowed: 0, 1 or 2"),
                ("usual=3", "usual: got 3; allowed: a valid string"),
            )
        ),
        ("observable('o', system=[], unit='1', meaning='m')", "system: got (); allowed: one"),
        ("observable('o', system='belt', unit=1, meaning='m')", "unit: got 1; allowed: 1 for"),
        ("observable('o', system='belt', unit='1', meaning='m')(2)", "o is a function: got 2"),
        ("plot_kind('p', like={})", "plot p: like is one of curves, "),
        ("plot_kind('p', keys='x')", "plot p: keys is of type Keys, without like: got 'x'"),
        ("plot_kind('p', like='map', notes='n')", "plot p: notes is a function: got 'n'"),
        ("plot_kind('p', like='map')(None)", "plot p is a function: got nothing"),
    ],
)
def test_what_is_no_declaration_is_one_line_with_its_place(tmp_path, call, why):
    with pytest.raises(InputError) as caught:
        load_study(write_study(tmp_path, f"import sim.study.plot_kinds\nsim.{call}\n"), None)
    message = str(caught.value)
    assert "; line 2: " in message and why in message and message.isprintable()


@pytest.mark.parametrize("unit", ["1", "m/s", "N m-1", "kg m^2 s**-2", "kPa.s", "degree", "1/s"])
def test_units_are_products_of_powers(tmp_path, unit):
    load_study(write_study(tmp_path, RIGHT.replace('"1"', repr(unit))), None)
    assert additions("observable")["answer"].value.variable.unit == unit


@pytest.mark.parametrize("name", ["../mine.py", "/tmp/mine.py", "a/mine.py", "mine.txt", "-m", ""])
def test_a_plugin_lies_beside_the_study(tmp_path, name):
    path = write_study(tmp_path)
    path.write_text(STUDY.format(f"'{name}'"))
    with pytest.raises(InputError, match=r"plugins\[0\]: got .*; allowed: a Python file beside"):
        load_study(path, None)


def test_a_plugin_that_is_not_there_is_named(tmp_path):
    path = write_study(tmp_path)
    (tmp_path / "mine.py").unlink()
    with pytest.raises(InputError, match=r"got 'mine.py'; .*: No such file"):
        load_study(path, None)
    path.write_text(STUDY.format("nobody_has_this"))
    with pytest.raises(InputError, match=r"got 'nobody_has_this'; .*; installed: none"):
        load_study(path, None)


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


def test_results_that_name_a_study_run_none_of_its_code(tmp_path):
    path = write_study(tmp_path)
    load_study(path, None, plugins=False)
    assert not plugins.places()


def test_a_plugin_changes_neither_folder_nor_arithmetic_of_the_process(tmp_path, monkeypatch):
    lines = "import os, numpy\nos.chdir('/')\nnumpy.seterr(all='raise')\n"
    monkeypatch.chdir(tmp_path)

    before = Path.cwd(), np.geterr()
    for text, loads in ((lines + RIGHT, True), (lines + "1 / 0\n", False)):
        with restore_plugins(), nullcontext() if loads else pytest.raises(InputError):
            load_study(write_study(tmp_path, text), None)
        assert (Path.cwd(), np.geterr()) == before


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
