"""Pictures of answers: what is drawn, tabled and said of surrogates and of what rests on them."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from sim.dataset.build import build
from sim.dataset.results import COLUMNS
from sim.figures.caption import answer_sentence
from sim.figures.data import figure_data
from sim.figures.pictures import current_record
from sim.figures.render import render
from sim.report.results import load
from sim.study.figure_spec import Answer, FigureSpec
from sim.study.load import load_study
from sim.study.surrogate import COUNTED
from sim.surrogates import inquiries
from sim.surrogates.propagation import spread_of_runs
from tests.figures.drawing import notes, picture, table
from tests.figures.test_plot_texts import shown_texts
from tests.made.answers import picture_data, write_calibration, write_effects, write_indices
from tests.made.results import made_point, made_results
from tests.made.runs import write_run
from tests.made.surrogates import made_runs
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
    values = rows.set_index(["index", "parameter"])["value [1]"]
    names = ("angle", "friction", "restitution")
    assert lengths == [values[index, name] for index in ("first", "total") for name in names]
    assert "First-order indices sum to 0.9" in caption and "surrogate's error" in caption


def test_interactions_are_bars_of_pairs_and_a_screening_shows_lost_trajectories(folder):
    figure, rows, _ = drawn(folder, "interactions", "indices.csv")
    assert len(figure.axes[0].patches) == len(rows) == 3
    assert "friction μ × angle θ" in shown_texts(figure)
    figure, rows, caption = drawn(folder, "screening", "effects.csv")
    assert {"friction μ", "restitution e", "angle θ", "σ = μ*"} <= shown_texts(figure)
    assert "value [m s-1]" in rows and "Left out: 2 of 12 trajectories" in caption


def test_a_spread_has_quantiles_and_probabilities_that_exist(folder):
    runs = made_runs(lambda x: 1 + x[:, 0], "morris", 25)[0]
    spread_of_runs(runs, (0.5, 0.999), (1.5,)).to_csv(folder / "spread.csv", index=False)
    figure, rows, caption = drawn(folder, "spread", "spread.csv")
    assert list(rows["unit"]) == ["m s-1"] * 4 + ["1"] and rows["value"].isna().sum() == 1
    points = [line.get_xydata() for line in figure.axes[0].lines if line.get_marker() in "os"]
    (quantiles, (chance,)) = points
    assert quantiles[0] == pytest.approx([rows["value"][2], 0.5])
    assert chance == pytest.approx([1.5, 1 - rows["value"][4]])
    assert "probability above 1.5: 0." in caption and "the 100 runs for independent" in caption


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


# Surrogates.

STUDY = """\
study: made
series:
  - name: wide
    system: chute
    base: {replicates: 3}
    design:
      kind: sobol
      points: 16
      over:
        friction: [0.3, 0.6]
        stiffness: {between: [100, 10000], scale: log}
        law: {choices: [walton_braun, hertz]}
surrogate: [{name: speed, series: wide}]
"""


@pytest.fixture(scope="module")
def pictures(tmp_path_factory):
    """A study with a surrogate, all of whose pictures are drawn; its folder and its entries."""
    folder = tmp_path_factory.mktemp("pictures")
    path = folder / "made.yaml"
    path.write_text(STUDY)
    study = load_study(path, folder)
    for number, point in enumerate(study.points.values()):
        parameters = point.parameters
        velocity = 3 * (0.7 - parameters.friction) + 0.1 * np.log10(parameters.stiffness)
        regime = "arrested" if parameters.friction > 0.5 else "steady"
        values = velocity * np.array([0.98, 1, 1.02]) * (1 + 0.01 * (-1) ** number)
        write_run(folder / "made" / "runs", parameters, values, regime=regime)
    build(path, folder)
    inquiries.build(path, folder)
    for spec in study.plots.values():
        render(spec, folder / "made" / "dataset.nc", folder / "figures")
    return folder, study.plots


def read(folder, name):
    return pd.read_csv(folder / "figures" / f"{name}.csv")


def test_a_section_has_the_surrogate_and_the_runs_near_it(pictures):
    folder, _ = pictures
    rows = read(folder, "speed-friction")
    curve, runs = (rows[rows["of"] == one] for one in ("surrogate", "run"))
    assert set(curve["law"]) == {"walton_braun", "hertz"} and len(curve) == 2 * 161
    held = curve["stiffness [N m-1]"].unique()
    assert held == [1000]
    speed = load(folder / "made").surrogate("speed")
    place = curve[(curve["law"] == "hertz")].iloc[40]
    answer = speed(friction=place["friction [1]"], stiffness=1000, law="hertz")
    assert place["mean [m s-1]"] == pytest.approx(float(answer["mean"]), rel=1e-6)
    assert place["half width of 95 % interval [m s-1]"] == pytest.approx(
        float(answer["half_width"]), rel=1e-6
    )
    assert 0 < len(runs) < 16 and (runs["friction [1]"] <= 0.5).all()
    caption = (folder / "figures" / "speed-friction.caption.txt").read_text()
    assert "Held: K1 = " in caption
    assert "another regime (arrested) is likelier than steady or mixed or undetermined." in caption


def test_a_map_covers_the_ranges_for_each_law(pictures):
    folder, _ = pictures
    rows = read(folder, "speed-friction-stiffness")
    assert len(rows) == 2 * 61**2
    friction, chance = rows["friction [1]"], rows["probability of steady or mixed or undetermined"]
    assert (friction.min(), friction.max()) == (0.3, 0.6)
    assert chance[friction < 0.4].min() > 0.5 > chance[friction > 0.58].max()


def test_predicted_stands_beside_run(pictures):
    folder, _ = pictures
    rows = read(folder, "speed-agreement")
    speed = load(folder / "made").surrogate("speed")
    assert len(rows) == speed.in_mean.sum() < 16
    apart = rows["run [m s-1]"] - rows["predicted from the other runs [m s-1]"]
    assert apart.to_numpy() == pytest.approx(
        (speed.leave_one_out["run"] - speed.leave_one_out["mean"]).values, rel=1e-6
    )
    caption = (folder / "figures" / "speed-agreement.caption.txt").read_text()
    assert f"left out of it: arrested {16 - len(rows)}." in caption


def test_a_picture_is_out_of_date_once_its_surrogate_has_changed(pictures):
    folder, plots = pictures
    arguments = plots["speed-friction"], folder / "made" / "dataset.nc", folder / "figures", "code"
    before = current_record(*arguments)
    file = folder / "made" / "surrogates" / "speed.nc"
    whole = file.read_bytes()
    file.write_bytes(whole[:-1])
    after = current_record(*arguments)
    file.write_bytes(whole)
    assert before and after and before.source != after.source


def test_what_is_no_part_of_an_answer_is_counted_by_what_it_lacks():
    """A flow of a regime that counts, without the observable, is no part of the answer."""

    def flow(friction, depth, regime="steady", slope=0.0):
        scalars = {"velocity": 1.0, "shear_depth": depth, "regime": regime, "acceleration": slope}
        scalars |= {"acceleration_half_width": 0.01, "independent_samples": 2.0}
        return made_point("chute", scalars, friction=friction, replicates=1)

    points = [
        flow(0.30, 1.0, "undetermined"),
        flow(0.31, np.nan, "undetermined"),
        flow(0.32, np.nan, "arrested"),
        flow(0.33, 1.0, "arrested"),
        flow(0.34, 1.0, "undetermined", slope=-1.0),
    ]
    made = made_results(*points)
    names = ("point", np.full(len(points), "flows", object))
    table = pd.DataFrame(columns=COLUMNS)
    results = replace(made, dataset=made.dataset.assign_coords(series=names), boundaries=table)
    answer = Answer("one.nc", "shear_depth", regimes=COUNTED)
    spec = FigureSpec.model_construct(
        name="one", kind="section", system="chute", series=["flows"], answer=answer
    )
    assert answer_sentence(figure_data(results, spec)) == (
        "In the answer: too short to tell 1; left out of it: without a value 2, arrested 1, "
        "slowing 1."
    )
