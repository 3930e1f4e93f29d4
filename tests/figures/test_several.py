"""Several figures in one job: those that are up to date are skipped."""

import pytest

from sim.base.errors import InputError
from sim.figures import render
from sim.figures.pictures import RECORD_FILE
from sim.figures.render import draw_figures
from sim.study.figure_spec import FIGURES

NAMES = ("gallas_2b", "gallas_6")


def write_files(spec, dataset_path, folder):
    """Write a figure's files without drawing it."""
    if spec.name == "walton_2":
        raise InputError("no point feeds walton_2")
    for suffix in spec.suffixes:
        (folder / f"{spec.name}{suffix}").write_text(dataset_path.read_text())


@pytest.fixture(autouse=True)
def quick(monkeypatch):
    """Replace the drawing in the processes, which are forks of this one."""
    monkeypatch.setattr(render, "render", write_files)


@pytest.fixture
def dataset(tmp_path):
    path = tmp_path / "dataset.nc"
    path.write_text("one")
    return path


@pytest.fixture
def folder(dataset, tmp_path):
    made = tmp_path / "figures"
    made.mkdir()
    draw_figures(NAMES, dataset, made, processes=2, code="a")
    return made


def redrawn(folder, *arguments, **options):
    """Draw again; return the figures whose files have been written or were not there."""

    def times():
        files = [path for path in folder.iterdir() if path.name != RECORD_FILE]
        return {path.name: path.stat().st_mtime_ns for path in files}

    before = times()
    draw_figures(*arguments, folder, **options)
    return {name.partition(".")[0] for name, time in times().items() if before.get(name) != time}


def change_entry(folder, dataset, monkeypatch):
    changed = FIGURES["gallas_6"].model_copy(update={"title": "another"})
    monkeypatch.setitem(FIGURES, "gallas_6", changed)


@pytest.mark.parametrize(
    ("change", "code", "expected"),
    [
        (lambda *_: None, "a", set()),
        (lambda *_: None, "b", set(NAMES)),
        (lambda *_: None, "", set(NAMES)),
        (lambda folder, *_: (folder / "gallas_6.csv").write_text("changed"), "a", {"gallas_6"}),
        (lambda folder, *_: (folder / "gallas_2b.png").unlink(), "a", {"gallas_2b"}),
        (change_entry, "a", {"gallas_6"}),
        (lambda _, dataset, *__: dataset.write_text("other"), "a", set(NAMES)),
    ],
)
def test_what_has_changed_is_drawn_again(folder, dataset, monkeypatch, change, code, expected):
    change(folder, dataset, monkeypatch)
    assert redrawn(folder, NAMES, dataset, code=code) == expected


def test_a_changed_plot_of_the_study_is_drawn_again_alone(dataset, tmp_path):
    study, made = tmp_path / "own.yaml", tmp_path / "figures"
    made.mkdir()
    text = "study: own\nseries: [{name: a, system: belt, grid: {frequency: [20, 50]}}]\nplots:\n"
    text += "- {name: one, x: frequency}\n- {name: two, x: frequency, y: backflow}\n"
    study.write_text(text)
    draw_figures(("one", "two"), dataset, made, code="a", study_path=study)
    study.write_text(text.replace("backflow", "path_drift"))
    assert redrawn(made, ("one", "two"), dataset, code="a", study_path=study) == {"two"}
    with pytest.raises(InputError, match="a plot of a study needs --study"):
        draw_figures(("one",), dataset, made)
    with pytest.raises(InputError, match=r"got 'velocity'; allowed: one of walton_"):
        draw_figures(["velocity"], dataset, made, study_path=study)


def test_one_that_cannot_be_drawn_keeps_no_other_from_it(dataset, folder):
    (folder / "gallas_6.svg").unlink()
    with pytest.raises(InputError, match="no point feeds walton_2"):
        draw_figures(("walton_2", "gallas_6"), dataset, folder, code="a")
    assert (folder / "gallas_6.svg").exists()
