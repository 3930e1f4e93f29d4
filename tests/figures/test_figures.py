"""Every figure as a reader gets it: files, line styles of the papers, markers, data, caption."""

from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from sim.figures.style import DASH_DOT, SHORT_DASH
from sim.study.load import load_study
from tests.figures import drawing
from tests.figures.drawing import dashes, draw
from tests.made.figures import make_built_study
from tests.made.netcdf import store
from tests.made.runs import FAILURE, is_hurt, is_lost

NAMES = ("walton_2", "gallas_1a", "gallas_1b", "gallas_1c")
LONG_DASH = (0, (5, 2))


@pytest.fixture(scope="module")
def made(tmp_path_factory) -> tuple[Path, Path]:
    return make_built_study(tmp_path_factory.mktemp("made"))


@pytest.fixture(scope="module")
def dataset_path(made) -> Path:
    return made[1] / "made" / "dataset.nc"


@pytest.fixture(scope="module")
def folder(dataset_path, tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("figures")
    for name in NAMES:
        draw(name, dataset_path, folder)
    return folder


def drawn(name: str, dataset_path: Path):
    """Return the axes of a figure and its rows."""
    figure, data = drawing.drawn(name, dataset_path)
    return figure.axes[0], data.rows


STYLES = {
    "gallas_1a": {"α = π/3": DASH_DOT, "α = π/4": "-", "α = π/6": SHORT_DASH},
    "gallas_1b": {"$A_z$/⟨d⟩ = 1.5": DASH_DOT, "$A_z$/⟨d⟩ = 1": "-", "$A_z$/⟨d⟩ = 0.5": SHORT_DASH},
    "gallas_1c": {"f = 50 Hz": "-", "f = 20 Hz": LONG_DASH},
}


@pytest.mark.parametrize("name", STYLES)
def test_lines_have_the_dashes_of_the_paper(dataset_path, name):
    axes, _ = drawn(name, dataset_path)
    legend = {line.get_label(): line for line in axes.get_lines() if "=" in line.get_label()}
    assert {label: dashes(legend[label]) for label in STYLES[name]} == STYLES[name]


def marked(axes, face: str) -> int:
    """Return the number of data points with filled or with open markers."""
    return sum(
        len(line.get_xdata())
        for line in axes.get_lines()
        if line.get_linestyle() == "None"
        and (line.get_markerfacecolor() == "white") == (face == "open")
        and line.get_marker() != "_"
    )


def test_points_that_are_not_steady_have_open_markers(dataset_path):
    axes, rows = drawn("gallas_1a", dataset_path)
    assert (marked(axes, "open"), marked(axes, "filled")) == (3, 9)
    assert list(rows[rows["regime"] == "arrested"]["frequency"]) == [10, 10, 10]


def test_all_flows_of_fig_2_are_on_its_logarithmic_axis(dataset_path):
    axes, rows = drawn("walton_2", dataset_path)
    low, high = axes.get_ylim()
    known = rows[rows["completed"] > 0]["velocity"]
    assert axes.get_yscale() == "log" and known.between(low, high).all()
    held = {line.get_color() for line in axes.get_lines() if 0.5 in line.get_xdata()}
    assert held == {"#000000", "#0072b2"}, "a marker in the colour of each of two series"


@pytest.mark.parametrize(
    ("regimes", "velocities"),
    [(("accelerating", "accelerating"), (0.5, 0.5)), (("steady", "steady"), (0.2, 2.0))],
)
def test_flows_that_accelerate_or_disagree_are_not_joined(
    regimes, velocities, dataset_path, tmp_path
):
    with xr.open_dataset(dataset_path) as opened:
        dataset = opened.load()
    series = (dataset["depth"] == 5) & (dataset["restitution"] == 0.85)
    point = np.flatnonzero(series & (dataset["friction"] == 0.4))[0]
    slopes = tuple(2.0 if regime == "accelerating" else 0.0 for regime in regimes)
    changes = {"regime": regimes, "velocity": velocities, "acceleration": slopes}
    for name, values in changes.items():
        changed = dataset[name].values
        changed[point, :2] = values
        dataset[name] = dataset[name].dims, changed
    store(dataset, tmp_path / "dataset.nc")
    axes, _ = drawn("walton_2", tmp_path / "dataset.nc")
    joined = {
        line.get_color(): np.isfinite(line.get_ydata()[list(line.get_xdata()).index(5)])
        for line in axes.get_lines()
        if line.get_linestyle() != "None" and 5 in line.get_xdata()[1:]
    }
    assert joined == {"#000000": True, "#0072b2": False, "#d55e00": True}


def test_caption_says_what_is_missing_and_what_the_bars_are(folder, made):
    caption = (folder / "walton_2.caption.txt").read_text()
    points = load_study(*made).points.values()
    (lost,) = (point.id for point in points if is_lost(point.parameters))
    (hurt,) = (point.id for point in points if is_hurt(point.parameters))
    assert f"Left out because the run failed: {lost} ({FAILURE})" in caption
    assert f"{hurt} (1 of 2 replicates left: {FAILURE})" in caption
    assert "of one replicate within the run" in caption
    assert "accelerating 2" in caption and "failed 1" in caption
    assert "θ = 17°" in caption
    single = (folder / "gallas_1c.caption.txt").read_text()
    assert "within the run, without how much initial states differ." in single
    assert "open ones" not in single
