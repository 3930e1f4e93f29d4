"""Pictures of spheres: size, light, which one is in front, shadows, the floor and its slope."""

import numpy as np
import pytest

from sim.figures.spheres import LIGHT, Frame, frame_around, picture, project, view_from

FRONT = view_from(0, 0)
FRAME = Frame(-2, 2, -2, 2)
PIXEL = 0.02
RED, BLUE = np.array([1.0, 0, 0]), np.array([0, 0, 1.0])


def drawn(position, radius, colour, view=FRONT, floor=None) -> np.ndarray:
    arrays = (np.array(values, float) for values in (position, radius, colour))
    return picture(view, FRAME, PIXEL, *arrays, floor=floor)


def test_one_sphere_is_a_disk_of_its_size_in_its_place():
    image = drawn([[0.5, 0, 0.25]], [1], [RED])
    assert image.shape == (200, 200, 4)
    opacity = image[..., 3] / 255
    assert opacity.sum() * PIXEL**2 == pytest.approx(np.pi, rel=0.01)
    rows, columns = np.indices(opacity.shape)
    assert np.average(columns, weights=opacity) * PIXEL - 2 == pytest.approx(0.5, abs=PIXEL)
    assert 2 - np.average(rows, weights=opacity) * PIXEL == pytest.approx(0.25, abs=PIXEL)


def test_a_sphere_is_brightest_where_it_faces_the_light():
    red = drawn([[0, 0, 0]], [1.5], [RED])[..., 0].astype(int)
    row, column = np.argwhere(red == red.max()).mean(axis=0)
    assert (column * PIXEL - 2) / 1.5 == pytest.approx(LIGHT[0], abs=0.05)
    assert (2 - row * PIXEL) / 1.5 == pytest.approx(LIGHT[1], abs=0.05)


@pytest.mark.parametrize("order", [(0, 1), (1, 0)])
def test_the_nearer_sphere_hides_the_other_whatever_their_order(order):
    position = np.array([[0, -1.5, 0], [0, 1.5, 0]])[list(order)]
    image = drawn(position, [1, 1], np.array([RED, BLUE])[list(order)])
    assert image[100, 100, 0] > 100
    assert image[100, 100, 2] == 0
    assert image[..., 2].max() == 0


def test_spheres_that_overlap_meet_half_way():
    image = drawn([[-0.5, 0, 0], [0.5, 0, 0]], [1, 1], [RED, BLUE])
    assert image[100, 95, 0] > image[100, 95, 2]
    assert image[100, 105, 2] > image[100, 105, 0]


def test_a_sphere_between_another_and_the_light_casts_a_shadow_on_it():
    towards = LIGHT @ np.stack([FRONT.right, FRONT.up, FRONT.toward])
    alone = drawn([[0, 0, 0]], [1], [RED])
    both = drawn([[0, 0, 0], 1.8 * towards], [1, 0.3], [RED, BLUE])
    darker = (both[..., 0] < 0.8 * alone[..., 0]) & (both[..., 2] == 0) & (alone[..., 0] > 100)
    assert darker.sum() > 50


def test_a_floor_is_below_the_spheres_and_slopes_down_to_the_right():
    view = view_from(-16, 16, 17)
    floor = np.array([[-1, -1], [1, 1]])
    image = drawn([[0, 0, 0.5]], [0.5], [BLUE], view, floor)
    middle = round(2 / PIXEL - project(view, np.array([0, 0, 0.5]))[1] / PIXEL)
    assert image[middle, 100, 2] > image[middle, 100, 0]
    heights = [
        np.flatnonzero(image[:, column, 3]).mean() for column in (70, 130) if image[:, column].any()
    ]
    assert heights[0] < heights[1]


def test_views_are_right_handed_and_x_points_down_the_slope():
    view = view_from(0, 0, 17)
    x, _, z = project(view, np.eye(3))
    assert x == pytest.approx([np.cos(np.radians(17)), -np.sin(np.radians(17)), 0])
    assert z[1] > 0
    fall = np.array([np.sin(np.radians(17)), 0, -np.cos(np.radians(17))])
    for chosen in (view, view_from(-16, 16, 17)):
        assert project(chosen, fall)[0] == pytest.approx(0)
        assert np.cross(chosen.right, chosen.up) == pytest.approx(chosen.toward)


def test_a_frame_shows_all_points_and_a_picture_of_nothing_is_clear():
    frame = frame_around(FRONT, np.array([[-1, 5, 0], [2, 0, 3]]), 0.5)
    assert frame == (-1.5, 2.5, -0.5, 3.5)
    assert not picture(FRONT, FRAME, 1, np.zeros((0, 3)), np.zeros(0), np.zeros((0, 3))).any()
