"""Calibrations as files that ArviZ reads, and what they say in a line."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import netCDF4
import numpy as np
import xarray as xr

from sim.base.errors import percent
from sim.base.files import atomic_write
from sim.base.seals import append_summary, checked_read, seal
from sim.surrogates.caveats import KEY, caveats_of_posterior
from sim.surrogates.posterior import (
    LEAST_PROBABILITY,
    MOST_UNCOUNTED,
    at_ends,
    ridges,
    summarize,
)
from sim.surrogates.refusals import require_answer


def save(name: str, groups: Mapping[str, xr.Dataset], caveats: Sequence[str], path: Path) -> None:
    """Write the groups of a calibration; the file appears complete or not at all.

    Its end has a line with what it says, and what is doubtful about that; ``caveats`` are those of
    the surrogate.
    """
    caveats = [*caveats_of_posterior(groups["observed_data"].attrs, at_ends(groups)), *caveats]
    line = f"calibration {name}: {' '.join(outcome_sentences(groups))}"
    path.parent.mkdir(parents=True, exist_ok=True)
    with atomic_write(path) as temporary:
        for number, (key, group) in enumerate(groups.items()):
            group.to_netcdf(temporary, mode="a" if number else "w", group=key, engine="netcdf4")
        append_summary(temporary, {"line": line, KEY: caveats})
        seal(temporary)


def load(path: Path) -> dict[str, xr.Dataset]:
    """Read the groups of a calibration.

    Raises
    ------
    InputError
        When there is no such file, or it is damaged. In the results of a study it is then set
        aside, so that the study makes it again.
    Refusal
        When its surrogate was refused.
    """
    is_of_study = (path.parent.parent / "runs").is_dir()
    with checked_read(path, "calibration", replaceable=is_of_study, sealed=True):
        require_answer(path)
        with netCDF4.Dataset(path) as file:
            names = list(file.groups)
        groups = {}
        for name in names:
            with xr.open_dataset(path, group=name, engine="netcdf4") as group:
                groups[name] = group.load()
        # A file from elsewhere may lack what these read.
        outcome_sentences(groups)
        if "posterior" in groups and not np.isfinite(summarize(groups).iloc[:, 1:5]).all(axis=None):
            raise ValueError("its numbers give no answer")
        return groups


def outcome_sentences(groups: Mapping[str, xr.Dataset]) -> list[str]:
    """Return how a calibration ended, and what it says of each parameter."""
    attributes = groups["observed_data"].attrs
    if attributes["outcome"] == "no fit":
        return [_no_fit(attributes)]
    sentences = []
    for row in summarize(groups).itertuples():
        ends = f"{row.low:.3g} to {row.high:.3g}"
        sentences.append(
            f"{row.parameter} = {row.median:.3g} ({ends})."
            if row.informed
            else f"{row.parameter} is not determined ({ends})."
        )
    return [*sentences, *map(_ridge_sentence, ridges(groups))]


def _no_fit(attributes: Mapping[str, Any]) -> str:
    """Return why no parameters fit."""
    probability, uncounted = float(attributes["probability"]), float(attributes["uncounted"])
    if uncounted > MOST_UNCOUNTED:
        return (
            f"No parameters in the ranges fit: {percent(uncounted)} of those that come nearest "
            f"lie where the flow is {attributes['uncounted_regime']}."
        )
    chance = f"{probability:.2g}" if probability > 0 else "below 0.001"
    return (
        "No parameters in the ranges fit: measurements as far from the model as these would "
        f"have a probability of {chance}, where {LEAST_PROBABILITY:g} is the least accepted."
    )


def _ridge_sentence(ridge: tuple[str, str, float]) -> str:
    first, second, correlation = ridge
    goes = "larger" if correlation > 0 else "smaller"
    return (
        f"A combination of {first} and {second} is known better than each: a larger {first} goes "
        f"with a {goes} {second} (correlation {correlation:.2f})."
    )
