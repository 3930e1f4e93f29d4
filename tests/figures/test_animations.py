"""Animations: frames and size of the files, slow motion, one cycle of the belt, captions."""

import numpy as np
import pytest
from matplotlib.collections import EllipseCollection

from sim.dataset.results import load_results
from sim.figures import animation
from sim.study.catalogue import FIGURES
from tests.figures.drawing import data_of_figure, drawn, picture, without_particles

ANIMATIONS = [name for name, spec in FIGURES.items() if spec.animated]


@pytest.fixture(scope="module")
def results(chute_dataset):
    return load_results(chute_dataset)


@pytest.mark.parametrize("name", ANIMATIONS)
def test_an_animation_has_frames_that_differ(results, name):
    moving, data = drawn(name, results)
    assert len(data.rows) == 1
    assert 20 <= moving.frames <= 40
    first, last = (_places(moving, number) for number in (0, moving.frames - 1))
    assert first.shape != last.shape or (first != last).any()


def _places(moving, number):
    moving.show(number)
    (circles,) = (
        one for one in moving.figure.axes[0].collections if isinstance(one, EllipseCollection)
    )
    return circles.get_offsets()


def test_no_sphere_goes_further_than_the_eye_follows(results):
    _, data = drawn("animation_sheared", results)
    (row,) = data.rows.to_dict("records")
    time, position, speed = animation.motion(results.particles(row["point"]), row["diameter"])
    steps = np.diff(position[..., 0], axis=0) / row["diameter"]
    assert len(time) == animation.FRAMES
    assert steps.max() <= 1.01 * animation.STRIDE
    assert speed == pytest.approx(np.full(speed.shape, 0.1), rel=1e-3)


def test_a_belt_goes_once_up_and_down_along_the_angle_of_vibration(results):
    moving, data = drawn("animation_onset", results)
    (row,) = data.rows.to_dict("records")
    assert animation.EVERY * moving.frames == 40
    times = np.arange(41) / 40 / row["frequency"]
    marks, levels = zip(*(animation.belt_marks(row, time) for time in times), strict=True)
    assert np.take(levels, [0, 10, 30, 40]) == pytest.approx([0, 1, -1, 0], abs=1e-6)
    assert np.diff([each[0] for each in marks]) == pytest.approx(np.diff(levels), abs=1e-6)


def test_the_slowest_of_the_rough_flows_is_drawn(results):
    _, data = drawn("animation_arrested", results)
    assert list(data.rows["friction"]) == [0.8]


def test_a_point_without_a_path_says_so(results):
    data = without_particles(data_of_figure("animation_block", results))
    moving = picture(animation.select(data))
    assert moving.frames == 1
    assert [text.get_text() for text in moving.figure.axes[0].texts] == ["no motion stored"]
