"""Functions of plug-ins in place of runs: points, run files, growth, answers, mistakes."""

import re
import shutil
from pathlib import Path

import numpy as np
import pytest

import sim as talus
from sim.base.errors import InputError
from sim.base.plugins import load_plugins
from sim.dataset.build import build
from sim.dataset.results import load_results
from sim.engine.command import variants
from sim.engine.run import run_point
from sim.figures.render import render
from sim.parameters import parse_point, point_id
from sim.report.runs import describe_run
from sim.study.load import load_study
from sim.study.plan import MAX_BATCH_POINTS, plan_batches
from sim.surrogates import inquiries
from sim.surrogates.sample import sample_points
from tests.made.processes import ROOT, restore_plugins, without_plugins
from tests.surrogates.predictors import ISHIGAMI_FIRST, ISHIGAMI_TOTAL

EXAMPLE = ROOT / "docs" / "examples" / "ishigami.py"
OTHERS = ROOT / "tests" / "data" / "functions.py"
OVER = ", ".join(f"{name}: [-3.14159, 3.14159]" for name in ("first", "second", "third"))
STUDY = f"""\
study: known
plugins: [ishigami.py]
series:
  - name: runs
    system: function
    base: {{function: ishigami}}
    design: {{kind: saltelli, points: 40, over: {{{OVER}}}}}
sensitivity: [{{name: matters, series: runs, observable: sum_of_sines}}]
plots: [{{name: seen, kind: scatter, x: first, y: sum_of_sines, colour: second}}]
"""


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    for path in (EXAMPLE, OTHERS):
        shutil.copy(path, tmp_path)
    (tmp_path / "study.yaml").write_text(STUDY)
    monkeypatch.chdir(tmp_path)
    with restore_plugins():
        yield tmp_path


def run(file: str = "study.yaml") -> Path:
    """Run a study as its workflow does, in this process; return the folder of its results."""
    study = load_study(file)
    results = Path("results", study.name)
    (results / "runs").mkdir(parents=True, exist_ok=True)
    for key, point in study.points.items():
        assert run_point(point.parameters, results / "runs" / f"{key}.nc", quiet=True) == 0
    build(file)
    return results


def point(**values):
    return parse_point({"system": "function"} | values, "made")


def test_a_study_of_a_known_function_finds_its_indices():
    results = run()
    (line,) = inquiries.build("study.yaml")
    assert line.startswith("sensitivity matters: total index of ") and "noise" not in line
    found = talus.load(results)
    table = found.table("matters").set_index(["index", "parameter"])
    for index, true in (("first", ISHIGAMI_FIRST), ("total", ISHIGAMI_TOTAL)):
        low, high = table.loc[index][["low", "high"]].to_numpy().T
        assert ((low <= true) & (true <= high)).sum() >= 2
    assert set(found.dataset["point_regime"].values) == {"steady"}
    assert "sum_of_sines" in repr(found) and "40 points, 40 runs" in repr(found)
    picture, _, data, caption = render(
        load_study("study.yaml").plots["seen"], results / "dataset.nc", Path()
    )
    assert picture.exists() and "Points: steady 40." in caption.read_text()
    assert "a function" not in data.read_text() and len(data.read_text().splitlines()) == 41
    with without_plugins():
        # The results are read without the plug-in, too.
        assert talus.load(results).dataset.sizes["point"] == 40


def test_a_point_is_a_call(capsys):
    load_plugins("ishigami.py")
    found = talus.simulate("function", function="ishigami", first=0.5, second=1.0, progress=False)
    value = np.sin(0.5) + 7 * np.sin(1.0) ** 2
    assert found["sum_of_sines"].item() == pytest.approx(value, rel=1e-12)
    assert found["sum_of_sines"].units == "1" and found.attrs["status"] == "completed"
    one = point(function="ishigami", first=0.5)
    assert point_id(one).startswith("function-function-ishigami.") and not variants([one])
    assert run_point(one, Path("one.nc"), quiet=True) == 0
    text = describe_run(Path("one.nc"), False)
    assert re.search(r"sum_of_sines +0.479426", text) and "velocity" not in text
    with without_plugins(), pytest.raises(InputError, match="or that of a plug-in that TALUS_PL"):
        describe_run(Path("one.nc"), False)


def test_chance_differs_between_points_and_replicates_and_runs_grow():
    load_plugins("functions.py")
    two, four = (point(function="noisy", x=2, replicates=number) for number in (2, 4))
    path = Path(f"{point_id(two)}.nc")
    far = []
    for one in (two, four, two):
        assert run_point(one, path, quiet=True) == 0
        far.append(np.array(talus.simulate("function", **values_of(one))["far"]))
    assert (far[0] == far[1][:2]).all() and len(set(far[1])) == 4
    other = talus.simulate("function", function="noisy", x=3, progress=False)["far"].item() - 3
    assert abs(other - (far[0][0] - 2)) > 1e-6
    assert list(Path().glob(".*.state")) == []


def values_of(one):
    return {"function": "noisy", "x": one.x, "replicates": one.replicates, "progress": False}


def test_several_numbers_are_returned_by_name_and_one_may_be_missing():
    load_plugins("functions.py")
    near, far = (
        talus.simulate("function", function="beam", x=x, progress=False) for x in (2.0, 4.0)
    )
    assert (near["a"].item(), near["b"].item()) == (4.0, 0.5)
    assert far["a"].item() == 8.0 and np.isnan(far["b"].item())


def test_exact_values_have_no_scatter_and_random_ones_may():
    text = STUDY.partition("sensitivity")[0].replace("saltelli, points: 40", "sobol, points: 16")
    for name, function, observable, scatter in (
        ("exact", "ishigami", "sum_of_sines", 0),
        ("random", "noisy", "far", 1),
    ):
        text = text.replace("ishigami.py", "ishigami.py, functions.py")
        one = text.replace("study: known", f"study: {name}")
        if function == "noisy":
            one = one.replace("function: ishigami", "function: noisy")
            one = one.partition("over:")[0] + "over: {x: [0, 9]}}\n"
        one += f"surrogate: [{{name: s, series: runs, observable: {observable}}}]\n"
        Path(f"{name}.yaml").write_text(one)
        with restore_plugins():
            found = load_results(run(f"{name}.yaml") / "dataset.nc")
            (spec,) = load_study(f"{name}.yaml").surrogates
            assert sample_points(found, spec).attrs["scatter"] == scatter


def test_points_share_processes_by_what_a_call_takes():
    load_plugins("functions.py")
    points = {point_id(one): one for x in range(400) for one in [point(function="beam", x=x / 50)]}
    batches = plan_batches(points, 2)
    assert sum(map(len, batches.values())) == 400
    assert max(map(len, batches.values())) == MAX_BATCH_POINTS


def test_functions_share_a_parameter_that_they_declare_alike():
    load_plugins("functions.py")
    other = OTHERS.read_text().replace("noisy", "other").replace("beam", "bend")
    for name in ("far", "a", "b"):
        other = other.replace(f'"{name}"', f'"{name}_of_other"')
    Path("alike.py").write_text(other)
    load_plugins("alike.py")
    Path("else.py").write_text(other.replace("le=9", "le=8").replace("other", "third"))
    with pytest.raises(InputError, match=r"parameter x: function .* has it"):
        load_plugins("else.py")


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("return 1 / 0", "line 15: ZeroDivisionError: "),
        ("return 1.0", "it returns a mapping of a, b to numbers"),
        ("return {'c': 1.0}", "it returns c, which it does not declare"),
        ("return {'a': 'much'}", "ValueError: could not convert"),
    ],
)
def test_an_error_in_a_function_names_it(line, message):
    text = OTHERS.read_text().replace("return {", f"{line}\n    return {{")
    Path("wrong.py").write_text(text)
    load_plugins("wrong.py")
    with pytest.raises(InputError, match=f"plug-in wrong.py .*: function beam: .*{message}"):
        talus.simulate("function", function="beam", progress=False)


def test_a_function_is_no_flow():
    load_plugins("functions.py")
    with pytest.raises(InputError, match="Flow: system: got 'function'; allowed: one of chute"):
        talus.Flow("function", function="beam")
