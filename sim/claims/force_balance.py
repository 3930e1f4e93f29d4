"""The plane carries a steady flow: shear/normal is tan θ, the normal force is N m g cos θ.

Walton (1993), Sec. 1: only steady conditions are meaningful. Nothing in the engine enforces the
balance, so it tests contact, plane, integrator and the steadiness of the flow together. The
momentum budget beside it (base shear plus rate of change of momentum is N m g sin θ) holds for any
flow, so it tests the engine alone.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr

from sim.outcome import outcome, student_half_width

REPRODUCED = "reproduced"
NOT_REPRODUCED = "not reproduced"
INCONCLUSIVE = "inconclusive"

#: Largest relative deviations that count as agreement.
LIMITS = {"ratio": 0.005, "normal": 0.002, "budget": 0.005}

#: With fewer replicates Student's interval says next to nothing, and errors within runs are used.
REPLICATES_FOR_STUDENT = 3


@dataclass(frozen=True)
class Deviation:
    """Relative deviation of a measured force from its exact value, with a 95 % interval."""

    mean: float
    half_width: float
    limit: float

    @property
    def verdict(self) -> str:
        """The interval lies within the limit, beyond it, or across it."""
        if not np.isfinite(self.mean + self.half_width):
            return INCONCLUSIVE
        if abs(self.mean) + self.half_width < self.limit:
            return REPRODUCED
        return NOT_REPRODUCED if abs(self.mean) - self.half_width > self.limit else INCONCLUSIVE


@dataclass(frozen=True)
class PointBalance:
    """Forces on the plane at one point.

    ``ratio``: shear/normal against tan θ, and ``normal``: against N m g cos θ, ``None`` unless the
    flow is steady; ``budget``: shear plus rate of change of momentum against N m g sin θ.
    """

    point: str
    regime: str
    replicates: int
    ratio: Deviation | None
    normal: Deviation | None
    budget: Deviation

    @property
    def steady(self) -> bool:
        """Whether the force balance is judged here."""
        return self.ratio is not None

    @property
    def verdict(self) -> str:
        """The worse of the verdicts on ratio and normal force, ``""`` unless steady."""
        return worst([self.ratio.verdict, self.normal.verdict]) if self.steady else ""


@dataclass(frozen=True)
class ForceBalance:
    """Verdicts on a study: those of its worst point; inconclusive without any."""

    points: tuple[PointBalance, ...]

    @property
    def verdict(self) -> str:
        """Force balance of the steady flows."""
        return worst([point.verdict for point in self.points if point.steady])

    @property
    def budget_verdict(self) -> str:
        """Momentum budget of all flows."""
        return worst([point.budget.verdict for point in self.points])

    def count(self, verdict: str) -> int:
        """Return how many steady points have a verdict."""
        return sum(point.verdict == verdict for point in self.points)


def worst(verdicts: Sequence[str]) -> str:
    """Return the verdict on all: one failure fails them all, no verdict at all is inconclusive."""
    if NOT_REPRODUCED in verdicts:
        return NOT_REPRODUCED
    return REPRODUCED if verdicts and set(verdicts) == {REPRODUCED} else INCONCLUSIVE


def judge(dataset: xr.Dataset) -> ForceBalance:
    """Judge every chute point with a completed replicate; a point is steady if all of these are.

    Parameters
    ----------
    dataset : xarray.Dataset
        A study's ``dataset.nc``.

    Notes
    -----
    With three replicates or more the interval is Student's over them, otherwise it comes from the
    errors of the base forces within the runs (see `sim.dataset`).
    """
    balances = []
    for index in np.flatnonzero(dataset["system"].values == "chute"):
        point = dataset.isel(point=index)
        completed = point.isel(replicate=np.flatnonzero(point["status"].values == "completed"))
        if completed.sizes["replicate"]:
            balances.append(_balance(completed, outcome(point)["regime"]))
    return ForceBalance(tuple(balances))


def _balance(point: xr.Dataset, regime: str) -> PointBalance:
    angle = np.radians(float(point["angle"]))
    weight = float(point["particles"] * point["mass"] * point["gravity"])
    along, across = weight * np.sin(angle), weight * np.cos(angle)
    normal, shear, budget = (
        point[name].values for name in ("base_normal", "base_shear", "momentum_budget")
    )
    ratio = balance = None
    if regime == "steady":
        normal_error = point["base_normal_error"].values / normal
        ratio_error = np.hypot(point["base_shear_error"].values / shear, normal_error)
        ratio = _deviation(shear / normal / np.tan(angle) - 1, ratio_error, LIMITS["ratio"])
        balance = _deviation(normal / across - 1, normal_error, LIMITS["normal"])
    return PointBalance(
        point=str(point["point"].values),
        regime=regime,
        replicates=normal.size,
        ratio=ratio,
        normal=balance,
        budget=_budget(budget, point["momentum_budget_error"].values, along),
    )


def _budget(budget: np.ndarray, errors: np.ndarray, along: float) -> Deviation:
    """Compare with the weight along the slope; on a level plane, where there is none, undecided."""
    if along == 0:
        return Deviation(np.nan, np.nan, LIMITS["budget"])
    return _deviation(budget / along - 1, errors / along, LIMITS["budget"])


def _deviation(values: np.ndarray, errors: np.ndarray, limit: float) -> Deviation:
    """Join the deviations of replicates; ``errors`` are their relative standard errors."""
    if values.size >= REPLICATES_FOR_STUDENT:
        half_width = student_half_width(values)
    else:
        half_width = 1.96 * float(np.sqrt((errors**2).sum())) / values.size
    return Deviation(float(values.mean()), half_width, limit)
