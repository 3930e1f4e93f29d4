"""Figures of flows that the engine has run, from their files to the pictures."""

from sim.dataset.build import build
from sim.engine.run import run_point
from sim.study.figure_spec import FIGURES
from sim.study.load import load_study
from tests.figures.drawing import draw
from tests.made.processes import ROOT


def test_figures_of_spheres_are_made(tmp_path):
    path = ROOT / "tests" / "data" / "flows.yaml"
    study, runs = load_study(path, tmp_path), tmp_path / "flows" / "runs"
    runs.mkdir(parents=True)
    for point in study.points.values():
        assert run_point(point.parameters, runs / f"{point.id}.nc", quiet=True) == 0
    dataset = build(path, tmp_path)
    for name in study.figures:
        files = draw(name, dataset, tmp_path / "figures")
        assert [file.suffix for file in files] == [".png", ".svg", ".csv", ".txt"]
        assert all(file.stat().st_size > 0 for file in files)
        assert len(files) == len(FIGURES[name].suffixes)
