"""What is published: its verdicts follow from its dataset, and its flows can be had again."""

import json
from pathlib import Path

import numpy as np
import pytest

from sim.claims.judge import as_mapping, judge
from sim.cost import estimate
from sim.gathered import read_run
from sim.outcome import outcome
from sim.parameters import SYSTEMS, parse_point, point_id
from sim.publish import LARGEST, PUBLISHED, size
from sim.results import load_results
from sim.run import run_point

ROOT = Path(__file__).parents[1]
STUDIES = sorted(path.parent for path in (ROOT / PUBLISHED).glob("*/dataset.nc"))

#: Points of each study that are computed anew, and the longest time (s) that one may take.
SAMPLED, LONGEST = 12, 60.0


def name(folder: Path) -> str:
    return folder.name


def test_what_is_published_is_small():
    assert sum(map(size, STUDIES)) <= LARGEST


@pytest.mark.parametrize("study", STUDIES, ids=name)
def test_verdicts_follow_from_the_dataset(study):
    published = json.loads((study / "claims.json").read_text(encoding="utf-8"))
    again = as_mapping(judge(load_results(study / "dataset.nc")), published["study"])
    verdicts = [
        {one["id"]: one["verdict"] for one in each["claims"]} for each in (published, again)
    ]
    assert verdicts[0] == verdicts[1]


@pytest.mark.long
@pytest.mark.parametrize("study", STUDIES, ids=name)
def test_flows_computed_anew_from_other_beds_agree(study, tmp_path):
    """Velocities differ by no more than the intervals of both allow."""
    dataset = load_results(study / "dataset.nc").dataset
    steady = np.flatnonzero(dataset["point_regime"].values == "steady")
    deviations = []
    for index in np.random.default_rng(1).permutation(steady):
        row = dataset.isel(point=int(index))
        parameters = anew(row)
        if estimate(parameters).core_seconds > LONGEST or parameters.replicates < 2:
            continue
        path = tmp_path / f"{point_id(parameters)}.nc"
        assert run_point(parameters, path, quiet=True) == 0
        before, after = outcome(row), outcome(read_run(path).scalars)
        allowed = np.hypot(before["half_width"], after["half_width"])
        deviations.append(abs(after["velocity"] - before["velocity"]) / allowed)
        if len(deviations) == SAMPLED:
            break
    assert len(deviations) >= 4
    assert np.max(deviations) < 2.5 and np.median(deviations) < 1, deviations


def anew(row) -> object:
    """Return the parameters of a point with other initial states."""
    system = str(row["system"].values)
    values = {"system": system}
    for parameter, field in SYSTEMS[system].model_fields.items():
        value = row[parameter].values.item()
        values[parameter] = field.annotation(value) if field.annotation in (int, bool) else value
    return parse_point(values | {"seed": values["seed"] + 1000}, "published")
