"""Rounds add points of the design until a surrogate is exact enough or its budget is spent."""

from pathlib import Path

import numpy as np
import pytest

from sim.base.errors import InputError
from sim.dataset.build import build
from sim.dataset.results import load_current, load_results
from sim.dataset.rounds import points_of_rounds, read_round, round_files, rounds_to_come
from sim.report.results import load
from sim.report.status import as_text, survey
from sim.study.load import load_study
from sim.surrogates import inquiries
from sim.surrogates.inquiries import write_round
from tests.made.runs import write_run

STUDY = """\
study: made
series:
  - name: wide
    system: chute
    base: {replicates: 3}
    design:
      kind: sobol
      points: 8
      seed: 1
      over: {friction: [0.3, 0.6], depth: [2, 10]}
surrogate:
  - {name: speed, series: wide, error: ERROR, budget: BUDGET, batch: 4}
"""


def velocity(parameters) -> float:
    """Return the made-up velocity, m/s: it bends too much to be known from eight points."""
    return float(2 + np.sin(14 * parameters.friction) + 0.01 * parameters.depth**2)


def write_study(folder: Path, error: float = 0.02, budget: float = 1e5) -> Path:
    path = folder / "made.yaml"
    path.write_text(STUDY.replace("ERROR", str(error)).replace("BUDGET", str(budget)))
    return path


def run_points(points, runs: Path) -> None:
    for parameters in points:
        write_run(runs, parameters, velocity(parameters) * np.array([0.999, 1, 1.001]))


def go_on(path: Path, results: Path) -> int:
    """Run rounds until one adds nothing; return their number."""
    study = load_study(path, results)
    runs = results / study.name / "runs"
    run_points([point.parameters for point in study.points.values()], runs)
    for number in range(1, 30):
        added = read_round(write_round(path, number, results))
        if not added:
            return number
        run_points(added.values(), runs)
    raise AssertionError("rounds did not end")


@pytest.fixture(scope="module")
def ended(tmp_path_factory):
    """A study whose rounds have ended, with its dataset and its surrogate."""
    folder = tmp_path_factory.mktemp("rounds")
    path, results = write_study(folder), folder / "results"
    number = go_on(path, results)
    build(path, results)
    lines = inquiries.build(path, results)
    return path, results, number, lines


def test_rounds_end_at_the_error(ended):
    path, results, number, lines = ended
    folder = results / "made"
    study = load_study(path, results)
    count = len(points_of_rounds(study, folder))
    assert number > 1 and count == 8 + 4 * (number - 1)
    assert rounds_to_come(study, folder) == 0 and len(round_files(study, folder)) == number
    surrogate = load(folder).surrogate("velocity")
    assert surrogate.error <= 0.02 and len(surrogate.process.y) == count
    assert lines[0].startswith(f"surrogate speed: {count} points, error ")
    middle = study.points[study.series["wide"][0]].parameters.model_copy(
        update={"friction": 0.45, "depth": 6.0}
    )
    predicted = surrogate(friction=0.45, depth=6.0)
    assert float(predicted["mean"]) == pytest.approx(velocity(middle), rel=0.04)


def test_points_of_rounds_are_those_that_more_points_would_have(ended):
    path, results, number, _ = ended
    larger = path.with_name("larger.yaml")
    larger.write_text(path.read_text().replace("points: 8", f"points: {8 + 4 * (number - 1)}"))
    known = points_of_rounds(load_study(path, results), results / "made")
    assert set(load_study(larger, results).points) == set(known)


def test_dataset_and_status_know_the_points_of_rounds(ended):
    path, results, number, lines = ended
    study, folder = load_study(path, results), results / "made"
    dataset = load_results(folder / "dataset.nc").dataset
    assert dataset.sizes["point"] == 8 + 4 * (number - 1)
    assert set(dataset["series"].values) == {"wide"}
    assert dataset["point"].values.tolist()[:8] == list(study.points)
    load_current(study, folder)
    status = survey(study, results)
    assert status.is_over and not status.orphans and status.counts["done"] == dataset.sizes["point"]
    assert as_text(status).endswith(lines[0])


def test_a_smaller_error_goes_on_and_a_larger_one_leaves_orphans(ended, tmp_path):
    path, results, number, _ = ended
    first = (results / "made" / "rounds" / "1.json").read_bytes()
    assert write_round(path, 1, results).read_bytes() == first
    finer = write_study(tmp_path, error=0.0001)
    assert len(read_round(write_round(finer, number, results))) == 4
    study = load_study(finer, results)
    assert rounds_to_come(study, results / "made") == 1
    coarse = write_study(tmp_path, error=1)
    assert read_round(write_round(coarse, 1, results)) == {}
    status = survey(load_study(coarse, results), results)
    assert status.rounds_left == 0 and len(status.orphans) == 4 * (number - 1)
    write_round(path, 1, results), write_round(path, number, results)


def test_a_budget_ends_rounds(ended, tmp_path):
    """The first eight points have taken an hour for each part of 0.8 that is left."""
    path, results, number, _ = ended
    dataset = load_results(results / "made" / "dataset.nc").dataset
    hours = float(dataset["wall_time"][:8].sum()) / 3600
    cheap = write_study(tmp_path, error=0.0001, budget=0.8 * hours)
    added = [len(read_round(write_round(cheap, one, results))) for one in (1, 2, 3)]
    assert added[0] == 4 and added[1] < 4 and added[2] == 0 and number > 2
    for one in range(1, number + 1):
        write_round(path, one, results)


def test_rounds_buy_what_a_mean_lacks(tmp_path):
    path, results = write_study(tmp_path, error=0.5), tmp_path / "results"
    path.write_text(path.read_text().replace("points: 8", "points: 2"))
    points = [point.parameters for point in load_study(path, results).points.values()]
    run_points(points, results / "made" / "runs")
    build(path, results)
    (line,) = inquiries.build(path, results)
    assert line.startswith("surrogate speed: no mean, as 2 of 2 points of series wide count")
    assert go_on(path, results) > 1
    build(path, results)
    assert ": no " not in inquiries.build(path, results)[0]
    path.write_text(path.read_text().replace(", error: 0.5, budget: 100000.0", ""))
    with pytest.raises(InputError, match="allowed: a series of 6 to 3,000 points"):
        load_study(path, results)


def test_runs_of_earlier_rounds_are_needed(tmp_path):
    path, results = write_study(tmp_path), tmp_path / "results"
    with pytest.raises(InputError, match="no such run file"):
        write_round(path, 1, results)
    study = load_study(path, results)
    run_points([point.parameters for point in study.points.values()], results / "made" / "runs")
    with pytest.raises(InputError, match="no such round of refinement"):
        write_round(path, 2, results)


BOUNDARY = """\
boundaries:
  - {name: rest, system: chute, of: flow, along: angle, range: [10, 26], tolerance: 1,
     base: {friction: 0.5}}
"""


def test_boundaries_and_surrogates_ask_in_the_same_rounds(tmp_path):
    path, results = write_study(tmp_path), tmp_path / "results"
    path.write_text(path.read_text() + BOUNDARY)
    study, runs = load_study(path, results), results / "made" / "runs"
    added = {key: point.parameters for key, point in study.points.items()}
    counts = []
    while added:
        for one in added.values():
            at_rest = one.friction == 0.5 and one.angle < 15.3
            write_run(
                runs,
                one,
                0.0 if at_rest else velocity(one) * np.linspace(0.999, 1.001, one.replicates),
                regime="arrested" if at_rest else "steady",
            )
        added = read_round(write_round(path, len(counts) + 1, results))
        counts.append(len(added))
    build(path, results)
    table = load_results(results / "made" / "dataset.nc").boundaries
    assert (table["verdict"][0], table["high"][0] - table["low"][0]) == ("found", 1)
    assert counts[0] == 4 + 3
    members = load_results(results / "made" / "dataset.nc").dataset["series"].values.tolist()
    assert members.count("wide") == 8 + 4 * (len(counts) - 1)
