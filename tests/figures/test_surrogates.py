"""Pictures of surrogates: sections, maps, predicted against run."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from sim.dataset.build import build
from sim.dataset.results import COLUMNS
from sim.figures.caption import answer_sentence
from sim.figures.data import figure_data
from sim.figures.figure_records import current_record
from sim.figures.render import find_spec, render
from sim.report.results import load
from sim.study.figure_spec import Answer, FigureSpec
from sim.study.load import load_study
from sim.study.surrogate import COUNTED
from sim.surrogates import inquiries
from tests.made.results import made_point, made_results
from tests.made.runs import write_run

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
def drawn(tmp_path_factory):
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


def test_a_section_has_the_surrogate_and_the_runs_near_it(drawn):
    folder, _ = drawn
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
    assert "Held: K1 = 1000 N/m." in caption or "Held: K1 = 1,000 N/m." in caption
    assert "another regime (arrested) is likelier than steady or mixed or undetermined." in caption


def test_a_map_covers_the_ranges_for_each_law(drawn):
    folder, _ = drawn
    rows = read(folder, "speed-friction-stiffness")
    assert len(rows) == 2 * 61**2
    assert (rows["friction [1]"].min(), rows["friction [1]"].max()) == (0.3, 0.6)
    chance = rows["probability of steady or mixed or undetermined"]
    assert (
        chance[rows["friction [1]"] < 0.4].min() > 0.5 > chance[rows["friction [1]"] > 0.58].max()
    )


def test_predicted_stands_beside_run(drawn):
    folder, _ = drawn
    rows = read(folder, "speed-agreement")
    speed = load(folder / "made").surrogate("speed")
    assert len(rows) == speed.in_mean.sum() < 16
    apart = rows["run [m s-1]"] - rows["predicted from the other runs [m s-1]"]
    assert apart.to_numpy() == pytest.approx(
        (speed.leave_one_out["run"] - speed.leave_one_out["mean"]).values, rel=1e-6
    )
    caption = (folder / "figures" / "speed-agreement.caption.txt").read_text()
    assert f"left out of it: arrested {16 - len(rows)}." in caption


def test_a_picture_is_out_of_date_once_its_surrogate_has_changed(drawn):
    folder, plots = drawn
    arguments = plots["speed-friction"], folder / "made" / "dataset.nc", folder / "figures", "code"
    before = current_record(*arguments)
    file = folder / "made" / "surrogates" / "speed.nc"
    whole = file.read_bytes()
    file.write_bytes(whole[:-1])
    after = current_record(*arguments)
    file.write_bytes(whole)
    assert before and after and before.source != after.source
    assert find_spec("speed-friction", plots).kind == "section"


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
