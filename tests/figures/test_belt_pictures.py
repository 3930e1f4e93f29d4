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
from sim.figures.beads import TALLEST, select
from sim.figures.style import DOTTED
from tests.figures.drawing import dashes, data_of_figure, draw, drawn, picture
from tests.made.netcdf import store

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


@pytest.mark.parametrize("name", ["gallas_4d", "gallas_7a"])
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


@pytest.mark.parametrize("name", ["gallas_5a", "gallas_5d"])
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


@pytest.mark.parametrize("name", ["gallas_4a", "gallas_7a", "gallas_7b"])
def test_the_obstacle_is_drawn_where_there_is_one(name, belt_dataset):
    figure, _ = drawn(name, belt_dataset)
    places = [(one.center, one.radius) for one in obstacles(figure.axes[0])]
    assert places == ([((WIDTH / 2, 1), 0.75)] if name.startswith("gallas_7") else [])


@pytest.mark.parametrize(("name", "steps"), [("gallas_4d", 2000), ("gallas_5a", 5000)])
def test_the_protocols_stand_side_by_side_where_both_are_in_the_data(name, steps, belt_dataset):
    figure, data = drawn(name, belt_dataset)
    assert list(data.rows["protocol"]) == ["published", "converged"]
    titles = [
        "published protocol, 2000 steps a cycle",
        f"converged protocol, {steps} steps a cycle",
    ]
    assert [axes.get_title() for axes in figure.axes] == titles


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
