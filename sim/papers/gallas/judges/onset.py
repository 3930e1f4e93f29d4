"""Judges of Gallas' claims about the onset of transport, and where it lies in the runs.

Transport begins where the mean velocity of the beds exceeds a share of the belt's velocity
amplitude along x and stays above it. The paper gives no share; judges take it as ``threshold``.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from itertools import combinations
from math import pi
from typing import Any

import numpy as np
import pandas as pd
from uncertainties import UFloat

from sim.base.statistics import student
from sim.claims.checks import Numbers, Pair, below, judge_parts, within
from sim.claims.evidence import Evidence
from sim.claims.place import Place, quotient, select_replicated, with_interval
from sim.claims.verdict import Check, Untestable
from sim.measures.belt import speed_along_x
from sim.papers.gallas.judges.lines import (
    HALF_SYSTEM,
    MIN_FLOW_FREQUENCY,
    complete_line,
    pair_label,
)
from sim.parameters.belt import ONSET_TRANSPORT

#: Largest step (Hz) of a scan from which an onset is read.
FINE_STEP = 1.0


@dataclass(frozen=True)
class Onset:
    """Frequency (Hz) at which transport begins, and the places of the scan behind it, if any.

    ``coarse`` is true where the interval is the step of the scan, not the scatter of the beds.
    ``protocol`` is that of the runs.
    """

    frequency: UFloat
    protocol: str
    places: tuple[Place, ...] = ()
    coarse: bool = False


def find_onset(evidence: Evidence, threshold: float, **where: Any) -> Onset:
    """Return the onset of transport from a scan or a boundary, whichever is more precise.

    The interval of a scan is that of the mean over beds, at least half a step. That of a boundary
    is infinite unless it was searched from two seeds. Boundaries exist for `ONSET_TRANSPORT` alone.
    """
    onsets, reasons = [], []
    try:
        shares, line = _scan(evidence, **where)
        frequency, is_coarse = _jackknife(shares, partial(_onset_frequency, threshold=threshold))
        onsets.append(Onset(frequency, evidence.protocol, tuple(line.values()), is_coarse))
    except Untestable as error:
        reasons.append(str(error))
    if threshold == ONSET_TRANSPORT:
        try:
            frequency = evidence.boundary("belt", "transport", "frequency", **where)
            onsets.append(Onset(frequency, evidence.protocol))
        except Untestable as error:
            reasons.append(str(error))
    if not onsets:
        raise Untestable("; ".join(reasons))
    return min(onsets, key=lambda onset: onset.frequency.std_dev)


def _scan(evidence: Evidence, **where: Any) -> tuple[pd.DataFrame, dict[float, Place]]:
    """Return V/(A_x ω) of every bed (row) at every frequency (column), and the places.

    Beds with runs at no more than half of the frequencies are left out: some frequencies have
    additional beds, and a bed may have failed. Then frequencies with a single bed are left out.
    """
    line = select_replicated(evidence.line("belt", "frequency", **where))
    beds = _shares_of_beds(tuple(line.items()))
    if beds.shape[1] < 2:
        settings = ", ".join(f"{name} {value}" for name, value in where.items())
        raise Untestable(f"no scan of the frequency with two beds {settings}".rstrip())
    return beds, {frequency: line[frequency] for frequency in beds}


@lru_cache(maxsize=1000)
def _shares_of_beds(line: tuple[tuple[float, Place], ...]) -> pd.DataFrame:
    """Return the table of `_scan` for the places of a line; judges ask for it again and again."""
    table = pd.DataFrame(
        {
            frequency: pd.Series(
                place.values("velocity") / speed_along_x(place),
                place.values("replicate_seed"),
                dtype=float,
            )
            for frequency, place in line
        }
    )
    beds = table[table.count(axis=1) > 0.5 * len(line)]
    return beds.loc[:, beds.count() > 1]


def _jackknife(
    shares: pd.DataFrame, locate: Callable[[np.ndarray, np.ndarray], Pair]
) -> tuple[UFloat, bool]:
    """Return a frequency of the mean over beds with its interval; true if a step limits it.

    ``locate`` gets the frequencies (F,) and the means over beds (F,), and returns the frequency and
    the step of the scan there. The 95 % interval follows from the changes as each bed is left out
    (jackknife), with the degrees of freedom of the frequency that has the fewest beds. It is half a
    step at least.
    """
    frequencies, beds = shares.columns.to_numpy(), shares.to_numpy()
    value, step = locate(frequencies, np.nanmean(beds, axis=0))
    leave_one_out = [
        locate(frequencies, np.nanmean(np.delete(beds, bed, axis=0), axis=0))[0]
        for bed in range(len(beds))
    ]
    error = np.sqrt((len(beds) - 1) * np.var(leave_one_out))
    scatter = float(student(shares.count().min() - 1) * error)
    return with_interval(value, max(scatter, 0.5 * step)), scatter < 0.5 * step


def _onset_frequency(frequencies: np.ndarray, shares: np.ndarray, threshold: float) -> Pair:
    """Return the frequency from which on beds are transported, and the step of the scan there."""
    at_rest = np.flatnonzero(~(shares > threshold))
    if not at_rest.size:
        raise Untestable(f"beds flow at the lowest, {frequencies[0]:g} Hz of the scan")
    if at_rest[-1] == len(shares) - 1:
        raise Untestable(f"beds do not flow at the highest, {frequencies[-1]:g} Hz of the scan")
    before = at_rest[-1]
    low, high = frequencies[before : before + 2]
    if high - low > FINE_STEP:
        raise Untestable(f"no scan in steps of {FINE_STEP:g} Hz between {low:g} and {high:g} Hz")
    share_below, share_above = shares[before : before + 2]
    onset = low + (threshold - share_below) / (share_above - share_below) * (high - low)
    return float(onset), float(high - low)


def g3(
    evidence: Evidence, *, threshold: float, low: float, high: float, angles: Numbers
) -> list[Check]:
    """The onset lies between two frequencies (Hz) at each angle."""
    checks = []
    for angle in angles:
        onset = find_onset(evidence, threshold, vibration_angle=angle)
        checks.append(_check_onset(onset, f"{angle} degrees", low, high))
    return checks


def _check_onset(onset: Onset, label: str, low: float, high: float) -> Check:
    quantity = f"onset at {label}, {onset.protocol} runs"
    check = within(quantity, onset.frequency, low, high, onset.places, "Hz")
    return _mark_coarse(check, onset)


def _mark_coarse(check: Check, *onsets: Onset) -> Check:
    """Return a check marked as coarse where the step of a scan limits one of its onsets."""
    return replace(check, coarse=any(onset.coarse for onset in onsets))


def g4(
    evidence: Evidence, *, threshold: float, pairs: Sequence[Pair], max_difference: float
) -> list[Check]:
    """Any two onsets at different damping are less than ``max_difference`` (Hz) apart.

    ``pairs`` are damping and shear damping (g).
    """
    onsets = {
        (damping, shear): find_onset(evidence, threshold, damping=damping, shear_damping=shear)
        for damping, shear in pairs
    }
    checks = []
    for first, second in combinations(onsets, 2):
        difference = onsets[first].frequency - onsets[second].frequency
        quantity = f"onset at (γ, γ_s) = {pair_label(*first)} less that at {pair_label(*second)}"
        quantity += f", {onsets[first].protocol} runs"
        places = (*onsets[first].places, *onsets[second].places)
        check = within(quantity, difference, -max_difference, max_difference, places, "Hz")
        checks.append(_mark_coarse(check, onsets[first], onsets[second]))
    return checks


def g5(
    evidence: Evidence,
    *,
    threshold: float,
    low: float,
    high: float,
    frequencies: Pair,
    max_ratio: float,
) -> list[Check]:
    """At A_z = 1.5⟨d⟩ the onset is that of ⟨d⟩ (a), and nothing moves at 15 Hz (b).

    V at the first of two frequencies (Hz) is below ``max_ratio`` times V at the second.
    """

    def begins() -> list[Check]:
        onset = find_onset(evidence, threshold, amplitude=1.5)
        return [_check_onset(onset, "A_z = 1.5⟨d⟩", low, high)]

    def rests() -> list[Check]:
        still, flowing = complete_line(evidence, "frequency", frequencies, amplitude=1.5).values()
        ratio = quotient(still.velocity, flowing.velocity)
        quantity = "V({} Hz)/V({} Hz) at A_z = 1.5⟨d⟩".format(*frequencies)
        return [within(quantity, ratio, -max_ratio, max_ratio, (still, flowing))]

    return judge_parts(a=begins, b=rests)


def g6(
    evidence: Evidence, *, threshold: float, low: float, high: float, gamma: float, max_error: float
) -> list[Check]:
    """At A_z = 0.5⟨d⟩ the onset is at 18 Hz (a), and Γ there is 0.8 (b), both within margins."""
    allowed = gamma - max_error, gamma + max_error
    onset = find_onset(evidence, threshold, amplitude=0.5)
    place = evidence.at("belt", frequency=MIN_FLOW_FREQUENCY, amplitude=0.5)
    return judge_parts(
        a=lambda: [_check_onset(onset, "A_z = 0.5⟨d⟩", low, high)],
        b=lambda: [_check_gamma(onset, place, ", A_z = 0.5⟨d⟩", *allowed)],
    )


def _check_gamma(onset: Onset, place: Place, label: str, low: float, high: float) -> Check:
    quantity = f"Γ at the onset{label}, {onset.protocol} runs"
    lift = place["amplitude"] * place["diameter"] / place["gravity"]
    gamma = (2 * pi * onset.frequency) ** 2 * lift
    return _mark_coarse(within(quantity, gamma, low, high, onset.places), onset)


def g7(evidence: Evidence, *, threshold: float, low: float, high: float) -> list[Check]:
    """The acceleration of the belt at the onset is about that of gravity."""
    onset = find_onset(evidence, threshold)
    place = evidence.at("belt", frequency=MIN_FLOW_FREQUENCY)
    return [_check_gamma(onset, place, "", low, high)]


def g14(
    evidence: Evidence, *, threshold: float, max_change: float, lowest: float, max_shift: float
) -> list[Check]:
    """Half the beads on half the belt: same velocity from ``lowest`` (Hz) on, same onset.

    V changes by less than ``max_change``, relative to V, and the onset by ``max_shift`` (Hz).
    """
    halved = select_replicated(evidence.line("belt", "frequency", **HALF_SYSTEM))
    whole = select_replicated(evidence.line("belt", "frequency"))
    shared = [frequency for frequency in sorted(set(halved) & set(whole)) if frequency >= lowest]
    if not shared:
        raise Untestable(f"no frequency from {lowest} Hz on with 100 beads on a width of 10")
    checks = []
    for frequency in shared:
        places = halved[frequency], whole[frequency]
        change = quotient(places[0].velocity, places[1].velocity) - 1
        quantity = f"V of the halved system over the whole, less 1, {frequency:g} Hz"
        checks.append(within(quantity, change, -max_change, max_change, places))
    small, usual = find_onset(evidence, threshold, **HALF_SYSTEM), find_onset(evidence, threshold)
    shift = small.frequency - usual.frequency
    both = (*small.places, *usual.places)
    quantity = f"onset of the halved system less the whole, {usual.protocol} runs"
    check = within(quantity, shift, -max_shift, max_shift, both, "Hz")
    return [*checks, _mark_coarse(check, small, usual)]


def g35(
    evidence: Evidence,
    *,
    threshold: float,
    rise: Pair,
    max_width: float,
    sweep_start: float,
    max_shift: float,
) -> list[Check]:
    """V/(A_x ω) rises between two shares of its maximum within ``max_width`` of the middle.

    The onset from rest and that coming down from a flow at ``sweep_start`` (Hz) must be less than
    ``max_shift`` (Hz) apart.
    """
    shares, line = _scan(evidence)
    if not {15, 16, 18, 20} <= set(line):
        raise Untestable("no scan of the frequency with 15, 16, 18 and 20 Hz")
    up = find_onset(evidence, threshold)
    down = find_onset(evidence, threshold, prior_frequency=sweep_start)
    places, shift = (*up.places, *down.places), up.frequency - down.frequency
    width, _ = _jackknife(shares, partial(_rise_width, rise=rise))
    low, high = (100 * share for share in rise)
    quantity = f"width of the rise of V/(A_x ω) from {low:g} to {high:g} %, over its middle"
    sweep = f"onset from rest less that from the flow, {up.protocol} runs"
    return [
        below(quantity, width, max_width, line.values()),
        _mark_coarse(within(sweep, shift, -max_shift, max_shift, places, "Hz"), up, down),
    ]


def _rise_width(frequencies: np.ndarray, shares: np.ndarray, rise: Pair) -> Pair:
    """Return the width of the rise over its middle, and a step of zero."""
    low, high = (_crossing_frequency(frequencies, shares, fraction) for fraction in rise)
    return (high - low) / (0.5 * (high + low)), 0.0


def _crossing_frequency(frequencies: np.ndarray, shares: np.ndarray, fraction: float) -> float:
    """Return where the mean over beds rises above a fraction of its maximum and stays above."""
    top = int(shares.argmax())
    threshold = fraction * shares[top]
    below = np.flatnonzero(shares[:top] < threshold)
    if not below.size:
        return float(frequencies[0])
    before = below[-1]
    around = slice(before, before + 2)
    return float(np.interp(threshold, shares[around], frequencies[around]))
