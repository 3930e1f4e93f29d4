"""From the records of both engines to one comparison per flow, and the table of all."""

from typing import NamedTuple

import numpy as np

from benchmarks.crosscheck.engines import Record
from benchmarks.crosscheck.flows import BLOCKS, Flow
from benchmarks.crosscheck.runs import load
from benchmarks.crosscheck.statistics import Estimate, agree, compared, estimate, pooled, ratio


class Measured(NamedTuple):
    """What all replicates of one engine give.

    ``velocity`` (√(gσ)), ``contacts`` per particle, ``drift``: change of the velocity from the
    first to the second half of the averaging; profiles over slices (H,): ``packing`` fraction and
    ``speed`` (√(gσ)).
    """

    velocity: Estimate
    contacts: Estimate
    drift: Estimate
    packing: Estimate
    speed: Estimate


class Comparison(NamedTuple):
    """Both engines on one flow, and which slices (H,) are compared."""

    flow: Flow
    talus: Measured
    lammps: Measured
    slices: np.ndarray

    def share(self, profile: str) -> float:
        """Return the share of the slices whose ``packing`` or ``speed`` agrees.

        Within 3 % of the profile's maximum, or within the combined interval.
        """
        ours, theirs = self._profiles(profile)
        return float(agree(ours, theirs, theirs.mean.max()).mean())

    def gap(self, profile: str) -> float:
        """Return the largest difference between both profiles, relative to the maximum."""
        ours, theirs = self._profiles(profile)
        return float(np.abs(ours.mean - theirs.mean).max() / theirs.mean.max())

    def _profiles(self, profile: str) -> list[Estimate]:
        return [
            Estimate(*(values[self.slices] for values in getattr(engine, profile)))
            for engine in (self.talus, self.lammps)
        ]

    def ratio(self, scalar: str) -> Estimate:
        """Return the ratio Talus over LAMMPS of ``velocity`` or ``contacts``."""
        return ratio(getattr(self.talus, scalar), getattr(self.lammps, scalar))

    def agrees(self, scalar: str) -> bool:
        """Return whether both agree in ``velocity`` or ``contacts``: in 3 % or the interval."""
        ours, theirs = getattr(self.talus, scalar), getattr(self.lammps, scalar)
        return bool(agree(ours, theirs, theirs.mean))

    @property
    def agrees_throughout(self) -> bool:
        """Whether both agree in everything that is compared."""
        scalars = self.agrees("velocity") and self.agrees("contacts")
        return scalars and self.share("speed") == self.share("packing") == 1.0


def measured(records: list[Record]) -> Measured:
    """Return the estimates from the records of all replicates."""
    velocity = block_means([record.velocity for record in records])
    half = velocity.shape[1] // 2
    drift = velocity[:, half:].mean(axis=1) - velocity[:, :half].mean(axis=1)
    packing = np.array([record.packing for record in records])
    flux = np.array([record.flux for record in records])
    with np.errstate(invalid="ignore", divide="ignore"):
        speed = flux / packing
    return Measured(
        estimate(velocity),
        estimate(block_means([record.contacts for record in records])),
        estimate(drift[:, None]),
        estimate(packing),
        estimate(speed),
    )


def block_means(series: list[np.ndarray]) -> np.ndarray:
    """Return the means (R, B) over the blocks of each replicate's series of samples."""
    return np.array([values.reshape(BLOCKS, -1).mean(axis=1) for values in series])


def comparison(flow: Flow) -> Comparison:
    """Return both engines' results for a flow that has been run."""
    talus, lammps = measured(load("Talus", flow)), measured(load("LAMMPS", flow))
    packing = 0.5 * (talus.packing.mean + lammps.packing.mean)
    return Comparison(flow, talus, lammps, compared(packing))


HEADINGS = [
    "flow",
    "V, Talus",
    "V, LAMMPS",
    "ratio of V",
    "Z, Talus",
    "Z, LAMMPS",
    "ratio of Z",
    "slices that agree, v / φ",
    "largest gap, v / φ",
    "drift of V, Talus / LAMMPS",
]


def table(comparisons: list[Comparison]) -> str:
    """Return the comparisons as a table in Markdown, the ratios of all flows pooled at its end."""
    rows = [HEADINGS, ["---"] * len(HEADINGS), *(_row(c) for c in comparisons)]
    mean = {
        scalar: mean_and_interval(pooled([c.ratio(scalar) for c in comparisons]), 3)
        for scalar in ("velocity", "contacts")
    }
    rows.append(["all", "", "", mean["velocity"], "", "", mean["contacts"], "", "", ""])
    return "\n".join(f"| {' | '.join(row)} |" for row in rows)


def _row(c: Comparison) -> list[str]:
    cells = [c.flow.name]
    for scalar, digits in (("velocity", 2), ("contacts", 3)):
        ours, theirs = getattr(c.talus, scalar), getattr(c.lammps, scalar)
        cells += [
            mean_and_interval(ours, digits),
            mean_and_interval(theirs, digits),
            mean_and_interval(c.ratio(scalar), 3),
        ]
    cells.append(f"{100 * c.share('speed'):.0f} / {100 * c.share('packing'):.0f} %")
    cells.append(f"{100 * c.gap('speed'):.1f} / {100 * c.gap('packing'):.1f} %")
    return [
        *cells,
        f"{mean_and_interval(c.talus.drift, 2)} / {mean_and_interval(c.lammps.drift, 2)}",
    ]


def mean_and_interval(value: Estimate, digits: int) -> str:
    """Return a mean with its interval."""
    return f"{value.mean:.{digits}f} ± {value.half_width:.{digits}f}"
