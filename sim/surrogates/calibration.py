"""Calibrations as files that ArviZ reads, and what they say in a line."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import netCDF4
import numpy as np
import xarray as xr

from sim.base.files import atomic_write
from sim.base.seals import append_summary, checked_read, seal
from sim.surrogates.caveats import KEY
from sim.surrogates.posterior import LEAST_PROBABILITY, LONG_ENOUGH, summarize
from sim.surrogates.refusals import require_answer


def save(name: str, groups: Mapping[str, xr.Dataset], caveats: Sequence[str], path: Path) -> None:
    """Write the groups of a calibration; the file appears complete or not at all.

    Its end has a line with what it says, and what is doubtful about that.
    """
    line = f"calibration {name}: {' '.join(outcome_sentences(groups))}"
    path.parent.mkdir(parents=True, exist_ok=True)
    with atomic_write(path) as temporary:
        for number, (key, group) in enumerate(groups.items()):
            group.to_netcdf(temporary, mode="a" if number else "w", group=key, engine="netcdf4")
        append_summary(temporary, {"line": line, KEY: list(caveats)})
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
    probability = float(attributes["probability"])
    if attributes["outcome"] == "no fit":
        chance = f"{probability:.2g}" if probability > 0 else "below 0.001"
        return [
            "No parameters in the ranges fit: measurements as far from the model as these would "
            f"have a probability of {chance}, where {LEAST_PROBABILITY:g} is the least accepted."
        ]
    sentences = []
    if attributes["outcome"] == "not converged":
        sentences.append(
            f"Not converged: the chains of {attributes['steps']} steps are "
            f"{attributes['steps'] / attributes['autocorrelation']:.0f} autocorrelation times "
            f"long, {LONG_ENOUGH} are needed; the intervals are not reliable."
        )
    for row in summarize(groups).itertuples():
        values = f"{row.parameter} = {row.median:.3g} ({row.low:.3g} to {row.high:.3g})"
        if not row.informed:
            values += ", of which the data say nothing beyond its range"
        sentences.append(f"{values}.")
    return sentences
