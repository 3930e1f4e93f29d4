"""Points spread over ranges of parameters, in an order that more points go on with."""

import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass
from math import ceil, log2, sqrt
from operator import ge, gt, le, lt
from statistics import median
from typing import Any, Literal, NamedTuple

import numpy as np

from sim.base.numbers import number

#: Digits of a value: so few that every machine rounds it to the same one. Least number of points of
#: a sequence that are made at once.
SIGNIFICANT_DIGITS, _MIN_CHUNK = 6, 1024

_COMPARISONS: dict[str, Callable[[Any, Any], Any]] = {"<=": le, ">=": ge, "<": lt, ">": gt}
OPERATORS = tuple(_COMPARISONS)
_COMPARISON = re.compile(rf"\s*([\w.+-]+)\s*({'|'.join(OPERATORS)})\s*([\w.+-]+)\s*")


class Comparison(NamedTuple):
    """A condition on a point of a design; each side is a number or the name of a parameter."""

    left: float | str
    operator: str
    right: float | str

    @property
    def names(self) -> tuple[str, ...]:
        """The parameters on its sides."""
        return tuple(side for side in (self.left, self.right) if isinstance(side, str))

    def satisfied(self, columns: Mapping[str, Any]) -> np.ndarray:
        """Return which points satisfy it, from the values of each parameter."""
        sides = (columns[one] if isinstance(one, str) else one for one in (self.left, self.right))
        return np.asarray(_COMPARISONS[self.operator](*map(np.asarray, sides)))


def read_comparison(text: str) -> Comparison | None:
    """Return what a text such as ``friction < 0.5`` says, None where it is no comparison."""
    if not (match := _COMPARISON.fullmatch(text)):
        return None
    left, sign, right = match.groups()
    return Comparison(_number_or_name(left), sign, _number_or_name(right))


def _number_or_name(text: str) -> float | str:
    with suppress(ValueError):
        return number(text)
    return text


@dataclass(frozen=True)
class Axis:
    """A parameter that the points of a series vary, and how its values are spread.

    ``low`` and ``high`` are its lowest and highest value, in the unit of a study file; of words and
    switches the first and the last index of ``choices``. These are the values that it takes, empty
    where it takes any between, evenly spread in its ``scale``, or with the mean and the deviation
    of a ``normal`` distribution that is cut off at the ends.
    """

    name: str
    low: float
    high: float
    scale: Literal["linear", "log"] = "linear"
    choices: tuple[Any, ...] = ()
    normal: tuple[float, float] | None = None
    is_integer: bool = False

    @property
    def is_number(self) -> bool:
        """Whether its values are numbers; if not, they are words or switches."""
        return not any(isinstance(value, (str, bool)) for value in self.choices)

    @property
    def middle(self) -> float:
        """The middle of its range in its scale, in three digits: where pictures hold a number."""
        is_log = self.scale == "log"
        middle = sqrt(self.low * self.high) if is_log else (self.low + self.high) / 2
        return min(max(float(f"{middle:.3g}"), self.low), self.high)

    def values(self, shares: np.ndarray) -> list[Any]:
        """Return the values below which shares of the distribution lie, shape (n,), from 0 to 1.

        Numbers are rounded to `SIGNIFICANT_DIGITS`, those of integer parameters to integers.
        """
        if self.choices:
            last = len(self.choices) - 1
            return [self.choices[min(int(share * (last + 1)), last)] for share in shares]
        # Half a unit more on both sides: the ends of a range of integers are as likely as others.
        margin = 0.5 if self.is_integer else 0.0
        low, high = self.low - margin, self.high + margin
        if self.normal:
            from scipy.stats import truncnorm

            mean, deviation = self.normal
            ends = (low - mean) / deviation, (high - mean) / deviation
            values = truncnorm.ppf(shares, *ends, loc=mean, scale=deviation)
        elif self.scale == "log":
            values = low * (high / low) ** shares
        else:
            values = low + (high - low) * shares
        if self.is_integer:
            return [int(value) for value in np.clip(np.rint(values), self.low, self.high)]
        rounded = (float(f"{value:.{SIGNIFICANT_DIGITS}g}") for value in values)
        return [min(max(value, self.low), self.high) for value in rounded]


def axis_of(name: str, values: Iterable[Any], is_integer: bool) -> Axis:
    """Return the axis of a parameter with given values, as a grid has them.

    It has no choices but words and switches. Its scale is ``log`` where the median of the values is
    nearer to the geometric mean of the lowest and the highest than to their mean.
    """
    different = tuple(dict.fromkeys(values))
    if any(isinstance(value, (str, bool)) for value in different):
        return Axis(name, 0.0, len(different) - 1.0, choices=different)
    low, high, middle = map(float, (min(different), max(different), median(different)))
    is_log = low > 0 and abs(middle - sqrt(low * high)) < abs(middle - (low + high) / 2)
    return Axis(name, low, high, "log" if is_log else "linear", is_integer=is_integer)


def unit_points(kind: str, dimensions: int, count: int, seed: int) -> Iterator[np.ndarray]:
    """Yield points of the unit cube in order, at least ``count``; more of kinds with `where`."""
    if kind in ("sobol", "random"):
        # Sobol's first points are balanced if their number is a power of two.
        size = 2 ** ceil(log2(max(count, _MIN_CHUNK)))
        if kind == "random":
            draw = np.random.default_rng(seed).random
            while True:
                yield draw((size, dimensions))
        from scipy.stats import qmc

        sobol = qmc.Sobol(dimensions, rng=seed)
        while True:
            yield sobol.random(size)
    elif kind == "latin_hypercube":
        from scipy.stats import qmc

        yield qmc.LatinHypercube(dimensions, rng=seed).random(count)
    else:
        from SALib.sample import morris
        from SALib.sample import sobol as saltelli

        names = [str(number) for number in range(dimensions)]
        problem = {"num_vars": dimensions, "names": names, "bounds": [[0, 1]] * dimensions}
        blocks = ceil(count / block_size(kind, dimensions))
        if kind == "saltelli":
            number = 2 ** ceil(log2(blocks))
            yield saltelli.sample(problem, number, calc_second_order=False, seed=seed)
        else:
            yield morris.sample(problem, blocks, seed=seed)


def block_size(kind: str, dimensions: int) -> int:
    """Return the number of points that belong together: an analysis needs whole blocks."""
    return {"saltelli": dimensions + 2, "morris": dimensions + 1}.get(kind, 1)
