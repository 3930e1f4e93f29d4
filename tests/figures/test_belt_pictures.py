"""Gallas' Figs. 4, 5 and 7: every bead and its path, the belt, the obstacle, data and caption."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from matplotlib.collections import EllipseCollection, LineCollection
from matplotlib.patches import Circle

from sim.base.errors import InputError
from sim.dataset.results import load_results
from sim.figures.beads import TALLEST, round_speed, select
from sim.figures.render import settle
from sim.figures.style import DOTTED
from sim.study.catalogue import FIGURES
from tests.figures.drawing import dashes, data_of_figure, draw, drawn, picture, texts
from tests.made.netcdf import store

PATHS = ("gallas_4a", "gallas_4b", "gallas_4c", "gallas_4d", "gallas_4e", "gallas_7a", "gallas_7c")
SNAPSHOTS = ("gallas_5a", "gallas_5b", "gallas_5c", "gallas_5d", "gallas_7b")
TWO_PANELS = {"gallas_4d": 2000, "gallas_5a": 5000}
BEADS, WIDTH = 12, 5


def levels(axes) -> dict[float, object]:
    """Return heights and dashes of the horizontal lines that cross the figure."""
    return {
        line.get_ydata()[0]: dashes(line)
        for line in axes.get_lines()
        if list(line.get_xdata()) == [0, 1]
    }


def obstacles(axes) -> list[Circle]:
    return [patch for patch in axes.patches if isinstance(patch, Circle)]


def test_these_are_the_papers_figures_of_particles():
    shown = {name for name, spec in FIGURES.items() if spec.particles}
    assert {name for name in shown if name.startswith("gallas")} == {*PATHS, *SNAPSHOTS}


@pytest.mark.parametrize("name", PATHS)
def test_a_path_has_a_dot_per_bead_and_step_within_the_cell(name, belt_dataset):
    figure, _ = drawn(name, belt_dataset)
    axes = figure.axes[0]
    (dots,) = (line for line in axes.get_lines() if line.get_marker() == ".")
    x, z = dots.get_data()
    assert len(x) == 41 * BEADS
    assert x.min() >= 0
    assert x.max() < WIDTH
    assert (z.min(), z.max()) == (pytest.approx(1), pytest.approx(3))
    assert levels(axes) == {0: "-"}
    assert dots.get_rasterized()


@pytest.mark.parametrize("name", SNAPSHOTS)
def test_a_snapshot_has_circles_and_velocities_from_their_centres(name, belt_dataset):
    figure, data = drawn(name, belt_dataset)
    axes = figure.axes[0]
    circles = [one for one in axes.collections if isinstance(one, EllipseCollection)]
    sticks = [one for one in axes.collections if isinstance(one, LineCollection)]
    centres = np.concatenate([one.get_offsets() for one in circles])
    inside = centres[(centres[:, 0] >= 0) & (centres[:, 0] < WIDTH)]
    assert len(inside) == BEADS
    assert len(centres) > BEADS
    segments = np.concatenate([one.get_segments() for one in sticks])
    assert segments[:, 0] == pytest.approx(centres)
    (scale,) = (text.get_text() for text in axes.texts)
    row = data.rows.iloc[0]
    speed = 1e-3 * row["frequency"] * min(row["shear_damping"], 50) / 50
    drawn_as = (segments[0, 1] - segments[0, 0]) * float(scale.removesuffix(" m/s"))
    assert drawn_as == pytest.approx([speed, -0.5 * speed], rel=1e-5)
    assert levels(axes) == {0: "-", 1: DOTTED, -1: DOTTED}


@pytest.mark.parametrize("name", [*PATHS, *SNAPSHOTS])
def test_the_obstacle_is_drawn_where_there_is_one(name, belt_dataset):
    figure, _ = drawn(name, belt_dataset)
    places = [(one.center, one.radius) for one in obstacles(figure.axes[0])]
    assert places == ([((WIDTH / 2, 1), 0.75)] if name.startswith("gallas_7") else [])


@pytest.mark.parametrize("name", [*PATHS, *SNAPSHOTS])
def test_data_and_caption(name, belt_dataset):
    data, text = texts(name, belt_dataset)
    panels = 1 + (name in TWO_PANELS)
    assert len(data) == panels * (41 * BEADS if name in PATHS else BEADS)
    assert data["protocol"].nunique() == panels
    assert {"x [⟨d⟩]", "z [⟨d⟩]"} < set(data)
    assert ("time [s]" in data) == (name in PATHS)
    assert ("v_x [m s-1]" in data) == (name in SNAPSHOTS)
    where = FIGURES[name].where
    # Without shear friction there is no transport, and no trend is small beside a mean of nothing.
    regime = "steady" if where["shear_damping"] else "undetermined"
    for part in (
        f"Gallas et al. (1992), Fig. {name[-2:]}. ",
        f"f = {where['frequency']} Hz",
        f"d_o = {where['obstacle']} ⟨d⟩",
        f"γ_s = {where['shear_damping']}g",
        "t_tr = 45 cycles",
        "Published protocol: point belt-",
        f"(published protocol, {regime})",
        ", 3 replicates.",
        "The paper: ",
    ):
        assert part in text
    assert "Error bars" not in text


@pytest.mark.parametrize(("name", "steps"), TWO_PANELS.items())
def test_the_protocols_stand_side_by_side_where_both_are_in_the_data(name, steps, belt_dataset):
    figure, data = drawn(name, belt_dataset)
    assert list(data.rows["protocol"]) == ["published", "converged"]
    titles = [
        "published protocol, 2000 steps a cycle",
        f"converged protocol, {steps} steps a cycle",
    ]
    assert [axes.get_title() for axes in figure.axes] == titles


@pytest.mark.parametrize("name", TWO_PANELS)
def test_labels_are_in_the_picture_and_the_legend_is_above_the_titles(name, belt_dataset):
    _, data = drawn(name, belt_dataset)
    wide = replace(data, rows=data.rows.assign(width=20.0))
    figure = picture(wide)
    settle(figure)
    legend = figure.legends[0].get_window_extent()
    for axes in figure.axes:
        assert axes.xaxis.label.get_window_extent().y0 >= 0
        assert axes.title.get_window_extent().y1 <= legend.y0


def test_of_several_points_the_one_nearest_to_the_paper_is_shown(belt_dataset):
    data = data_of_figure("gallas_4a", belt_dataset)
    other = data.rows.assign(point="other", belt_ghost="centred")
    both = replace(data, rows=pd.concat([other, data.rows], ignore_index=True))
    assert list(select(both).rows["belt_ghost"]) == ["below"]


def test_beads_beyond_the_tallest_picture_are_counted(belt_dataset):
    data = data_of_figure("gallas_4a", load_results(belt_dataset))
    path = data.results.particles(data.rows["point"].iloc[0])["path"]
    path[:, :2, 1] += 1.5 * TALLEST * data.rows["diameter"].iloc[0]
    (axes,) = picture(data).axes
    assert axes.get_ylim()[1] == TALLEST
    assert [text.get_text() for text in axes.texts] == ["2 beads above"]


@pytest.mark.parametrize("name", ["gallas_4d", "gallas_5d"])
def test_files_are_small(name, belt_dataset, tmp_path):
    png, svg, _, _ = draw(name, belt_dataset, tmp_path)
    assert 0 < png.stat().st_size < 200_000
    assert 0 < svg.stat().st_size < 200_000


def test_paths_in_the_data_are_not_wrapped(belt_dataset):
    data, _ = texts("gallas_4d", belt_dataset)
    first = data[(data["bead"] == 0) & (data["protocol"] == "published")]
    assert first["x [⟨d⟩]"].iloc[-1] - first["x [⟨d⟩]"].iloc[0] == pytest.approx(WIDTH, abs=1e-3)
    assert first["time [s]"].iloc[-1] == pytest.approx(1 / 80)


@pytest.mark.parametrize(
    ("speed", "scale"),
    [(0.03, 0.05), (1.0, 2), (0.7, 1), (0.012, 0.02), (0.0, 1)],
)
def test_velocities_have_a_round_scale(speed, scale):
    assert round_speed(speed**2) == scale


@pytest.mark.parametrize(("name", "lost"), [("gallas_4a", "path"), ("gallas_5a", "radius")])
def test_a_dataset_without_the_particles_is_refused(name, lost, belt_dataset, tmp_path):
    path = tmp_path / "dataset.nc"
    with xr.open_dataset(belt_dataset) as opened:
        store(opened.load(), path)
    with pytest.raises(InputError, match=r"^belt-.*: no particles in the dataset$"):
        draw(name, path, tmp_path)
    _, data = drawn(name, belt_dataset)
    point = data.rows["point"].iloc[0]
    store(data.results.particles(point).drop_vars(lost), path, mode="a", group=f"states/{point}")
    with pytest.raises(InputError, match=rf"^belt-.*: no {lost} of the particles in the dataset$"):
        draw(name, path, tmp_path)


@pytest.mark.parametrize("name", ["gallas_4a", "gallas_5a"])
def test_a_point_that_failed_leaves_an_empty_picture(name, belt_dataset, tmp_path):
    with xr.open_dataset(belt_dataset) as opened:
        dataset = opened.load()
    dataset["status"][:] = "failed"
    store(dataset, tmp_path / "dataset.nc")
    png, _, csv, caption = draw(name, tmp_path / "dataset.nc", tmp_path)
    assert png.stat().st_size > 0
    assert len(csv.read_text().splitlines()) == 1
    assert "Left out because the run failed: belt-" in caption.read_text()
