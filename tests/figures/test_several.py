"""Several figures in one job: those that are up to date are skipped."""

import pytest

from sim.base.errors import InputError
from sim.figures import render
from sim.figures.figure_records import RECORD_FILE
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


def times(folder):
    return {
        path.name: path.stat().st_mtime_ns for path in folder.iterdir() if path.name != RECORD_FILE
    }


def redrawn(before, folder):
    """Return the figures whose files have been written since."""
    return {name.partition(".")[0] for name, time in times(folder).items() if before[name] != time}


def test_the_same_is_not_drawn_again(folder, dataset):
    before = times(folder)
    draw_figures(NAMES, dataset, folder, code="a")
    assert redrawn(before, folder) == set()


@pytest.mark.parametrize("code", ["b", ""])
def test_other_code_or_none_draws_all(folder, dataset, code):
    before = times(folder)
    draw_figures(NAMES, dataset, folder, code=code)
    assert redrawn(before, folder) == set(NAMES)


def test_a_file_that_was_lost_or_changed_is_drawn_again(folder, dataset):
    before = times(folder)
    (folder / "gallas_6.csv").write_text("changed")
    draw_figures(NAMES, dataset, folder, code="a")
    assert redrawn(before, folder) == {"gallas_6"}
    (folder / "gallas_2b.png").unlink()
    before = times(folder)
    draw_figures(NAMES, dataset, folder, code="a")
    assert redrawn(before | {"gallas_2b.png": 0}, folder) == {"gallas_2b"}


def test_a_changed_entry_of_the_catalogue_is_drawn_again(folder, dataset, monkeypatch):
    before = times(folder)
    changed = FIGURES["gallas_6"].model_copy(update={"title": "another"})
    monkeypatch.setitem(FIGURES, "gallas_6", changed)
    draw_figures(NAMES, dataset, folder, code="a")
    assert redrawn(before, folder) == {"gallas_6"}


def test_a_changed_plot_of_the_study_is_drawn_again_alone(dataset, tmp_path):
    study, made = tmp_path / "own.yaml", tmp_path / "figures"
    made.mkdir()
    text = "study: own\nseries: [{name: a, system: belt, grid: {frequency: [20, 50]}}]\nplots:\n"
    text += "- {name: one, x: frequency}\n- {name: two, x: frequency, y: backflow}\n"
    study.write_text(text)
    draw_figures(("one", "two"), dataset, made, code="a", study_path=study)
    before = times(made)
    study.write_text(text.replace("backflow", "path_drift"))
    draw_figures(("one", "two"), dataset, made, code="a", study_path=study)
    assert redrawn(before, made) == {"two"}
    with pytest.raises(InputError, match="a plot of a study needs --study"):
        draw_figures(("one",), dataset, made)


def test_another_dataset_draws_all(folder, dataset):
    dataset.write_text("other")
    before = times(folder)
    draw_figures(NAMES, dataset, folder, code="a")
    assert redrawn(before, folder) == set(NAMES)


def test_one_that_cannot_be_drawn_keeps_no_other_from_it(dataset, folder):
    (folder / "gallas_6.svg").unlink()
    with pytest.raises(InputError, match="no point feeds walton_2"):
        draw_figures(("walton_2", "gallas_6"), dataset, folder, code="a")
    assert (folder / "gallas_6.svg").exists()


def test_a_name_that_is_unknown_without_a_study_may_be_a_plot_of_one(dataset, folder, tmp_path):
    with pytest.raises(InputError, match=r"got 'velocity'; .*; a plot of a study needs --study"):
        draw_figures(["velocity"], dataset, folder)
    study = tmp_path / "own.yaml"
    study.write_text("study: own\nseries: [{name: one, system: chute, cases: [{}]}]\n")
    with pytest.raises(InputError, match=r"got 'velocity'; allowed: one of walton_"):
        draw_figures(["velocity"], dataset, folder, study_path=study)
