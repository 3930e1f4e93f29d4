"""Height of the shearing layer: a curve per material, error bars, lines, data and caption."""

from dataclasses import replace

import pandas as pd
import pytest
import xarray as xr
from matplotlib.markers import CARETDOWN, CARETUP

from sim.base.errors import InputError
from sim.base.statistics import student_half_width
from sim.figures.quantity import quantities
from tests.figures.drawing import data_of_figure, draw, picture
from tests.figures.made_chute import SPREAD
from tests.made.netcdf import store


@pytest.fixture(scope="module")
def data(chute_dataset):
    return data_of_figure("shear_depth", chute_dataset)


def test_every_material_is_a_curve_over_the_depths(data):
    axes = picture(data).axes[0]
    labels = {line.get_label() for line in axes.get_lines() if "=" in line.get_label()}
    assert labels == {
        "e = 0.7, K1 = 100 N/m",
        "e = 0.85, K1 = 100 N/m",
        "e = 0.85, K1 = 1000 N/m",
    }
    curve = max(axes.get_lines(), key=lambda line: len(line.get_xdata()))
    assert list(curve.get_xdata()) == [1.24, 2.5, 5, 10, 20, 40]
    assert list(curve.get_ydata()) == pytest.approx([10 / depth for depth in curve.get_xdata()])


def test_heights_have_students_interval_over_replicates(data):
    (heights,) = quantities(data)
    assert heights.name == "shear_depth"
    rows = data.rows.assign(half_width=heights.half_width)
    rows = rows.set_index(["restitution", "stiffness", "depth"])
    several, single = rows.loc[(0.85, 100, 5)], rows.loc[(0.7, 100, 5)]
    assert several["half_width"] == pytest.approx(student_half_width(2 * (1 + SPREAD)))
    assert pd.isna(single["half_width"])


def test_an_interval_wider_than_the_axes_ends_in_carets(data):
    dataset = data.results.dataset.copy(deep=True)
    deep = (dataset["depth"] == 20).values
    dataset["shear_depth"].values[deep, :2] = 1e-3, 9e-3
    wide = replace(data, results=replace(data.results, dataset=dataset))
    axes = picture(wide).axes[0]
    carets = [line for line in axes.get_lines() if line.get_marker() in (CARETUP, CARETDOWN)]
    bottom, top = axes.get_ylim()
    places = {(line.get_xdata()[0], line.get_ydata()[0]) for line in carets}
    assert places == {(20, bottom), (20, top)}


def test_files_tell_units_and_the_claims(chute_dataset, tmp_path):
    draw("shear_depth", chute_dataset, tmp_path)
    table = pd.read_csv(tmp_path / "shear_depth.csv")
    assert {"height of the shearing layer [σ]", "half width of 95 % interval [σ]"} <= set(table)
    caption = (tmp_path / "shear_depth.caption.txt").read_text()
    assert "Error bars: Student's 95 % interval" in caption
    assert "more elastic spheres have a deeper shearing layer" in caption


def test_a_dataset_without_the_measure_is_refused(chute_dataset, tmp_path):
    with xr.open_dataset(chute_dataset) as opened:
        store(opened.load().drop_vars("shear_depth"), tmp_path / "dataset.nc")
    with pytest.raises(InputError, match="shear_depth"):
        draw("shear_depth", tmp_path / "dataset.nc", tmp_path)
