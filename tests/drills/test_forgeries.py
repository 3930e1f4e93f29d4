"""Files whose seal is right and whose numbers are not: one line, or finite answers."""

import json
import os
import random
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from sim.base.errors import InputError
from sim.base.seals import append_summary, seal
from sim.figures.render import drawing_of, kind_of_answer
from sim.surrogates import answers, storage
from sim.surrogates.answers import Refusal, refusal_in, save_refusal
from sim.surrogates.posterior import calibrate, summarize
from sim.surrogates.storage import outcome_sentences
from tests.made.answers import picture_data, write_indices
from tests.made.netcdf import store
from tests.made.surrogates import AXES, made_surrogate
from tests.surrogates.made_calibration import made_measurements

SEED = int(os.environ.get("TALUS_DRILL_SEED", "1"))

#: What takes the place of a value of JSON or of an attribute.
WRONG = (None, True, 0, -1, 1e308, float("nan"), "", "x", [], [1], ["a", 2, None], {}, {"low": []})

#: What takes the place of numbers.
NUMBERS = (np.nan, np.inf, -np.inf, 0.0, -1.0, 1e308, 1e-320)


def forged_value(value: Any, chance: random.Random) -> Any:
    """Return a value of JSON with one part that is wrong or gone."""
    if isinstance(value, (dict, list)) and value and chance.random() < 0.8:
        key = chance.choice(list(value) if isinstance(value, dict) else range(len(value)))
        copy = value.copy()
        if chance.random() < 0.2:
            del copy[key]
        else:
            copy[key] = forged_value(copy[key], chance)
        return copy
    return chance.choice(WRONG)


def forged(file: xr.Dataset, chance: random.Random) -> xr.Dataset:
    """Return a dataset with one variable, dimension or attribute that is wrong or gone."""
    name = chance.choice([*file.variables, *file.attrs])
    if name in file.attrs:
        value = file.attrs[name]
        if name == "about":
            value = json.dumps(forged_value(json.loads(value), chance))
        else:
            value = chance.choice([1e308, "x", "", -1, [1.0, 2.0]])
        return file.assign_attrs({name: value})
    variable, what = file[name], chance.randrange(4)
    if what == 0:
        return file.drop_vars(name)
    if what == 1 and variable.dims:
        return file.isel({chance.choice(variable.dims): slice(0, chance.choice((0, 1, 2)))})
    if what == 2 or variable.dtype.kind not in "fi":
        other = np.full(variable.shape, chance.choice(("", "x", "2")), object)
        return file.assign({name: (variable.dims, other)})
    values = variable.values.astype(float)
    if values.size:
        values.flat[chance.randrange(values.size) :: chance.choice((1, 1000))] = chance.choice(
            NUMBERS
        )
    return file.assign({name: (variable.dims, values)})


def answers_of_surrogate(path: Path) -> list[np.ndarray]:
    surrogate = storage.load_surrogate(path)
    middle = {axis.name: (axis.low + axis.high) / 2 for axis in surrogate.numeric}
    answer = surrogate(**middle)
    assert isinstance(f"{surrogate.name} {surrogate.omissions}", str)
    return [answer[name].values for name in ("mean", "half_width", "probability")]


def answers_of_calibration(path: Path) -> list[np.ndarray]:
    groups = storage.load_posterior(path)
    assert all(isinstance(sentence, str) for sentence in outcome_sentences(groups))
    return [summarize(groups)[["median", "low", "high"]].to_numpy()]


def forge_surrogate(path: Path, chance: random.Random) -> None:
    with xr.open_dataset(path, engine="netcdf4") as file:
        stored = file.load()
    store(forged(stored, chance), path)


def forge_calibration(path: Path, chance: random.Random) -> None:
    groups = storage.load_posterior(path)
    name = chance.choice(list(groups))
    groups[name] = forged(groups[name], chance)
    for number, (name, group) in enumerate(groups.items()):
        group.to_netcdf(path, mode="a" if number else "w", group=name, engine="netcdf4")
    seal(path)


def forge_table(path: Path, chance: random.Random) -> None:
    table = pd.read_csv(path).astype(object)
    column, row = chance.choice(list(table.columns)), chance.randrange(len(table))
    match chance.randrange(4):
        case 0:
            table = table.drop(index=row)
        case 1:
            table = table.drop(columns=column)
        case 2:
            table = pd.concat([table, table.iloc[[row]]])
        case _:
            table.loc[row, column] = chance.choice((*NUMBERS, "", "x", "$a", "friction"))
    answers.save_table(table, path)


def answers_of_table(path: Path) -> list[np.ndarray]:
    data = picture_data(path.parent, "indices", path.name)
    kind = kind_of_answer(drawing_of("indices"), path)
    assert len(kind.table(data)) and all(isinstance(one, str) for one in kind.notes(data))
    kind.draw(data)
    # What does not vary has no index.
    return []


def forge_refusal(path: Path, chance: random.Random) -> None:
    path.unlink()
    xr.Dataset(attrs={"refusal": "x"}).to_netcdf(path, engine="netcdf4")
    append_summary(path, forged_value({"line": "x", "refusal": {"a": ["\x1b[2J"]}}, chance))
    seal(path)


def answers_of_refusal(path: Path) -> list[np.ndarray]:
    text = refusal_in(path)
    assert text.isprintable() and len(text) <= 2000
    return [] if text else answers_of_surrogate(path)


KINDS: dict[str, tuple[Callable, Callable]] = {
    "surrogate": (forge_surrogate, answers_of_surrogate),
    "calibration": (forge_calibration, answers_of_calibration),
    "indices": (forge_table, answers_of_table),
    "refusal": (forge_refusal, answers_of_refusal),
}


@pytest.fixture(scope="module")
def originals(tmp_path_factory) -> dict[str, bytes]:
    """The content of a good file of each kind."""
    folder = tmp_path_factory.mktemp("originals")
    storage.save_surrogate(made_surrogate(axes=AXES[:2]), folder / "surrogate.nc")
    groups = calibrate(made_measurements(1)[1])
    storage.save_posterior("made", groups, [], folder / "calibration.nc")
    indices = folder / write_indices(folder)
    indices.rename(folder / "indices.nc")
    save_refusal(Refusal("no answer"), folder / "refusal.nc")
    return {kind: (folder / f"{kind}.nc").read_bytes() for kind in KINDS}


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("count", [20, pytest.param(500, marks=pytest.mark.long)])
def test_a_right_seal_on_wrong_numbers_is_one_line(kind, count, originals, tmp_path):
    chance, (forge, answers) = random.Random(SEED), KINDS[kind]
    for number in range(count):
        path = tmp_path / f"{number}.nc"
        path.write_bytes(originals[kind])
        try:
            forge(path, chance)
        except (ValueError, TypeError, LookupError, RuntimeError):
            continue  # no file holds it
        content = path.read_bytes()
        try:
            given = answers(path)
        except InputError as error:
            assert "\n" not in str(error)
        except Exception:
            (tmp_path / "fell.nc").write_bytes(content)
            raise
        else:
            assert all(np.isfinite(one).all() for one in given), number
        path.unlink(missing_ok=True)
