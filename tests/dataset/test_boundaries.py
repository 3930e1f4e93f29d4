"""From run files to boundaries: sides of runs, points of each round, the dataset, the table."""

import csv
import json
import shutil
from math import atan, degrees, nan, pi, radians, sqrt, tan
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from sim.base.errors import InputError
from sim.base.seals import DamagedError
from sim.dataset import sources
from sim.dataset.boundaries import add_rounds, added_points, build, find_sides
from sim.dataset.build import build as build_dataset
from sim.dataset.results import load_results
from sim.dataset.rounds import read_round, side_of_run
from sim.figures.data import figure_data
from sim.figures.map import notes
from sim.figures.regimes import fit_boundaries
from sim.parameters import BeltParameters, ChuteParameters, canonical_values, point_id
from sim.study.load import load_study
from sim.surrogates.inquiries import write_round
from tests.figures.drawing import picture
from tests.made.runs import make_regimes, make_study, write_run

CHUTE = ChuteParameters(replicates=2)
BELT = BeltParameters(replicates=2, frequency=20)


UPRIGHT = BeltParameters(vibration_angle=90)


def each(value: object) -> tuple[str, np.ndarray]:
    """Return a scalar of two replicates, which may have one value."""
    values = np.broadcast_to(np.asarray(value), 2)
    return "replicate", values.astype(object) if isinstance(values[0], str) else values


#: Points with velocity (m/s), regime and other scalars, and the side of each kind of boundary.
SIDES = [
    (CHUTE, 0.0, "arrested", {}, {"flow": "arrested", "acceleration": "not accelerating"}),
    (CHUTE, 0.0, "steady", {}, {"flow": "flowing", "acceleration": "not accelerating"}),
    (CHUTE, 0.0, "accelerating", {}, {"flow": "flowing", "acceleration": "accelerating"}),
    (CHUTE, 0.0, "undetermined", {}, {"flow": None, "acceleration": None}),
    # It flows if it surely moves and does not slow down.
    (CHUTE, 0.1, "undetermined", {"acceleration": 0.0}, {"flow": "flowing", "acceleration": None}),
    (CHUTE, 0.1, "undetermined", {"acceleration": 1.0}, {"flow": "flowing", "acceleration": None}),
    (CHUTE, 0.1, "undetermined", {"acceleration": -3.0}, {"flow": None, "acceleration": None}),
    (CHUTE, 5e-4, "undetermined", {"acceleration": 0.0}, {"flow": None, "acceleration": None}),
    # Replicates must agree on the side, not on the regime.
    (
        *(CHUTE, 0.5, "steady", {"regime": ["steady", "accelerating"]}),
        {"flow": "flowing", "acceleration": None},
    ),
    # A tenth of the belt's velocity amplitude is 12.6 mm/s, the half width is 0.9 mm/s.
    (BELT, (0.03, 0.04), "undetermined", {}, {"transport": "transport"}),
    (BELT, (0.001, 0.0115), "undetermined", {}, {"transport": "no transport"}),
    (BELT, (-0.03, 0.001), "undetermined", {}, {"transport": "no transport"}),
    (BELT, (0.012, 0.013), "undetermined", {}, {"transport": None}),
    (BELT, (0.001, 0.03), "undetermined", {}, {"transport": None}),
    (BELT, 0.03, "steady", {"velocity_half_width": nan}, {"transport": None}),
    # A belt that shakes upright moves nothing along.
    (UPRIGHT, 0.0, "steady", {}, {"transport": "no transport"}),
]


@pytest.mark.parametrize(("point", "velocity", "regime", "scalars", "sides"), SIDES)
def test_the_side_of_a_run(point, velocity, regime, scalars, sides, tmp_path):
    arrays = {name: each(value) for name, value in scalars.items()}
    path = write_run(tmp_path, point, velocity, regime=regime, arrays=arrays)
    assert {of: side_of_run(path, of, point) for of in sides} == sides


@pytest.fixture(scope="module")
def study_results(tmp_path_factory) -> tuple[Path, Path]:
    return make_regimes(tmp_path_factory.mktemp("made"))


@pytest.fixture(scope="module")
def dataset(study_results) -> Path:
    return build_dataset(*study_results)


@pytest.fixture(scope="module")
def rows(study_results, dataset) -> dict[tuple, dict]:
    with build(*study_results).open(newline="") as file:
        rows = list(csv.DictReader(file))
    return {(row["name"], row["depth"] or row["amplitude"]): row for row in rows}


def test_boundaries_are_where_they_were_put(rows):
    expected = {
        ("acceleration-friction", "5"): tan(radians(17)),
        ("flow-friction", "5"): 2 * (tan(radians(17)) - 0.05),
        ("acceleration-depth", ""): 1,
        ("acceleration-angle", "5"): degrees(atan(0.4)),
        ("flow-angle", "5"): degrees(atan(0.25)),
        ("onset", "0.5"): sqrt(10 / 0.5e-3) / (2 * pi),
        ("onset", "1"): sqrt(10 / 1e-3) / (2 * pi),
    }
    for key, boundary in expected.items():
        row = rows[key]
        assert row["verdict"] == "found"
        assert float(row["low"]) <= boundary <= float(row["high"])


def test_rows_say_what_lies_on_either_side(rows):
    row = rows["flow-angle", "20"]
    assert (row["of"], row["along"], row["unit"]) == ("flow", "angle", "degree")
    assert (row["below"], row["above"]) == ("arrested", "flowing")
    assert rows["onset", "1"]["points"] == "11"
    assert rows["onset", "1"]["unit"] == "Hz"


def test_the_dataset_has_the_points_of_all_rounds(study_results, dataset):
    study_path, results = study_results
    runs = results / "regimes" / "runs"
    with xr.open_dataset(dataset) as opened:
        points = set(opened["point"].values)
        onset = opened.isel(point=opened["series"].values == "onset")
        assert set(onset["figures"].values) == {"belt_onset"}
        assert onset.sizes["point"] == 22
    assert points == {path.stem for path in runs.glob("*.nc")}
    assert len(load_results(dataset).boundaries) == len(load_study(study_path, results).boundaries)
    study = load_study(study_path, results)
    study = add_rounds(study, find_sides(study, runs))
    assert set(study.series["onset"]) <= set(study.figures["belt_onset"]) <= points


def test_no_round_is_read_again_for_the_next_dataset(study_results, dataset, monkeypatch):
    whole = dataset.read_bytes()
    monkeypatch.setattr(sources, "read_run", None)
    assert build_dataset(*study_results).read_bytes() == whole


def test_a_round_is_read_where_none_of_its_numbers_has_changed(study_results, tmp_path):
    path = tmp_path / "1.json"
    text = write_round(study_results[0], 1, study_results[1]).read_text()
    mappings = json.loads(text)
    del mappings["sha256"]
    path.write_text(json.dumps(mappings))
    # Without a checksum, as earlier versions wrote it.
    assert {key: canonical_values(one) for key, one in read_round(path).items()} == mappings
    # No part of the ids of points.
    assert '"target":0.02' in text
    path.write_text(text.replace('"target":0.02', '"target":0.42', 1))
    with pytest.raises(DamagedError, match="the checksum is wrong"):
        read_round(path)


def test_a_round_follows_from_the_runs_before_it(study_results, tmp_path):
    study_path, results = study_results
    study = load_study(study_path, results)
    runs = tmp_path / "runs"
    shutil.copytree(results / "regimes" / "runs", runs)
    second = added_points(study, 2, runs)
    for key in second:
        (runs / f"{key}.nc").unlink()
    assert added_points(study, 2, runs) == second
    first = added_points(study, 1, runs)
    key, parameters = next((key, one) for key, one in first.items() if one.system == "belt")
    write_run(runs, parameters, 0.0 if parameters.frequency > 24 else 0.05)
    assert set(added_points(study, 2, runs)) != set(second)
    for key in first:
        (runs / f"{key}.nc").write_bytes(b"")
    with pytest.raises(InputError, match=r"rerun the study, .* \(and \d more\)$"):
        added_points(study, 2, runs)
    assert sum((runs / f"{key}.nc.damaged").exists() for key in first) > 1


@pytest.mark.parametrize("number", [0, 3])
def test_a_round_that_the_study_has_not_is_refused(number, study_results):
    with pytest.raises(InputError, match=f"ROUND: got {number}; allowed: .* 1 to 2"):
        write_round(study_results[0], number, study_results[1])


#: Depths of flows that are slowed down, and the angle below which each comes to rest.
STOPS = {depth: 23 * depth**-0.15 for depth in (2, 4, 8)}
STOPPED = """
study: stop
boundaries:
  - {name: stop, kind: stop, system: chute, along: angle, range: [15, 25], tolerance: 0.5,
     base: {bumps: 1, replicates: 2}, grid: {depth: [2, 4, 8]}}
plots: [{name: stops, kind: map, x: angle, y: depth, fit: power}]
"""


def test_a_flow_is_slowed_down_from_one_state_until_it_rests(tmp_path):
    path = tmp_path / "stop.yaml"
    path.write_text(STOPPED)
    study = load_study(path, tmp_path)
    points = [point.parameters for point in study.points.values()]
    flowing = {point.depth: point_id(point) for point in points if point.angle == 25}
    assert flowing.keys() == STOPS.keys()
    for number in range(study.rounds + 1):
        if number:
            points = list(added_points(study, number, tmp_path / "stop" / "runs").values())
        for point in points:
            assert point.start_from == ("" if point.angle == 25 else flowing[point.depth])
            rests = point.angle < STOPS[point.depth]
            velocity, regime = (0.0, "arrested") if rests else (0.2, "steady")
            write_run(tmp_path / "stop" / "runs", point, velocity, regime=regime)
    dataset = build_dataset(path, tmp_path)
    rows = load_results(dataset).boundaries
    assert set(rows["verdict"]) == {"found"} and list(rows["depth"]) == list(STOPS)
    assert set(rows["below"]) == {"arrested"} and set(rows["above"]) == {"flowing"}
    found = np.array([rows["low"], rows["high"]])
    stops = np.array([*STOPS.values()])
    assert (found[0] <= stops).all() and (stops <= found[1]).all()
    assert (np.diff(found, axis=0) <= 0.5).all()
    data = figure_data(load_results(dataset), study.plots["stops"])
    (fit,) = fit_boundaries(data)
    assert fit.numbers["b"][0] == pytest.approx(-1 / 0.15, rel=0.15)
    (line,) = (line for line in picture(data).axes[0].lines if line.get_label() == "power law")
    assert list(line.get_xdata()) == list(fit.line.index)
    assert "power law y = a xᵇ, least squares" in " ".join(notes(data))


def test_a_study_without_boundaries_has_no_table(tmp_path):
    study_path, results = make_study(tmp_path)
    assert load_results(build_dataset(study_path, results)).boundaries.empty
    with pytest.raises(InputError, match="boundaries: got nothing"):
        build(study_path, results)
    with pytest.raises(InputError, match=r"ROUND: got 1; allowed: none"):
        write_round(study_path, 1, results)
