"""Particles as circles: their places and sizes, which one is in front, light, sides, and slope."""

import numpy as np
import pytest
from matplotlib.figure import Figure

from sim.figures.spheres import across_sides, draw_particles, view_from

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


def test_a_shaded_sphere_is_brightest_towards_the_light_and_within_its_outline():
    circles = draw_particles(Figure().subplots(), PLACE[:1], SIZE[:1], COLOUR[:1], shaded=True)
    radii, offsets = circles.get_widths() / 2, circles.get_offsets()
    assert (np.diff(circles.get_facecolors()[:, 0]) >= 0).all()
    assert offsets[-1, 0] < 0 < offsets[-1, 1]
    assert (np.hypot(*offsets.T) + radii <= radii[0] + 1e-12).all()


def test_particles_across_a_side_are_at_both():
    index, x = across_sides(np.array([0.1, 5.0, 9.9, 13.0]), np.ones(4), 10.0)
    assert sorted(zip(index, x.round(6), strict=True)) == [
        *((0, 0.1), (0, 10.1), (1, 5.0), (2, -0.1), (2, 9.9), (3, 3.0))
    ]


def test_views_are_right_handed_and_x_points_down_the_slope():
    slope = np.radians(17)
    assert view_from(0, 0, 17)[:, 0] == pytest.approx([np.cos(slope), -np.sin(slope), 0])
    assert view_from(0, 0, 17)[1, 2] > 0
    for view in (view_from(0, 0, 17), view_from(-16, 16, 17)):
        assert (view @ [np.sin(slope), 0, -np.cos(slope)])[0] == pytest.approx(0)
        assert np.cross(view[0], view[1]) == pytest.approx(view[2])
