"""Where a surrogate is highest or lowest, and how surely it is there."""

from collections.abc import Mapping, Sequence
from itertools import product
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

from sim.base.errors import InputError
from sim.base.statistics import CONFIDENCE
from sim.study.design import Axis, unit_points
from sim.surrogates import answers
from sim.surrogates.fit import counted_probability

#: Places of the first look, and of each closer one about the best so far; how many closer looks
#: there are, and by how much each is closer.
_FIRST, _CLOSER, _LOOKS, _SHRINK = 2048, 256, 8, 0.4

#: Most parameters of which every corner of the ranges is looked at.
_MOST_CORNERS = 8

#: Courses of the mean that are drawn, places at which each is compared, and errors by which a mean
#: may be off where it is still a rival.
_DRAWS, _COMPARED, _WIDE = 1000, 512, 3


def extreme(surrogate: Any, sign: int, given: Mapping[str, Any]) -> xr.Dataset:
    """Return what a surrogate says where its mean is highest (``sign`` 1) or lowest (-1).

    Parameters that are not ``given`` are searched over the ranges of the points and over their
    words, where a regime of the mean is the likeliest. The answer is that of a call at the place.
    Its attribute ``likely`` maps each of them to the range, or the words, in which the place lies
    with 95 % probability: the mean may take any course that its errors allow. Raises `InputError`
    when no parameter is left to search, or a value is not allowed, and `Refusal` when no place has
    a regime of the mean.
    """
    free = [axis for axis in surrogate.axes if axis.name not in given]
    if not free:
        allowed = "some of " + ", ".join(axis.name for axis in surrogate.axes) + ", not all"
        raise InputError.of_value(surrogate.name, "given", ", ".join(given), allowed)
    numeric, words = ([axis for axis in free if axis.is_number is one] for one in (True, False))
    every = product(*(axis.choices for axis in words))
    settings = [{**given, **dict(zip(_names(words), one, strict=True))} for one in every]
    looks = [_look(surrogate, sign, numeric, one) for one in settings]
    places = pd.concat(looks, ignore_index=True)
    if places.empty:
        regimes = " or ".join(surrogate.mean_regimes)
        raise answers.Refusal(f"no place, as another regime is likelier than {regimes} everywhere")
    best = places.loc[(sign * places["mean"]).idxmax()]
    answer = surrogate(**given, **{name: best[name] for name in _names(free)})
    of_edges = [
        f"{axis.name} = {best[axis.name]:g} is at the edge of its range, beyond which it may be "
        f"{'higher' if sign > 0 else 'lower'}"
        for axis in numeric
        if best[axis.name] in (axis.low, axis.high)
    ]
    caveats = answers.joined([*of_edges, *answers.parted(answer.attrs[answers.KEY])])
    least = (sign * places["mean"] - _WIDE * places["error"]).max()
    rivals = [
        _rivals(surrogate, numeric, one, look[sign * look["mean"] + _WIDE * look["error"] >= least])
        for one, look in zip(settings, looks, strict=True)
    ]
    likely = _likely(surrogate, sign, pd.concat([best.to_frame().T, *rivals]), free)
    return answer.assign_attrs({"likely": likely, answers.KEY: caveats})


def _names(axes: Sequence[Axis]) -> list[str]:
    return [axis.name for axis in axes]


def _look(
    surrogate: Any, sign: int, free: Sequence[Axis], given: Mapping[str, Any]
) -> pd.DataFrame:
    """Return places that were tried and have a regime of the mean: values, ``mean``, ``error``.

    ``given`` includes all words; the numbers in it are the same at all places.
    """
    size = len(free)
    if not free:
        return _tried(surrogate, free, given, np.zeros((1, 0)))
    corners = product((0.0, 1.0), repeat=size) if size <= _MOST_CORNERS else ()
    first = next(unit_points("sobol", size, _FIRST, 0))[:_FIRST]
    shares = np.concatenate([first, np.reshape(list(corners), (-1, size))])
    places = _tried(surrogate, free, given, shares)
    around, width = next(unit_points("sobol", size, _CLOSER, 1))[:_CLOSER] - 0.5, 1.0
    for _ in range(_LOOKS if len(places) else 0):
        width *= _SHRINK
        best = places.loc[(sign * places["mean"]).idxmax(), "shares"]
        closer = _tried(surrogate, free, given, np.clip(best + width * around, 0.0, 1.0))
        places = pd.concat([places, closer], ignore_index=True)
    return places


def _tried(
    surrogate: Any, free: Sequence[Axis], given: Mapping[str, Any], shares: np.ndarray
) -> pd.DataFrame:
    """Return the places at shares (n, k) of the ranges of free parameters, as `_look` does."""
    rows = pd.DataFrame(given, index=range(len(shares)))
    for axis, column in zip(free, shares.T, strict=True):
        rows[axis.name] = np.asarray(axis.values(column), dtype=float)
    there = surrogate.at(**{name: given[name] for name in surrogate.choices})
    x = rows[list(surrogate.parameters)].to_numpy(float)
    rows["mean"], rows["error"] = there.predict(x)
    rows["shares"], rows["cube"] = list(shares), list(there.cube(x))
    return rows[counted_probability(there, there.probability(x)) >= answers.EVEN]


def _rivals(
    surrogate: Any, free: Sequence[Axis], given: Mapping[str, Any], possible: pd.DataFrame
) -> pd.DataFrame:
    """Return places spread over the box of those that may be the extreme, as `_look` does."""
    if not free or possible.empty:
        return possible
    shares = np.stack(list(possible["shares"]))
    low, high = shares.min(axis=0), shares.max(axis=0)
    # A wider box, cut off at the ends of the ranges, has places at these ends.
    margin = 0.1 * (high - low) + 1e-3
    spread = next(unit_points("sobol", len(free), _COMPARED, 2))[:_COMPARED]
    inside = np.clip(low - margin + (high - low + 2 * margin) * spread, 0.0, 1.0)
    return _tried(surrogate, free, given, inside)


def _likely(surrogate: Any, sign: int, rows: pd.DataFrame, free: Sequence[Axis]) -> dict[str, Any]:
    """Return in which range, or at which words, the extreme of the mean lies: parameter by name.

    Places are compared in courses of the mean, drawn from its errors and how they go together.
    """
    cube = np.stack(list(rows["cube"]))
    mean, error = (rows[name].to_numpy(float) for name in ("mean", "error"))
    together = surrogate.process.correlation(cube[None], cube[None])[0]
    np.fill_diagonal(together, 1.0)
    values, vectors = np.linalg.eigh(together * np.outer(error, error))
    normal = np.random.default_rng(0).standard_normal((_DRAWS, len(rows)))
    courses = mean + normal * np.sqrt(np.maximum(0.0, values)) @ vectors.T
    chosen, ends = rows.iloc[(sign * courses).argmax(axis=1)], (1 - CONFIDENCE) / 2
    likely: dict[str, Any] = {}
    for axis in free:
        if axis.is_number:
            quantiles = (
                chosen[axis.name].astype(float).quantile([ends, 1 - ends], interpolation="nearest")
            )
            likely[axis.name] = tuple(map(float, quantiles))
        else:
            shares = chosen[axis.name].value_counts(normalize=True)
            likely[axis.name] = tuple(shares.index[shares > 1 - CONFIDENCE])
    return likely
