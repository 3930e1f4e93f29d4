"""Gallas' Figs. 2 and 3: a curve per flow with its band, the paper's dashes, data and caption."""

import numpy as np
import pandas as pd
import pytest
from matplotlib.colors import to_rgb
from scipy.stats import t

from sim.dataset.results import load_results
from sim.figures.plot import completed_rows
from sim.figures.profiles import THIN, means
from sim.figures.style import DASH_DOT, DOTTED, LONG_DASH, SHORT_DASH
from sim.parameters import BeltParameters
from tests.figures.drawing import dashes, data_of_figure, drawn
from tests.figures.made_belt import SPREAD, plateau, transport
from tests.made.netcdf import ROUNDING

FREQUENCIES = {"f = 10 Hz": "-", "f = 20 Hz": LONG_DASH, "f = 60 Hz": DASH_DOT, "f = 80 Hz": DOTTED}
DAMPINGS = {
    "(γ, γ$_s$) = (10g, 10g)": SHORT_DASH,
    "(γ, γ$_s$) = (0, 50g)": DASH_DOT,
    "(γ, γ$_s$) = (50g, 100g)": "-",
    "(γ, γ$_s$) = (10g, 10g), fast start": LONG_DASH,
}
STYLES = {"gallas_2a": FREQUENCIES, "gallas_3c": DAMPINGS}
HALF_WIDTH = t.ppf(0.975, 2) * SPREAD.std(ddof=1) / 3**0.5


def profiles(data) -> pd.DataFrame:
    """Return the slices of all points."""
    return pd.concat([means(data, row).assign(point=row["point"]) for row in completed_rows(data)])


def curves(axes) -> list:
    """Return the lines with data."""
    return [line for line in axes.get_lines() if len(line.get_xdata())]


@pytest.mark.parametrize("name", STYLES)
def test_lines_have_the_dashes_of_the_paper(name, belt_dataset):
    figure, _ = drawn(name, belt_dataset)
    (axes,) = figure.axes
    legend = {
        line.get_label(): dashes(line) for line in axes.get_lines() if "=" in line.get_label()
    }
    assert legend == STYLES[name]
    for line in curves(axes):
        assert dashes(line) in STYLES[name].values()


@pytest.mark.parametrize("name", STYLES)
def test_the_profiles_are_those_of_the_dataset_in_the_units_of_the_axes(name, belt_dataset):
    _, data = drawn(name, belt_dataset)
    table = profiles(data)
    assert set(table["point"]) == set(data.rows["point"])
    for row in data.rows.to_dict("records"):
        parameters = BeltParameters(
            frequency=row["frequency"], damping=row["damping"], shear_damping=row["shear_damping"]
        )
        expected = plateau(parameters) if name[-2] == "2" else transport(parameters)
        part = table[table["point"] == row["point"]]
        assert part["x"].to_numpy() == pytest.approx(expected, rel=ROUNDING)
        widths = pytest.approx(expected * HALF_WIDTH, abs=5 * expected * ROUNDING)
        assert part["x_half"].to_numpy() == widths
        assert part["height"].to_numpy() == pytest.approx(np.arange(len(part)) + 0.5)
        assert part["height"].iloc[-1] + 1 > 10 / plateau(parameters) > part["height"].iloc[-1]


def test_converged_curves_are_pale_beside_the_published_ones(belt_dataset):
    figure, data = drawn("gallas_2a", belt_dataset)
    assert list(data.rows["protocol"]).count("converged") == 2
    (axes,) = figure.axes
    pale = [line for line in curves(axes) if line.get_alpha()]
    plain = [line for line in curves(axes) if not line.get_alpha()]
    assert (len(pale), len(plain)) == (2, 4)
    assert {to_rgb(line.get_color()) for line in pale} < {to_rgb(x.get_color()) for x in plain}
    labels = [text.get_text() for text in figure.legends[0].get_texts()]
    assert labels[-2:] == ["published protocol", "converged protocol"]
    other, _ = drawn("gallas_3a", belt_dataset)
    assert not [line for line in other.axes[0].get_lines() if line.get_alpha()]


def test_a_slice_that_is_empty_in_a_replicate_has_no_velocity(belt_dataset):
    data = data_of_figure("gallas_3a", load_results(belt_dataset))
    point = data.rows["point"].iloc[0]
    belt = data.results.profiles["belt"]
    belt["velocity_profile"].loc[{"run": point, "replicate": 1, "slice": 2}] = np.nan
    table = profiles(data)
    means = table[table["point"] == point]["x"].to_numpy()
    assert list(np.flatnonzero(np.isnan(means))) == [2]


def test_a_profile_ends_where_it_is_too_thin(belt_dataset):
    data = data_of_figure("gallas_2a", load_results(belt_dataset))
    point = data.rows["point"].iloc[0]
    density = data.results.profiles["belt"]["number_density"]
    for place, factor in ((20, 1.01), (25, 0.99)):
        density.loc[{"run": point, "slice": place}] = factor * THIN / data.rows["diameter"][0] ** 2
    table = profiles(data)
    assert table[table["point"] == point]["height"].max() == pytest.approx(20.5)
