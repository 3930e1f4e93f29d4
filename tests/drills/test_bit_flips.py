"""One bit of a stored file changes: what is read is refused or as it was, never another number."""

import random
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from sim.base.errors import InputError
from sim.base.seals import to_sealed_json
from sim.dataset.gather import read_run
from sim.dataset.results import load_results
from sim.dataset.rounds import read_round
from sim.engine.replicate import stored_replicate
from sim.engine.run import run_point
from sim.engine.states import States
from sim.figures.pictures import RECORD_FILE, require_unchanged
from sim.parameters import canonical_values, point_id
from sim.report.claims import read_claims, require_table
from sim.study.file import QUESTIONS
from sim.study.load import (
    ExtraAmounts,
    extra_amounts_file,
    load_study,
    read_extra_amounts,
    write_extra_amounts,
)
from sim.surrogates import answers, storage
from tests.engine_motion.points import belt_point
from tests.made.figures import make_figures
from tests.made.report import write_claims
from tests.made.surrogates import made_surrogate

POINT = belt_point(beads=12, width=5, transient=1, average=2)


def plain(value: Any) -> Any:
    """Return what was read as numbers and words that can be compared."""
    if isinstance(value, np.ndarray):
        return value.shape, list(map(str, value.ravel()))
    if isinstance(value, dict):
        return {name: plain(part) for name, part in value.items()}
    return value


def run_values(path: Path) -> Any:
    return plain(read_run(path).values)


def state_values(run: Path) -> Any:
    found = stored_replicate(States(run, POINT), POINT, 0)
    if found is None:
        raise InputError("no states")
    kept = found.state()
    return plain({name: one for name, one in kept.items() if name != "told.seconds"})


def dataset_values(path: Path) -> Any:
    found = load_results(path)
    scalars = {name: one.values for name, one in found.dataset.variables.items()}
    profiles = {
        f"{system}.{name}": one.values
        for system, group in found.profiles.items()
        for name, one in group.variables.items()
    }
    return plain(scalars | profiles)


def surrogate_values(path: Path) -> Any:
    surrogate = storage.load_surrogate(path)
    numbers = (surrogate.process.theta, surrogate.regimes.theta, surrogate.process.y)
    return plain({str(number): values for number, values in enumerate(numbers)})


def table_values(path: Path) -> Any:
    return plain(storage.load_table(path).to_dict("list"))


def posterior_values(path: Path) -> Any:
    return {name: group.attrs for name, group in storage.load_posterior(path).items()}


#: What reads an answer, by the folder of its question.
READERS = {
    "surrogates": surrogate_values,
    "sensitivity": table_values,
    "propagation": table_values,
    "calibration": posterior_values,
}


def refusal_of(path: Path) -> Any:
    """Return a refusal, as pictures see it; without one they read an answer."""
    if text := answers.refusal_in(path):
        return text
    return READERS[path.parent.name](path)


Read = Callable[[], Any]


@pytest.fixture
def stored(tmp_path) -> dict[Path, Read]:
    """Every kind of file that is read again, each with what reads it."""
    study_path, results = make_figures(tmp_path)
    made, figures = results / "made", results / "made" / "figures"
    study = load_study(study_path, results)
    specs = study.entries.values()
    write_claims(made / "claims.json", list(study.points))
    write_extra_amounts(made, ExtraAmounts({next(iter(study.points)): {"replicates": 4.0}}, 0.5))
    run = tmp_path / f"{point_id(POINT)}.nc"
    assert run_point(POINT, run, quiet=True) == 0
    storage.save_surrogate(made_surrogate(), made / "surrogates" / "speed.nc")
    row = {"parameter": "friction", "index": "total", "value": 0.25, "doubt": ""}
    for name in ("sensitivity/matters.csv", "propagation/spread.csv"):
        answers.save_table(pd.DataFrame([row]), made / name)
    refused = [made / f"{one.folder}/none{one.ending}" for one in QUESTIONS.values()]
    for path in refused:
        answers.save_refusal(answers.Refusal("no answer, as 0 of 8 points count"), path)
    about = {"outcome": "no fit", "probability": 0.001, "uncounted": 0.0}
    groups = {"observed_data": xr.Dataset(attrs=about)}
    storage.save_posterior("beads", groups, [], made / "calibration" / "beads.nc")
    kinds = {one.folder: READERS[one.folder] for one in QUESTIONS.values()}
    answered = {path: partial(kinds[path.parent.name], path) for path in storage.answer_files(made)}
    assert {path.parent.name for path in answered.keys() - set(refused)} == set(kinds)
    (made / "rounds").mkdir()
    points = {point_id(POINT): canonical_values(POINT)}
    (made / "rounds" / "1.json").write_text(to_sealed_json(points))
    drawn = {path: lambda: require_unchanged(specs, figures) for path in figures.iterdir()}
    return drawn | {
        run: lambda: run_values(run),
        run.with_name(f".{run.name}.state"): lambda: state_values(run),
        made / "dataset.nc": lambda: dataset_values(made / "dataset.nc"),
        made / "claims.json": lambda: read_claims(made / "claims.json"),
        made / "claims.csv": lambda: require_table(made),
        extra_amounts_file(made): lambda: read_extra_amounts(made),
        **answered,
        **{path: partial(refusal_of, path) for path in refused},
        made / "rounds" / "1.json": lambda: {
            key: canonical_values(point)
            for key, point in read_round(made / "rounds" / "1.json").items()
        },
    }


@pytest.mark.parametrize("flips", [30, pytest.param(1000, marks=pytest.mark.long)])
def test_no_flipped_bit_is_served_as_a_number(stored, flips, capsys):
    chance, refused = random.Random(flips), 0
    before = {path: (path.read_bytes(), read()) for path, read in stored.items()}
    for number in range(flips):
        path = sorted(stored)[number % len(stored)]
        content, expected = before[path]
        damaged, place = bytearray(content), chance.randrange(8 * len(content))
        damaged[place // 8] ^= 1 << place % 8
        path.write_bytes(damaged)
        try:
            assert stored[path]() == expected, f"{path.name}, bit {place}"
            # Unread, as the notes on figures that another program has written between the words.
            assert path.name == RECORD_FILE, f"{path.name}, bit {place}"
        except InputError:
            refused += 1
        path.write_bytes(content)
        for aside in path.parent.glob(f"{path.name}.damaged*"):
            aside.unlink()
    with capsys.disabled():
        print(f"\n{flips} flipped bits in {len(stored)} files: {refused} refused")
    assert refused > 0.9 * flips
