"""What answers say of themselves: what is doubtful, tables of indices, refusals.

What is doubtful is computed here, kept in the file of the answer, and read by every view of it: a
line of the terminal, a picture with caption and data, the head of a report, the explorer,
``predict``, an attribute in Python. None words a doubt of its own.
"""

import csv
import hashlib
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from sim.base.errors import InputError, count_text, percent
from sim.base.files import atomic_write, read_regular
from sim.base.seals import append_summary, checked_read, is_damaged, read_summary, seal
from sim.study.surrogate import LARGE_ERROR, SLOWING

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

    from sim.study.design import Axis

#: Keys of caveats and of a refusal in the summary of a file, and headings of columns in a table.
KEY, _REFUSAL = "caveats", "refusal"

#: What stands between two caveats in a text.
_SEPARATOR = "; "

#: Shares from which on they are told: of the variance that points do not tell of each other, of the
#: points that a mean leaves out, of ranges or posterior without such a flow, and of noise.
_MUCH_UNEXPLAINED, _MUCH_LEFT_OUT, _MUCH_ABSENT, _MUCH_NOISE = 0.1, 0.5, 0.01, 0.05

#: Fewest values of a number, and points of a word for each number, that are not told.
_FEWEST_VALUES, _FEWEST_OF_A_WORD = 4, 3

#: Blocks of runs below which an effect in a small part of the ranges is easily missed.
MANY_BLOCKS = 64

#: Probability of the regimes of a mean below which another is likelier.
EVEN = 0.5


class Refusal(InputError):
    """The runs cannot answer a question; the message says why, and what may help."""


def _told(doubts: Mapping[str, bool]) -> tuple[str, ...]:
    """Return the doubts that there is a reason for."""
    return tuple(text for text, is_true in doubts.items() if is_true)


def caveats_of_mean(
    sample: "xr.Dataset", is_used: np.ndarray, error: float, unexplained: float, omissions: str
) -> tuple[str, ...]:
    """Return what is doubtful about the mean of a surrogate, the worst first.

    It is of the points of a sample (`sim.surrogates.sample.sample_points`) that are used, (n,), and
    leaves out ``omissions``. Its error is relative to the mean size of the observable;
    ``unexplained`` is the share of the variance between points that the others do not tell.
    """
    used, total = int(is_used.sum()), len(is_used)
    share, is_rough = percent(min(1.0, unexplained)), unexplained > _MUCH_UNEXPLAINED
    few = f"it is of {used} of {total} points ({omissions} left out)"
    doubts = {
        f"its error of {percent(error)} is too large to rely on": error > LARGE_ERROR,
        f"its points do not tell {share} of the variance of each other": is_rough,
        few: total - used > _MUCH_LEFT_OUT * total,
    }
    return _told(doubts) + caveats_of_points(sample.isel(point=is_used))


def caveats_of_axes(sample: "xr.Dataset", axes: Sequence["Axis"]) -> tuple[str, ...]:
    """Return which parameters the points of a mean vary too little, numbers and words."""
    doubts, numbers = {}, sum(axis.is_number for axis in axes)
    for axis in axes:
        values = sample[axis.name].values.tolist()
        if axis.is_number:
            count = len(set(values))
            text = f"{axis.name} has {count} values, between which nothing is known"
            doubts[text] = count < _FEWEST_VALUES
        for one in axis.choices:
            count = values.count(one)
            text = f"{axis.name} = {one} has {count_text(count, 'point')}"
            doubts[text] = count < _FEWEST_OF_A_WORD * numbers
    return _told(doubts)


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
    return _told({f"runs of {n} of its {points} {text}": n > 0 for text, n in counts.items()})


def caveats_of_indices(table: "pd.DataFrame") -> tuple[str, ...]:
    """Return what is doubtful about a table besides its surrogate or runs, the worst first.

    See `sim.surrogates.indices.COLUMNS`.
    """
    first, alone = table.iloc[0], table[table["other"] == ""]
    absent, blocks, noise = first["absent"], first["blocks"], first["noise"]
    names = (alone["index"] + " " + alone["parameter"]).str.strip()
    nowhere = "no flow of a regime that counts is likely, or no run is near"
    missed = f"{blocks} blocks may miss an effect in a small part of the ranges"
    is_spread = first["index"] == "mean"
    as_what = "spread" if is_spread else "an effect"
    unknown = f"is not known, as points have one replicate, and counts as {as_what}"
    left_out, every = first["left_out"], first["left_out"] + blocks
    others = f"{left_out} of {every} runs have no value that counts, so that it is of the others"
    doubts = {f"in {percent(absent)} of the ranges {nowhere}": absent >= _MUCH_ABSENT}
    for doubt in dict.fromkeys(alone["doubt"]):
        doubts[f"{', '.join(names[alone['doubt'] == doubt])}: {doubt}"] = doubt != ""
    return _told(
        doubts
        | {
            others: is_spread and left_out > 0,
            missed: not is_spread and np.isnan(first["error"]) and blocks < MANY_BLOCKS,
            f"the noise of the runs {unknown}": np.isnan(noise),
            f"the noise of the runs is {percent(noise)} of their variance": noise > _MUCH_NOISE,
        }
    )


def caveats_of_posterior(about: Mapping[str, Any], at_ends: Sequence[str] = ()) -> tuple[str, ...]:
    """Return what is doubtful about a calibration besides its surrogate, the worst first.

    ``about`` are `sim.surrogates.posterior.attributes`; ``at_ends`` names the parameters that lie
    at the end of their range. Where nothing fits, that is the answer.
    """
    if about["outcome"] == "no fit":
        return ()
    length = f"{about['steps'] / about['autocorrelation']:.0f} autocorrelation times"
    short = f"its chains are {length} long, too short for its intervals"
    shares = {
        f"the flow is {about['uncounted_regime']}": about["uncounted"],
        "no run is near": about.get("far", 0.0),
    }
    doubts = {short: about["outcome"] == "not converged"} | {
        f"{percent(share)} of the posterior lies where {text}": share >= _MUCH_ABSENT
        for text, share in shares.items()
    }
    ends = (f"{name} lies at the end of its range, which may be too narrow" for name in at_ends)
    return (*_told(doubts), *ends)


def caveats_of_places(
    counted: np.ndarray, regimes: Sequence[str], is_far: np.ndarray
) -> tuple[str, ...]:
    """Return where a mean of some ``regimes`` means little.

    ``counted`` is the probability of these regimes at each place, (n,); ``is_far`` says which
    places have no run near them, (n,).
    """
    size = counted.size
    counts = {
        f"another regime is likelier than {' or '.join(regimes)}": int((counted < EVEN).sum()),
        "no run is near": int(is_far.sum()),
    }
    where = "there" if size == 1 else "at {} of {} places"
    return _told({f"{where.format(n, size)} {text}": n > 0 for text, n in counts.items()})


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


def with_caveats(table: "pd.DataFrame", caveats: Sequence[str]) -> "pd.DataFrame":
    """Return a table whose rows end with the caveats, if there are any."""
    return table.assign(**{KEY: joined(caveats)}) if caveats else table


def caveats_in(path: Path) -> tuple[str, ...]:
    """Return the caveats in the file of an answer, the worst first.

    There are none where the file is missing, damaged, or of an earlier version.
    """
    if not path.is_file():
        return ()
    if path.suffix != ".csv":
        return tuple((read_summary(path) or {}).get(KEY, ()))
    with path.open(encoding="utf-8", errors="replace", newline="") as file:
        return parted(next(csv.DictReader(file), {}).get(KEY) or "")


def answer_name(path: Path) -> str:
    """Return the name of an answer from the path of its file: ``surrogate speed``."""
    return f"{path.parent.name.removesuffix('s')} {path.stem}"


def save_table(table: "pd.DataFrame", path: Path) -> None:
    """Write a table; the file appears complete or not at all.

    A note beside it has its checksum: a seal at the end would be a row to those who read CSV.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    with atomic_write(path) as temporary:
        table.to_csv(temporary, index=False, float_format="%.10g")
        # Until the table takes its place, the one before it is whole, too.
        whole = [temporary.read_bytes(), read_table(path) if path.is_file() else None]
        checksums = dict.fromkeys(_checksum(one) for one in whole if one is not None)
        with atomic_write(_note(path)) as note:
            note.write_text(" ".join(checksums), encoding="ascii")


def read_table(path: Path) -> bytes | None:
    """Return the bytes of a table, None where they are not those of its checksum.

    One of an earlier version has no checksum.
    """
    content, note = read_regular(path), _note(path)
    if note.is_file() and _checksum(content) not in note.read_text("ascii", "replace"):
        return None
    return content


def _note(path: Path) -> Path:
    return path.with_name(f".{path.name}.sha256")


def _checksum(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()


def table_text(path: Path) -> str:
    """Return the text of a table, empty where it is damaged."""
    return (read_table(path) or b"").decode("utf-8", "replace")


def save_refusal(refusal: Refusal, path: Path) -> None:
    """Write a refusal where the answer would stand; the file appears complete or not at all."""
    # Imported here: reading refusals needs none of it.
    import pandas as pd
    import xarray as xr

    text = str(refusal)
    if path.suffix == ".csv":
        save_table(pd.DataFrame({_REFUSAL: [text]}), path)
        return
    with sealed_file(path, {"line": text, _REFUSAL: text}) as temporary:
        xr.Dataset(attrs={_REFUSAL: text}).to_netcdf(temporary, engine="netcdf4")


@contextmanager
def sealed_file(path: Path, summary: Mapping[str, Any]) -> Iterator[Path]:
    """Let a netCDF file be written: it appears with summary and checksum, or not at all."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with atomic_write(path) as temporary:
        yield temporary
        append_summary(temporary, summary)
        seal(temporary)


@contextmanager
def stored_answer(path: Path, kind: str) -> Iterator[None]:
    """Let the file of an answer be read.

    Raises `InputError` when there is no such file, or it is damaged: in the results of a study it
    is then set aside, so that the study makes it again. Raises `Refusal` when the runs do not give
    the answer.
    """
    is_of_study = (path.parent.parent / "runs").is_dir()
    with checked_read(path, kind, replaceable=is_of_study, sealed=path.suffix != ".csv"):
        if text := refusal_in(path):
            raise Refusal(text)
        yield


def refusal_in(path: Path) -> str:
    """Return the refusal in a file of an answer, a line.

    It is empty where there is no refusal or no file, or the file is damaged.
    """
    if not path.is_file():
        return ""
    if path.suffix != ".csv":
        text = (read_summary(path) or {}).get(_REFUSAL, "")
        return "" if text and is_damaged(path) else text
    rows = list(csv.reader(table_text(path).splitlines()))
    return rows[1][0] if rows[:1] == [[_REFUSAL]] else ""
