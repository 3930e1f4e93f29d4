"""Judges of Gallas' claims about the onset of transport, and where it lies in the runs.

Transport begins where the mean velocity of the beds comes to exceed five of its standard errors and
2 % of the belt's velocity amplitude along x. Single beds creep by more than that far below, to and
fro.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from itertools import combinations
from math import pi
from typing import Any

import numpy as np
import pandas as pd
from uncertainties import UFloat

from sim.base.statistics import student
from sim.claims.checks import within
from sim.claims.evidence import Evidence
from sim.claims.lines import FLOWING, MARKERS, NONE, along, replicated
from sim.claims.place import Place, measured, quotient
from sim.claims.verdict import SIGMAS, Check, Untestable
from sim.dataset.measures.belt import speed_along_x
from sim.parameters.belt import LEAST_TRANSPORT

#: Pairs of damping and shear damping (g) whose onsets are compared.
PAIRS = ((50, 50), *MARKERS, (10, 50))

#: Standard errors that a velocity must exceed.
ERRORS = 5

#: Frequency (Hz) from which the sweep down begins: well within the flow.
SWEPT_FROM = 25

#: The rise of the transport, relative to its largest, and the band (Hz) that holds it.
RISE, BAND = (0.1, 0.9), (16, 20)


@dataclass(frozen=True)
class Onset:
    """Frequency (Hz) at which transport begins, and the places that tell it, if any do."""

    frequency: UFloat
    places: tuple[Place, ...] = ()


def onset(evidence: Evidence, **where: Any) -> Onset:
    """Return where transport begins: from a scan or a boundary, whichever tells it better.

    The interval of a scan is that of the mean over beds, not smaller than half a step; that of a
    boundary is endless unless it was looked for from two seeds.
    """
    found, missing = [], []
    for source in (_from_scan, _from_boundary):
        try:
            found.append(source(evidence, **where))
        except Untestable as error:
            missing.append(str(error))
    if not found:
        raise Untestable("; ".join(missing))
    return min(found, key=lambda each: each.frequency.std_dev)


def _from_scan(evidence: Evidence, **where: Any) -> Onset:
    """Return where the mean over beds passes 2 % of the belt's velocity for good.

    The interval reaches as far as the frequency from which on it exceeds five standard errors.
    """
    shares, line = _scan(evidence, **where)
    found = _joined(shares, _begins)
    mean, errors = shares.mean(), shares.std(ddof=1) / np.sqrt(shares.notna().sum())
    unsure = mean.index[~(mean > ERRORS * errors).to_numpy()]
    clear = mean.index[mean.index > unsure.max()] if len(unsure) else mean.index
    if not len(clear):
        raise Untestable(f"beds are nowhere clear of rest up to {mean.index[-1]:g} Hz of the scan")
    begins, half_width = found.nominal_value, SIGMAS * found.std_dev
    if clear[0] > mean.index[mean.index > begins][0]:
        half_width = max(half_width, float(clear[0]) - begins)
    return Onset(measured(begins, half_width), tuple(line.values()))


def _from_boundary(evidence: Evidence, **where: Any) -> Onset:
    found = evidence.boundary("belt", "transport", "frequency", seeds=True, **where)
    return Onset(found)


def _scan(evidence: Evidence, **where: Any) -> tuple[pd.DataFrame, dict[float, Place]]:
    """Return V/(A_x ω) of every bed (row) at every frequency (column), and the places.

    Beds known at no more than half of the frequencies are left out: there are more beds where one
    says little, and a bed may have failed. Places of a single bed were added by refinement.
    """
    line = replicated(evidence.line("belt", "frequency", **where))
    table = pd.DataFrame(
        {
            frequency: pd.Series(
                place.values("velocity") / speed_along_x(place),
                place.values("replicate_seed"),
                dtype=float,
            )
            for frequency, place in line.items()
        }
    )
    known = table[table.notna().sum(axis=1) > 0.5 * len(line)]
    if len(line) < 2 or len(known) < 2:
        settings = ", ".join(f"{name} {value}" for name, value in where.items())
        raise Untestable(f"no scan of the frequency with two beds {settings}".rstrip())
    return known, line


def _joined(shares: pd.DataFrame, place: Callable[[pd.DataFrame], tuple[float, float]]) -> UFloat:
    """Return a frequency of the mean over beds with its 95 % interval.

    ``place`` gives the frequency and the step of the scan there. How much it changes as each bed
    is left out tells the interval (jackknife).
    """
    value, step = place(shares)
    beds = len(shares)
    without = [place(shares.drop(bed))[0] for bed in shares.index]
    error = np.sqrt((beds - 1) * np.var(without))
    return measured(value, float(max(student(beds - 1) * error, 0.5 * step)))


def _begins(shares: pd.DataFrame) -> tuple[float, float]:
    """Return the frequency from which on beds are transported, and the step of the scan there."""
    mean = shares.mean()
    moves = (mean > LEAST_TRANSPORT).to_numpy()
    frequencies, still = mean.index.to_numpy(), np.flatnonzero(~moves)
    if not still.size or still[-1] == len(moves) - 1:
        end = "lowest" if not still.size else "highest"
        state = "flow" if not still.size else "do not flow"
        edge = frequencies[0 if not still.size else -1]
        raise Untestable(f"beds {state} at the {end}, {edge:g} Hz of the scan")
    before = still[-1]
    low, high = frequencies[before : before + 2]
    under, over = mean.iloc[before], mean.iloc[before + 1]
    return float(low + (LEAST_TRANSPORT - under) / (over - under) * (high - low)), float(high - low)


def g3(evidence: Evidence) -> list[Check]:
    """The onset lies between 15 and 17 Hz at each of three angles."""
    return [
        _beginswithin(evidence, f"onset at {angle} degrees", 15, 17, vibration_angle=angle)
        for angle in (30, 45, 60)
    ]


def _beginswithin(evidence: Evidence, what: str, low: float, high: float, **where: Any) -> Check:
    found = onset(evidence, **where)
    return within(what, found.frequency, low, high, found.places, "Hz")


def g4(evidence: Evidence) -> list[Check]:
    """Of five onsets at different damping no two differ by 1 Hz."""
    found = {pair: onset(evidence, damping=pair[0], shear_damping=pair[1]) for pair in PAIRS}
    checks = []
    for one, other in combinations(found, 2):
        what = "onset at (γ, γ_s) = ({}g, {}g) less that at ({}g, {}g)".format(*one, *other)
        places = (*found[one].places, *found[other].places)
        apart = found[one].frequency - found[other].frequency
        checks.append(within(what, apart, -1, 1, places, "Hz"))
    return checks


def g5(evidence: Evidence) -> list[Check]:
    """At A_z = 1.5⟨d⟩ the onset is still that of ⟨d⟩, and nothing moves at 15 Hz."""
    still, flowing = along(evidence, "frequency", (15, 20), amplitude=1.5).values()
    ratio = quotient(still.velocity, flowing.velocity)
    return [
        _beginswithin(evidence, "onset at A_z = 1.5⟨d⟩", 15, 17, amplitude=1.5),
        within("V(15 Hz)/V(20 Hz) at A_z = 1.5⟨d⟩", ratio, -NONE, NONE, (still, flowing)),
    ]


def g6(evidence: Evidence) -> list[Check]:
    """At A_z = 0.5⟨d⟩ the onset lies between 17 and 19 Hz."""
    return [_beginswithin(evidence, "onset at A_z = 0.5⟨d⟩", 17, 19, amplitude=0.5)]


def g7(evidence: Evidence) -> list[Check]:
    """The acceleration of the belt at the onset is about that of gravity."""
    found = onset(evidence)
    place = evidence.at("belt", frequency=FLOWING)
    lift = place["amplitude"] * place["diameter"] / place["gravity"]
    gamma = (2 * pi * found.frequency) ** 2 * lift
    return [within("Γ at the onset", gamma, 0.9, 1.15, found.places)]


def g35(evidence: Evidence) -> list[Check]:
    """V/(A_x ω) rises from a tenth to nine tenths of its largest between 16 and 20 Hz.

    The same onset must be found coming from rest and coming down from a flow at 25 Hz.
    """
    shares, line = _scan(evidence)
    if not {15, 16, 18, 20} <= set(line):
        raise Untestable("no scan of the frequency with 15, 16, 18 and 20 Hz")
    checks = []
    for part in RISE:
        reached = _joined(shares, partial(_reaches, part=part))
        what = f"frequency at which V/(A_x ω) reaches {part:.0%} of its largest"
        checks.append(within(what, reached, *BAND, line.values(), "Hz"))
    up, down = onset(evidence), onset(evidence, prior_frequency=SWEPT_FROM)
    places = (*up.places, *down.places)
    shift = up.frequency - down.frequency
    return [*checks, within("onset from rest less that from the flow", shift, -1, 1, places, "Hz")]


def _reaches(shares: pd.DataFrame, part: float) -> tuple[float, float]:
    """Return where the mean over beds comes to stay above a part of its largest, and no step."""
    mean = shares.mean()
    frequencies, share = mean.index.to_numpy(), mean.to_numpy()
    top = int(share.argmax())
    threshold = part * share[top]
    under = np.flatnonzero(share[:top] < threshold)
    if not under.size:
        return float(frequencies[0]), 0.0
    last = under[-1]
    place = np.interp(threshold, share[last : last + 2], frequencies[last : last + 2])
    return float(place), 0.0
