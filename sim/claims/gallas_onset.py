"""Judges of Gallas' claims about the onset of transport, and where it lies in the runs.

Transport begins where the mean velocity of the beds comes to exceed a share of the belt's velocity
amplitude along x, for good. The paper gives none; judges take it as ``least``.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from itertools import combinations
from math import pi
from typing import Any

import numpy as np
import pandas as pd
from uncertainties import UFloat

from sim.base.statistics import student
from sim.claims.checks import below, in_parts, within
from sim.claims.evidence import Evidence
from sim.claims.lines import FLOWING, HALVED, MARKERS, NONE, along, replicated
from sim.claims.place import Place, measured, quotient
from sim.claims.verdict import Check, Untestable
from sim.dataset.measures.belt import speed_along_x
from sim.parameters.belt import ONSET_TRANSPORT

#: Pairs of damping and shear damping (g) whose onsets are compared.
PAIRS = ((50, 50), *MARKERS, (10, 50))

#: Largest step (Hz) of a scan that tells an onset.
FINE = 1.0

#: Largest difference (Hz) of onsets that are the same.
SAME = 1.0

#: Frequency (Hz) from which the sweep down begins: well within the flow.
SWEPT_FROM = 25

#: The rise of the transport, relative to its largest, and its largest width relative to its middle.
RISE, SHARP = (0.1, 0.9), 0.3

#: Onset (Hz) and Γ there that the paper states for half the amplitude, with the margin of each.
SMALLER = {"a": (18, 1), "b": (0.8, 0.1)}


@dataclass(frozen=True)
class Onset:
    """Frequency (Hz) at which transport begins, and the places that tell it, if any do.

    ``coarse`` where its interval is the step of the scan, not what beds differ by.
    """

    frequency: UFloat
    places: tuple[Place, ...] = ()
    coarse: bool = False


def onset(evidence: Evidence, least: float, **where: Any) -> Onset:
    """Return where transport begins: from a scan or a boundary, whichever tells it better.

    The interval of a scan is that of the mean over beds, not smaller than half a step; that of a
    boundary is endless unless it was looked for from two seeds. Boundaries are those of
    `ONSET_TRANSPORT`.
    """
    found, missing = [], []
    sources: list[Callable[..., Onset]] = [partial(_from_scan, least=least)]
    sources += [_from_boundary] if least == ONSET_TRANSPORT else []
    for source in sources:
        try:
            found.append(source(evidence, **where))
        except Untestable as error:
            missing.append(str(error))
    if not found:
        raise Untestable("; ".join(missing))
    return min(found, key=lambda each: each.frequency.std_dev)


def _from_scan(evidence: Evidence, least: float, **where: Any) -> Onset:
    """Return where the mean over beds passes a share of the belt's velocity for good."""
    shares, line = _scan(evidence, **where)
    frequency, coarse = _joined(shares, partial(_begins, least=least))
    return Onset(frequency, tuple(line.values()), coarse)


def _from_boundary(evidence: Evidence, **where: Any) -> Onset:
    found = evidence.boundary("belt", "transport", "frequency", seeds=True, **where)
    return Onset(found)


def _scan(evidence: Evidence, **where: Any) -> tuple[pd.DataFrame, dict[float, Place]]:
    """Return V/(A_x ω) of every bed (row) at every frequency (column), and the places.

    Beds known at no more than half of the frequencies are left out: there are more beds where one
    says little, and a bed may have failed; then places of a single bed.
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
    known = table[table.count(axis=1) > 0.5 * len(line)]
    known = known.loc[:, known.count() > 1]
    if known.shape[1] < 2:
        settings = ", ".join(f"{name} {value}" for name, value in where.items())
        raise Untestable(f"no scan of the frequency with two beds {settings}".rstrip())
    return known, {frequency: line[frequency] for frequency in known}


def _joined(
    shares: pd.DataFrame, place: Callable[[pd.DataFrame], tuple[float, float]]
) -> tuple[UFloat, bool]:
    """Return a frequency of the mean over beds with its 95 % interval, and whether a step gives it.

    ``place`` gives the frequency and the step of the scan there. How much it changes as each bed
    is left out tells the interval (jackknife), with the freedom of the frequency that has the
    fewest; it is half a step at least.
    """
    value, step = place(shares)
    beds = len(shares)
    without = [place(shares.drop(bed))[0] for bed in shares.index]
    error = np.sqrt((beds - 1) * np.var(without))
    scatter = float(student(shares.count().min() - 1) * error)
    return measured(value, max(scatter, 0.5 * step)), scatter < 0.5 * step


def _begins(shares: pd.DataFrame, least: float) -> tuple[float, float]:
    """Return the frequency from which on beds are transported, and the step of the scan there."""
    mean = shares.mean()
    moves = (mean > least).to_numpy()
    frequencies, still = mean.index.to_numpy(), np.flatnonzero(~moves)
    if not still.size or still[-1] == len(moves) - 1:
        end = "lowest" if not still.size else "highest"
        state = "flow" if not still.size else "do not flow"
        edge = frequencies[0 if not still.size else -1]
        raise Untestable(f"beds {state} at the {end}, {edge:g} Hz of the scan")
    before = still[-1]
    low, high = frequencies[before : before + 2]
    if high - low > FINE:
        raise Untestable(f"no scan in steps of {FINE:g} Hz between {low:g} and {high:g} Hz")
    under, over = mean.iloc[before], mean.iloc[before + 1]
    return float(low + (least - under) / (over - under) * (high - low)), float(high - low)


def g3(evidence: Evidence, least: float) -> list[Check]:
    """The onset lies between 15 and 17 Hz at each of three angles."""
    return [
        _begins_within(evidence, least, f"{angle} degrees", vibration_angle=angle)
        for angle in (30, 45, 60)
    ]


def _begins_within(evidence: Evidence, least: float, at: str, **where: Any) -> Check:
    found = onset(evidence, least, **where)
    return _scanned(within(f"onset at {at}", found.frequency, 15, 17, found.places, "Hz"), found)


def _scanned(check: Check, *onsets: Onset) -> Check:
    """Return a check that says whether the step of a scan is the interval of an onset behind it."""
    return replace(check, coarse=any(one.coarse for one in onsets))


def g4(evidence: Evidence, least: float) -> list[Check]:
    """Any two of five onsets at different damping are less than 1 Hz apart."""
    found = {pair: onset(evidence, least, damping=pair[0], shear_damping=pair[1]) for pair in PAIRS}
    checks = []
    for one, other in combinations(found, 2):
        apart = found[one].frequency - found[other].frequency
        what = f"onset at (γ, γ_s) = {_pair(one)} less that at {_pair(other)}"
        places = (*found[one].places, *found[other].places)
        check = within(what, apart, -SAME, SAME, places, "Hz")
        checks.append(_scanned(check, found[one], found[other]))
    return checks


def _pair(pair: tuple[float, float]) -> str:
    return "({:g}g, {:g}g)".format(*pair)


def g5(evidence: Evidence, least: float) -> list[Check]:
    """At A_z = 1.5⟨d⟩ the onset is still that of ⟨d⟩ (a), and nothing moves at 15 Hz (b)."""
    return in_parts(
        a=lambda: [_begins_within(evidence, least, "A_z = 1.5⟨d⟩", amplitude=1.5)],
        b=lambda: _still_below(evidence),
    )


def _still_below(evidence: Evidence) -> list[Check]:
    still, flowing = along(evidence, "frequency", (15, 20), amplitude=1.5).values()
    ratio = quotient(still.velocity, flowing.velocity)
    return [within("V(15 Hz)/V(20 Hz) at A_z = 1.5⟨d⟩", ratio, -NONE, NONE, (still, flowing))]


def g6(evidence: Evidence, least: float) -> list[Check]:
    """At A_z = 0.5⟨d⟩ the onset against 18 Hz (a), and Γ there against 0.8 (b)."""
    found = onset(evidence, least, amplitude=0.5)
    place = evidence.at("belt", frequency=FLOWING, amplitude=0.5)
    checks = {}
    for part, what, value, unit in (
        ("a", "onset at A_z = 0.5⟨d⟩", found.frequency, "Hz"),
        ("b", "Γ at the onset, A_z = 0.5⟨d⟩", _gamma(found, place), ""),
    ):
        stated, margin = SMALLER[part]
        bounds = stated - margin, stated + margin
        checks[part] = [_scanned(within(what, value, *bounds, found.places, unit), found)]
    return in_parts(**{part: lambda found=found: found for part, found in checks.items()})


def _gamma(found: Onset, place: Place) -> UFloat:
    """Return 4π²f²A_z/g at an onset, with the amplitude of a place."""
    lift = place["amplitude"] * place["diameter"] / place["gravity"]
    return (2 * pi * found.frequency) ** 2 * lift


def g7(evidence: Evidence, least: float) -> list[Check]:
    """The acceleration of the belt at the onset is about that of gravity."""
    found = onset(evidence, least)
    gamma = _gamma(found, evidence.at("belt", frequency=FLOWING))
    return [_scanned(within("Γ at the onset", gamma, 0.9, 1.15, found.places), found)]


def g14(evidence: Evidence, least: float) -> list[Check]:
    """Half the beads on half the belt: same velocity within 10 %, same onset within 1 Hz."""
    halved = replicated(evidence.line("belt", "frequency", **HALVED))
    whole = replicated(evidence.line("belt", "frequency"))
    shared = [each for each in sorted(set(halved) & set(whole)) if each >= FLOWING]
    if not shared:
        raise Untestable("no frequency from 20 Hz on with 100 beads on a width of 10")
    checks = []
    for frequency in shared:
        places = halved[frequency], whole[frequency]
        change = quotient(places[0].velocity, places[1].velocity) - 1
        what = f"V of the halved system over the whole, less 1, {frequency:g} Hz"
        checks.append(within(what, change, -0.1, 0.1, places))
    small, usual = onset(evidence, least, **HALVED), onset(evidence, least)
    shift = small.frequency - usual.frequency
    both = (*small.places, *usual.places)
    check = within("onset of the halved system less the whole", shift, -1, 1, both, "Hz")
    return [*checks, _scanned(check, small, usual)]


def g35(evidence: Evidence, least: float) -> list[Check]:
    """V/(A_x ω) rises from a tenth to nine tenths of its largest within 30 % of the middle.

    The same onset must be found coming from rest and coming down from a flow at 25 Hz.
    """
    shares, line = _scan(evidence)
    if not {15, 16, 18, 20} <= set(line):
        raise Untestable("no scan of the frequency with 15, 16, 18 and 20 Hz")
    up = onset(evidence, least)
    down = onset(evidence, least, prior_frequency=SWEPT_FROM)
    places, shift = (*up.places, *down.places), up.frequency - down.frequency
    width, _ = _joined(shares, _width)
    what = "width of the rise of V/(A_x ω) from 10 to 90 %, over its middle"
    check = within("onset from rest less that from the flow", shift, -SAME, SAME, places, "Hz")
    return [
        below(what, width, SHARP, line.values()),
        _scanned(check, up, down),
    ]


def _width(shares: pd.DataFrame) -> tuple[float, float]:
    """Return the width of the rise over its middle, and no step."""
    low, high = (_reaches(shares, part) for part in RISE)
    return (high - low) / (0.5 * (high + low)), 0.0


def _reaches(shares: pd.DataFrame, part: float) -> float:
    """Return where the mean over beds comes to stay above a part of its largest."""
    mean = shares.mean()
    frequencies, share = mean.index.to_numpy(), mean.to_numpy()
    top = int(share.argmax())
    threshold = part * share[top]
    under = np.flatnonzero(share[:top] < threshold)
    if not under.size:
        return float(frequencies[0])
    last = under[-1]
    return float(np.interp(threshold, share[last : last + 2], frequencies[last : last + 2]))
