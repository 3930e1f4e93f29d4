"""Pictures of particles: Gallas' beads, Walton's flows of spheres, and animations of both."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from matplotlib.collections import EllipseCollection, LineCollection
from matplotlib.figure import Figure
from matplotlib.patches import Circle

from sim.base.errors import InputError
from sim.dataset.results import load_results
from sim.figures import animation, spheres
from sim.figures.beads import TALLEST, select
from sim.figures.spheres import across_sides, draw_particles, view_from
from sim.figures.style import DOTTED, PALE
from sim.study.figure_spec import FIGURES
from tests.figures.drawing import dashes, data_of_figure, draw, drawn, picture, without_particles
from tests.figures.made_papers import SPREAD
from tests.made.netcdf import ROUNDING, store

BEADS, WIDTH = 12, 5


@pytest.fixture(scope="module")
def results(made_dataset):
    return load_results(made_dataset)


# Beads.


def levels(axes) -> dict[float, object]:
    """Return heights and dashes of the horizontal lines that cross the figure."""
    lines = [line for line in axes.get_lines() if list(line.get_xdata()) == [0, 1]]
    return {line.get_ydata()[0]: dashes(line) for line in lines}


def obstacles(axes) -> list[tuple]:
    return [(one.center, one.radius) for one in axes.patches if isinstance(one, Circle)]


@pytest.mark.parametrize(
    ("name", "places", "titles"),
    [
        ("gallas_4d", [], [("published", 2000), ("converged", 2000)]),
        ("gallas_7a", [((WIDTH / 2, 1), 0.75)], []),
    ],
)
def test_a_path_has_a_dot_per_bead_and_step_within_the_cell(name, places, titles, made_dataset):
    figure, _ = drawn(name, made_dataset)
    axes = figure.axes[0]
    (dots,) = (line for line in axes.get_lines() if line.get_marker() == ".")
    x, z = dots.get_data()
    assert len(x) == 41 * BEADS and x.min() >= 0 and x.max() < WIDTH
    assert (z.min(), z.max()) == (pytest.approx(1), pytest.approx(3))
    assert levels(axes) == {0: "-"} and obstacles(axes) == places and dots.get_rasterized()
    said = [f"{protocol} protocol, {steps} steps a cycle" for protocol, steps in titles]
    assert [one.get_title() for one in figure.axes] == (said or [""])


def test_a_snapshot_has_circles_and_velocities_from_their_centres(made_dataset):
    figure, data = drawn("gallas_5a", made_dataset)
    assert list(data.rows["protocol"]) == ["published", "converged"]
    axes = figure.axes[0]
    (circles,) = [one for one in axes.collections if isinstance(one, EllipseCollection)]
    (sticks,) = [one for one in axes.collections if isinstance(one, LineCollection)]
    centres, segments = circles.get_offsets(), np.array(sticks.get_segments())
    inside = (centres[:, 0] >= 0) & (centres[:, 0] < WIDTH)
    assert inside.sum() == BEADS < len(centres)
    assert segments[:, 0] == pytest.approx(centres)
    (scale,) = (text.get_text() for text in axes.texts)
    point = data.rows.iloc[0]
    speed = 1e-3 * point["frequency"] * min(point["shear_damping"], 50) / 50
    drawn_as = (segments[0, 1] - segments[0, 0]) * float(scale.removesuffix(" m/s"))
    assert drawn_as == pytest.approx([speed, -0.5 * speed], rel=1e-5)
    assert levels(axes) == {0: "-", 1: DOTTED, -1: DOTTED}


def test_of_several_points_the_one_nearest_to_the_paper_is_shown(made_dataset):
    data = data_of_figure("gallas_4a", made_dataset)
    other = data.rows.assign(point="other", belt_ghost="centred")
    both = replace(data, rows=pd.concat([other, data.rows], ignore_index=True))
    assert list(select(both).rows["belt_ghost"]) == ["below"]


def test_beads_beyond_the_tallest_picture_are_counted(made_dataset):
    data = data_of_figure("gallas_4a", load_results(made_dataset))
    path = data.results.particles(data.rows["point"].iloc[0])["path"]
    path[:, :2, 1] += 1.5 * TALLEST * data.rows["diameter"].iloc[0]
    (axes,) = picture(data).axes
    assert axes.get_ylim()[1] == TALLEST
    assert [text.get_text() for text in axes.texts] == ["2 beads above"]


def test_a_dataset_without_the_particles_is_refused(made_dataset, tmp_path):
    path = tmp_path / "dataset.nc"
    with xr.open_dataset(made_dataset) as opened:
        store(opened.load(), path)
    with pytest.raises(InputError, match=r"^belt-.*: no particles in the dataset$"):
        draw("gallas_5a", path, tmp_path)
    data = data_of_figure("gallas_5a", made_dataset)
    for point in data.rows["point"]:
        state = data.results.particles(point).drop_vars("radius")
        store(state, path, mode="a", group=f"states/{point}")
    with pytest.raises(InputError, match=r"^belt-.*: no radius of the particles in the dataset$"):
        draw("gallas_5a", path, tmp_path)


# A chute flow.


def test_a_row_has_instantaneous_profiles_averages_and_replicates_in_two_units(results):
    figure, _ = drawn("walton_1_4", results)
    velocity = figure.axes[0]
    for axes, mean in zip(figure.axes[:2], (None, 0.5), strict=True):
        found = {line.get_label(): line for line in axes.get_lines()}
        latest, average = found["instantaneous"], found["average"]
        assert dashes(latest) == "-" and dashes(average) == (0, DOTTED[1])
        x, z = average.get_data()
        assert latest.get_xdata() / x == pytest.approx(1.5 * (1 + SPREAD[0]), rel=2 * ROUNDING)
        assert x == pytest.approx(mean or 0.1 * z, rel=ROUNDING)
        assert z.max() == pytest.approx(np.pi / 3 * 10, abs=0.25)
        pale = [one.get_xdata() for one in axes.get_lines() if one.get_alpha() == PALE]
        ratios = np.array([one for one in pale if len(one)]) / x
        assert ratios == pytest.approx(np.outer(1 + SPREAD, np.ones(len(x))), rel=2 * ROUNDING)
        assert np.max(ratios * x) < axes.get_xlim()[1] and not axes.collections
    (top,) = velocity.child_axes
    figure.draw_without_rendering()
    assert top.get_xlim()[1] == pytest.approx(velocity.get_xlim()[1] / (9.8e-3) ** 0.5)


def test_flows_of_another_cell_come_behind_and_say_so(results):
    data = without_particles(data_of_figure("walton_1_3", results))
    one = data.rows[data.rows["protocol"] == "published"]
    rows = pd.concat([one.assign(cell=cell) for cell in (5.0, 10.0, 20.0)])
    figure = spheres.draw(replace(data, rows=rows))
    labels = [line.get_label() for line in figure.axes[0].get_lines()]
    cells = [label.partition("fixed length, ")[2] for label in labels if "average" in label]
    assert cells == ["L = 10 σ", "L = 5 σ", "L = 20 σ"]
    assert "no configuration stored" in [text.get_text() for text in figure.axes[2].texts]


@pytest.mark.parametrize(("name", "share"), [("walton_1_4", 0.5), ("walton_1_5", 1.0)])
def test_deep_flows_show_the_whole_cell_and_others_a_portion(results, name, share):
    flow = data_of_figure(name, results).rows.to_dict("records")[0]
    state = results.particles(flow["point"])
    scene = spheres.Scene(flow, state, np.array([1e-2]), np.array([0.0, 1.0]))
    assert scene.shown_size == pytest.approx(flow["cell"] * np.array([1, share]))


# Animations.


@pytest.mark.parametrize("name", [name for name, spec in FIGURES.items() if spec.animated])
def test_an_animation_has_frames_that_differ(results, name):
    moving, data = drawn(name, results)
    assert len(data.rows) == 1 and 20 <= moving.frames <= 40
    first, last = (_places(moving, number) for number in (0, moving.frames - 1))
    assert first.shape != last.shape or (first != last).any()
    if name == "animation_arrested":
        assert list(data.rows["friction"]) == [0.8], "the slowest of the rough flows"


def _places(moving, number):
    moving.show(number)
    collections = moving.figure.axes[0].collections
    (circles,) = (one for one in collections if isinstance(one, EllipseCollection))
    return circles.get_offsets()


def test_no_sphere_goes_further_than_the_eye_follows(results):
    (flow,) = animation.select(data_of_figure("animation_sheared", results)).rows.to_dict("records")
    time, position, speed = animation.motion(results.particles(flow["point"]), flow["diameter"])
    steps = np.diff(position[..., 0], axis=0) / flow["diameter"]
    assert len(time) == animation.FRAMES and steps.max() <= 1.01 * animation.STRIDE
    assert speed == pytest.approx(np.full(speed.shape, 0.1), rel=1e-3)


def test_a_belt_goes_once_up_and_down_along_the_angle_of_vibration(results):
    (point,) = animation.select(data_of_figure("animation_onset", results)).rows.to_dict("records")
    times = np.arange(41) / 40 / point["frequency"]
    marks, heights = zip(*(animation.belt_marks(point, time) for time in times), strict=True)
    assert np.take(heights, [0, 10, 30, 40]) == pytest.approx([0, 1, -1, 0], abs=1e-6)
    assert np.diff([each[0] for each in marks]) == pytest.approx(np.diff(heights), abs=1e-6)


def test_a_point_without_a_path_says_so(results):
    data = without_particles(data_of_figure("animation_block", results))
    moving = picture(animation.select(data))
    assert moving.frames == 1
    assert [text.get_text() for text in moving.figure.axes[0].texts] == ["no motion stored"]


# Particles as circles.

PLACE = np.array([[0.0, 0.0], [1.0, 2.0], [3.0, 0.5]])
SIZE, DEPTH = np.array([1.0, 2.0, 0.5]), np.array([0.3, 0.1, 0.2])
COLOUR = np.array([[1.0, 0, 0, 1], [0, 1, 0, 1], [0, 0, 1, 1]])


@pytest.mark.parametrize("shaded", [False, True])
def test_particles_are_to_scale_and_the_nearest_comes_last(shaded):
    circles = draw_particles(Figure().subplots(), PLACE, SIZE, COLOUR, DEPTH, shaded=shaded)
    each = len(circles.get_widths()) // 3
    # The outermost circle of each is as large as the particle, and where it is.
    assert circles.get_widths()[::each] == pytest.approx(SIZE[[1, 2, 0]])
    assert circles.get_offsets()[::each] == pytest.approx(PLACE[[1, 2, 0]])
    colours = circles.get_facecolors().reshape(3, each, 4)
    assert (colours[..., :3].argmax(axis=2) == [[1], [2], [0]]).all()
    assert (each > 1) == shaded
    # Brightest towards the light, and within the outline.
    radii, offsets = circles.get_widths()[-each:] / 2, circles.get_offsets()[-each:]
    assert (np.diff(colours[-1, :, 0]) >= 0).all()
    assert (np.hypot(*(offsets - offsets[0]).T) + radii <= radii[0] + 1e-12).all()


def test_particles_across_a_side_are_at_both():
    index, x = across_sides(np.array([0.1, 5.0, 9.9, 13.0]), np.ones(4), 10.0)
    assert sorted(zip(index, x.round(6), strict=True)) == [
        *((0, 0.1), (0, 10.1), (1, 5.0), (2, -0.1), (2, 9.9), (3, 3.0))
    ]


def test_views_are_right_handed_and_x_points_down_the_slope():
    slope = np.radians(17)
    assert view_from(0, 0, 17)[:, 0] == pytest.approx([np.cos(slope), -np.sin(slope), 0])
    for view in (view_from(0, 0, 17), view_from(-16, 16, 17)):
        assert (view @ [np.sin(slope), 0, -np.cos(slope)])[0] == pytest.approx(0)
        assert np.cross(view[0], view[1]) == pytest.approx(view[2])
