"""What is doubtful about an answer: computed here, kept in its file, and read by every view of it.

A view is whatever shows an answer: a line of the terminal, a picture with caption and data, the
head of a report, the explorer, ``predict``, an attribute in Python. None words a doubt of its own.
"""

import csv
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from sim.base.errors import count_text, percent, printable
from sim.base.seals import read_summary
from sim.study.surrogate import LARGE_ERROR, SLOWING

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

    from sim.study.design import Axis

#: Key of the caveats in the summary of a file, and heading of their column in a table.
KEY = "caveats"

#: What stands between two caveats in a text.
_SEPARATOR = "; "

#: Share of the variance that points do not tell of each other from which on it is told.
_MUCH_UNEXPLAINED = 0.1

#: Fewest values of a number, and points of a word for each number, that are not told.
_FEWEST_VALUES, _FEWEST_OF_A_WORD = 4, 3

#: Blocks of runs below which an effect in a small part of the ranges is easily missed.
MANY_BLOCKS = 64

#: Share of the points that a mean leaves out from which on it is told.
_MUCH_LEFT_OUT = 0.5

#: Probability of the regimes of a mean below which another is likelier.
EVEN = 0.5

#: Shares of ranges or posterior without such a flow, and of the variance of runs that is noise,
#: from which on they are told.
_MUCH_ABSENT, _MUCH_NOISE = 0.01, 0.05

#: Most letters of the caveats in a file: one from elsewhere may have a million.
_LONGEST = 4000


def caveats_of_mean(
    sample: "xr.Dataset", is_used: np.ndarray, error: float, unexplained: float, omissions: str
) -> tuple[str, ...]:
    """Return what is doubtful about the mean of a surrogate, the worst first.

    Parameters
    ----------
    sample : xarray.Dataset
        Its points, see `sim.surrogates.sample.sample_points`.
    is_used : numpy.ndarray
        Which of them the mean is of, (n,).
    error : float
        Error of the mean, relative to the mean size of the observable.
    unexplained : float
        Share of the variance between the points that the others do not tell.
    omissions : str
        How many points of which regime it leaves out.
    """
    used, total = int(is_used.sum()), len(is_used)
    texts = [
        f"its error of {percent(error)} is too large to rely on" if error > LARGE_ERROR else "",
        f"its points do not tell {percent(min(1.0, unexplained))} of the variance of each other"
        if unexplained > _MUCH_UNEXPLAINED
        else "",
        f"it is of {used} of {total} points ({omissions} left out)"
        if total - used > _MUCH_LEFT_OUT * total
        else "",
        *caveats_of_points(sample.isel(point=is_used)),
    ]
    return tuple(filter(None, texts))


def caveats_of_axes(sample: "xr.Dataset", axes: Sequence["Axis"]) -> tuple[str, ...]:
    """Return which parameters the points of a mean vary too little, numbers and words."""
    texts, numbers = [], sum(axis.is_number for axis in axes)
    for axis in axes:
        values = sample[axis.name].values.tolist()
        counts = {one: values.count(one) for one in (axis.choices or dict.fromkeys(values))}
        if axis.is_number:
            if len(counts) < _FEWEST_VALUES:
                texts.append(
                    f"{axis.name} has {len(counts)} values, between which nothing is known"
                )
            continue
        few = [one for one, count in counts.items() if count < _FEWEST_OF_A_WORD * numbers]
        texts += [f"{axis.name} = {one} has {count_text(counts[one], 'point')}" for one in few]
    return tuple(texts)


def caveats_of_points(sample: "xr.Dataset") -> tuple[str, ...]:
    """Return what is doubtful about the points of an answer, see `sample_points`."""
    points = count_text(sample.sizes["point"], "point")
    # A surrogate of an earlier version tells neither.
    told = sample["caveat"].values if "caveat" in sample else ()
    lost = sample["lost"].values if "lost" in sample else ()
    texts = [str(text) for text in told if text]
    parts = [part for text in texts for part in text.split(_SEPARATOR)]
    mostly = max(dict.fromkeys(parts), key=parts.count, default="")
    regimes = sample["regime"].values.astype(str).tolist()
    counts = {
        f"carry a caveat ({mostly})": len(texts),
        "lost replicates, so that means are of the others": sum(count > 0 for count in lost),
        "surely slow down, so that the mean depends on when one looks": regimes.count(SLOWING),
        "are too short to tell a steady flow": regimes.count("undetermined"),
    }
    return tuple(
        f"runs of {count} of its {points} {text}" for text, count in counts.items() if count
    )


def caveats_of_indices(table: "pd.DataFrame") -> tuple[str, ...]:
    """Return what is doubtful about indices besides their surrogate or runs, the worst first.

    See `sim.surrogates.index_table.COLUMNS`.
    """
    first, alone = table.iloc[0], table[table["other"] == ""]
    names = alone["index"] + " " + alone["parameter"]
    rows = {text: names[alone["doubt"] == text] for text in dict.fromkeys(alone["doubt"])}
    texts = [
        f"in {percent(first['absent'])} of the ranges no flow of a regime that counts is likely, "
        "or no run is near"
        if first["absent"] >= _MUCH_ABSENT
        else "",
        *(f"{', '.join(which)}: {text}" for text, which in rows.items() if text),
        f"{first['blocks']} blocks may miss an effect in a small part of the ranges"
        if np.isnan(first["error"]) and first["blocks"] < MANY_BLOCKS
        else "",
        "the noise of the runs is not known, as points have one replicate, and counts as an effect"
        if np.isnan(first["noise"])
        else "",
        f"the noise of the runs is {percent(first['noise'])} of their variance"
        if first["noise"] > _MUCH_NOISE
        else "",
    ]
    return tuple(filter(None, texts))


def caveats_of_posterior(about: Mapping[str, Any], at_ends: Sequence[str] = ()) -> tuple[str, ...]:
    """Return what is doubtful about a calibration besides its surrogate, the worst first.

    ``about`` are `sim.surrogates.posterior.attributes`; ``at_ends`` names the parameters that lie
    at the end of their range. Where nothing fits, that is the answer.
    """
    if about["outcome"] == "no fit":
        return ()
    lengths = about["steps"] / about["autocorrelation"]
    texts = [
        f"its chains are {lengths:.0f} autocorrelation times long, too short for its intervals"
        if about["outcome"] == "not converged"
        else "",
        f"{percent(about['uncounted'])} of the posterior lies where the flow is "
        f"{about['uncounted_regime']}"
        if about["uncounted"] >= _MUCH_ABSENT
        else "",
        f"{percent(about.get('far', 0.0))} of the posterior lies where no run is near"
        if about.get("far", 0.0) >= _MUCH_ABSENT
        else "",
        *(f"{name} lies at the end of its range, which may be too narrow" for name in at_ends),
    ]
    return tuple(filter(None, texts))


def caveats_of_places(
    counted: np.ndarray, regimes: Sequence[str], is_far: np.ndarray
) -> tuple[str, ...]:
    """Return where a mean of some ``regimes`` means little.

    ``counted`` is the probability of these regimes at each place, (n,); ``is_far`` says which
    places have no run near them, (n,).
    """
    counts = {
        f"another regime is likelier than {' or '.join(regimes)}": int((counted < EVEN).sum()),
        "no run is near": int(is_far.sum()),
    }
    return tuple(
        f"{'there' if counted.size == 1 else f'at {count} of {counted.size} places'} {text}"
        for text, count in counts.items()
        if count
    )


def joined(caveats: Sequence[str]) -> str:
    """Return caveats as one text, as a cell or an attribute has them."""
    return _SEPARATOR.join(caveats)


def parted(text: str) -> tuple[str, ...]:
    """Return the caveats in a text of `joined`."""
    return tuple(filter(None, text.split(_SEPARATOR)))


def sentence(caveats: Sequence[str]) -> str:
    """Return caveats as a sentence, empty for none.

    >>> sentence(["its error of 57 % is too large to rely on", "it is of 4 of 48 points"])
    'Caveat: its error of 57 % is too large to rely on; it is of 4 of 48 points.'
    """
    return f"Caveat: {joined(caveats)}." if caveats else ""


def answer_name(path: Path) -> str:
    """Return the name of an answer from the path of its file: ``surrogate speed``."""
    return f"{path.parent.name.removesuffix('s')} {path.stem}"


def with_caveats(table: "pd.DataFrame", caveats: Sequence[str]) -> "pd.DataFrame":
    """Return a table whose rows end with the caveats, if there are any."""
    return table.assign(**{KEY: joined(caveats)}) if caveats else table


def caveats_in(path: Path) -> tuple[str, ...]:
    """Return the caveats in the file of an answer, the worst first.

    There are none where the file is missing, damaged, or of an earlier version.
    """
    if not path.is_file():
        return ()
    if path.suffix == ".csv":
        with path.open(encoding="utf-8", errors="replace", newline="") as file:
            row = next(csv.DictReader(file), {})
        stored = [row.get(KEY) or ""]
    else:
        stored = (read_summary(path) or {}).get(KEY) or []
    if not (isinstance(stored, list) and all(isinstance(text, str) for text in stored)):
        return ()
    return parted(printable(joined(stored))[:_LONGEST])
