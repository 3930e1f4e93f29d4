"""Walton's Figs. 1.1-1.6: profiles as the caption draws them, replicates, a configuration, data."""

from dataclasses import replace

import matplotlib as mpl
import numpy as np
import pandas as pd
import pytest

from sim.dataset.results import load_results
from sim.figures import row
from sim.figures.style import DOTTED, PALE
from tests.figures.drawing import dashes, data_of_figure, drawn, picture, without_particles
from tests.figures.made_chute import SPREAD
from tests.made.netcdf import ROUNDING

ROWS = {f"walton_1_{number}": depth for number, depth in enumerate((1.24, 2.5, 5, 10, 20, 40), 1)}


@pytest.fixture(scope="module")
def results(chute_dataset):
    return load_results(chute_dataset)


def lines(axes) -> dict[str, mpl.lines.Line2D]:
    return {line.get_label(): line for line in axes.get_lines()}


@pytest.mark.parametrize("name", ["walton_1_1", "walton_1_6"])
def test_instantaneous_profiles_are_solid_and_averages_dotted(results, name):
    figure, _ = drawn(name, results)
    for axes, mean in zip(figure.axes[:2], (None, 0.5), strict=True):
        found = lines(axes)
        assert dashes(found["instantaneous"]) == "-"
        assert dashes(found["average"]) == (0, DOTTED[1])
        ratio = found["instantaneous"].get_xdata() / found["average"].get_xdata()
        assert ratio == pytest.approx(1.5 * (1 + SPREAD[0]), rel=2 * ROUNDING)
        if mean:
            assert found["average"].get_xdata() == pytest.approx(mean, rel=ROUNDING)


def test_heights_are_in_diameters_and_velocities_in_two_units(results):
    figure, _ = drawn("walton_1_4", results)
    velocity = figure.axes[0]
    line = lines(velocity)["average"]
    assert line.get_xdata() == pytest.approx(0.1 * line.get_ydata(), rel=ROUNDING)
    assert line.get_ydata().max() == pytest.approx(np.pi / 3 * 10, abs=0.25)
    (top,) = velocity.child_axes
    figure.draw_without_rendering()
    assert top.get_xlim()[1] == pytest.approx(velocity.get_xlim()[1] / (9.8e-3) ** 0.5)


def test_every_replicate_is_a_pale_line_within_the_panel_and_there_is_no_band(results):
    figure, _ = drawn("walton_1_2", results)
    for axes, mean in zip(figure.axes[:2], (None, 0.5), strict=True):
        assert not axes.collections
        pale = [
            line for line in axes.get_lines() if line.get_alpha() == PALE and line.get_xdata().size
        ]
        average = lines(axes)["average"].get_xdata()
        ratios = np.array([line.get_xdata() for line in pale]) / average
        assert ratios == pytest.approx(
            np.outer(1 + SPREAD, np.ones(len(average))), rel=2 * ROUNDING
        )
        assert max(line.get_xdata().max() for line in pale) < axes.get_xlim()[1]
        if mean:
            assert average == pytest.approx(mean, rel=ROUNDING)


def test_flows_of_another_cell_come_behind_and_say_so(results):
    data = data_of_figure("walton_1_3", results)
    one = data.rows[data.rows["protocol"] == "published"]
    rows = pd.concat([one.assign(cell=cell) for cell in (5.0, 10.0, 20.0)])
    figure = row.draw(replace(data, rows=rows))
    labels = [line.get_label() for line in figure.axes[0].get_lines()]
    assert [label.partition("fixed length, ")[2] for label in labels if "average" in label] == [
        "L = 10 σ",
        "L = 5 σ",
        "L = 20 σ",
    ]


@pytest.mark.parametrize(("name", "share"), [("walton_1_4", 0.5), ("walton_1_5", 1.0)])
def test_deep_flows_show_the_whole_cell_and_others_a_portion(results, name, share):
    flow = data_of_figure(name, results).rows.to_dict("records")[0]
    state = results.particles(flow["point"])
    scene = row.Scene(flow, state, np.array([1e-2]), np.array([0.0, 1.0]))
    assert scene.shown_size == pytest.approx(flow["cell"] * np.array([1, share]))


def test_a_flow_without_stored_particles_still_has_its_profiles(results):
    figure = picture(without_particles(data_of_figure("walton_1_1", results)))
    assert "no configuration stored" in [text.get_text() for text in figure.axes[2].texts]
