"""Pictures of sensitivities and calibrations: what is drawn, tabled and said of answers."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from tests.figures.drawing import notes, picture, table
from tests.figures.test_plot_texts import shown_texts
from tests.made.answers import picture_data, write_calibration, write_effects, write_indices
from tests.surrogates.predictors import ANGLES, RANGES


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("answers")
    write_indices(folder)
    write_effects(folder)
    write_calibration(folder)
    (folder / "none").mkdir()
    write_calibration(folder / "none", shift=3.0)
    return folder


def drawn(folder, kind, answer):
    data = picture_data(folder, kind, answer)
    return picture(data), table(data), notes(data)


def test_indices_are_bars_with_the_largest_total_on_top(folder):
    figure, rows, caption = drawn(folder, "indices", "indices.csv")
    labels = [text.get_text() for text in figure.axes[0].get_yticklabels()]
    assert labels == ["angle θ", "friction μ", "restitution e"]
    assert len(figure.axes[0].patches) == 6 and len(rows) == 7
    lengths = [bar.get_width() for bar in figure.axes[0].patches]
    assert lengths == pytest.approx(
        [rows.set_index(["index", "parameter"])["value [1]"][index, name]
         for index in ("first", "total") for name in ("angle", "friction", "restitution")]
    )  # fmt: skip
    assert "First-order indices sum to 0.9" in caption and "surrogate's error" in caption


def test_interactions_are_bars_of_pairs(folder):
    figure, rows, caption = drawn(folder, "interactions", "indices.csv")
    assert len(figure.axes[0].patches) == len(rows) == 3
    assert "friction μ × angle θ" in shown_texts(figure)
    assert "beyond what each explains alone" in caption


def test_a_screening_shows_lost_trajectories(folder):
    figure, rows, caption = drawn(folder, "screening", "effects.csv")
    assert {"friction μ", "restitution e", "angle θ", "σ = μ*"} <= shown_texts(figure)
    assert "value [m s-1]" in rows and "Left out: 2 of 12 trajectories" in caption


def test_a_posterior_has_a_histogram_for_each_parameter_and_regions_of_the_pair(folder):
    figure, rows, caption = drawn(folder, "posterior", "calibration.nc")
    panels = [axes for axes in figure.axes if axes.get_visible()]
    assert len(panels) == 3 and len(panels[1].collections) == 1
    for axes, name in ((panels[0], "friction"), (panels[2], "restitution")):
        assert axes.get_xlim() == RANGES[name]
        assert sum(bar.get_height() for bar in axes.patches) == pytest.approx(30)
    assert rows["parameter"].tolist() == [*RANGES, "discrepancy"]
    assert "friction = " in caption and "half-normal of scale" in caption


def test_predictions_stand_beside_measurements(folder):
    figure, rows, caption = drawn(folder, "predictions", "calibration.nc")
    assert {"measured", "calibrated"} <= shown_texts(figure)
    assert figure.axes[0].get_xlabel().startswith("angle θ")
    assert rows["angle"].tolist() == ANGLES.tolist()
    low, high = (rows.filter(regex=f"^{end}").iloc[:, 0] for end in ("lower", "upper"))
    assert (low < rows["measured [m s-1]"]).all() and (rows["measured [m s-1]"] < high).all()
    assert "the same measurement made again" in caption


def test_the_next_experiment_is_marked(folder):
    figure, rows, caption = drawn(folder, "experiment", "calibration.nc")
    best = rows.loc[rows["variance taken away [1]"].idxmax()]
    (star,) = [line for line in figure.axes[0].lines if line.get_marker() == "*"]
    assert star.get_xdata() == pytest.approx([best["angle [degree]"]])
    assert f"It tells most at θ = {best['angle [degree]']:.3g}°" in caption


@pytest.mark.parametrize("kind", ["posterior", "experiment", "predictions"])
def test_what_fits_nowhere_is_said_in_place_of_a_posterior(folder, kind):
    figure, rows, caption = drawn(folder / "none", kind, "calibration.nc")
    assert "No parameters in the ranges fit: " in caption and isinstance(rows, pd.DataFrame)
    if kind == "predictions":
        assert "those that come nearest" in caption and len(rows) == len(ANGLES)
    else:
        assert "no parameters in the ranges fit" in [t.get_text() for t in figure.axes[0].texts]
        assert rows["outcome"].tolist() == ["no fit"] and np.isfinite(rows["probability [1]"]).all()
