"""Judges of Gallas' claims about the onset of transport, and where it lies in the runs.

In scans a bed is transported where its velocity exceeds five of its standard errors and 2 % of the
belt's velocity amplitude along x; for boundaries see `sim.sides`.
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import pi, radians, tan

import numpy as np
import pandas as pd
from uncertainties import UFloat

from sim.claims.evidence import Evidence
from sim.claims.lines import FLOWING, MARKERS, NONE, along, replicated
from sim.claims.place import Place, joined, measured
from sim.claims.verdict import SIGMAS, Check, Unbounded, Untestable, below, within

#: Pairs of damping and shear damping (g) whose onsets are compared.
PAIRS = ((50, 50), *MARKERS, (10, 50))

#: Share of the belt's velocity amplitude along x below which nothing is transported.
LEAST = 0.02

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


def onset(evidence: Evidence, **where: object) -> Onset:
    """Return where transport begins: from a boundary found by refinement, else from a scan.

    The interval over beds is Student's, not smaller than half a bracket. A boundary that was looked
    for in vain is not replaced by a scan.
    """
    try:
        return Onset(evidence.boundary("belt", "transport", "frequency", **where))
    except Unbounded:
        raise
    except Untestable as missing:
        line = _scanned(evidence, **where)
        if len(line) < 2:
            raise Untestable(f"{missing}, nor a scan of the frequency") from None
    moving = _bed_by_bed(line, _transported)
    brackets = np.array([_bracket(bed.dropna()) for _, bed in moving.iterrows()])
    over = SIGMAS * joined(brackets.mean(axis=1)).std_dev
    bracket = 0.5 * float(np.diff(brackets).mean())
    return Onset(measured(float(brackets.mean()), max(bracket, over)), tuple(line.values()))


def _scanned(evidence: Evidence, **where: object) -> dict[float, Place]:
    """Return the places along the frequency with several beds.

    Those of a single bed were added by refinement.
    """
    return replicated(evidence.line("belt", "frequency", **where))


def _bed_by_bed(line: dict[float, Place], measure: Callable[[Place], np.ndarray]) -> pd.DataFrame:
    """Return a number of every bed (row) at every frequency (column), NaN where a bed is unknown.

    Beds known at no more than half of the frequencies are left out: there are more beds where one
    says little, and a bed may have failed.
    """
    table = pd.DataFrame(
        {
            frequency: pd.Series(measure(place), place.values("replicate_seed"), dtype=float)
            for frequency, place in line.items()
        }
    )
    known = table[table.notna().sum(axis=1) > 0.5 * len(line)]
    if known.empty:
        raise Untestable("no bed is known at most frequencies of the scan")
    return known


def _bracket(moving: pd.Series) -> tuple[float, float]:
    """Return the frequencies between which a bed comes to flow at all that are higher.

    ``moving`` says per frequency whether it does.
    """
    frequencies = moving.index
    last = max((index for index, flows in enumerate(moving) if not flows), default=-1)
    if not 0 <= last < len(moving) - 1:
        least, most = frequencies[0], frequencies[-1]
        state = "flows" if last < 0 else "does not flow"
        end = f"lowest, {least:g}" if last < 0 else f"highest, {most:g}"
        raise Untestable(f"a bed {state} at the {end} Hz of the scan")
    return frequencies[last], frequencies[last + 1]


def _transported(place: Place) -> np.ndarray:
    """Return which beds are transported."""
    velocity = place.values("velocity")
    return (velocity > ERRORS * place.values("velocity_error")) & (
        velocity > LEAST * belt_speed_along_x(place)
    )


def belt_speed_along_x(place: Place) -> float:
    """Return the amplitude of the belt's velocity along x, A_x 2πf (m/s)."""
    amplitude = place["amplitude"] * place["diameter"] / tan(radians(place["vibration_angle"]))
    return amplitude * 2 * pi * place["frequency"]


def g3(evidence: Evidence) -> list[Check]:
    """The onset lies between 15 and 17 Hz at each of three angles."""
    return [
        _onset_within(evidence, f"onset at {angle} degrees", 15, 17, vibration_angle=angle)
        for angle in (30, 45, 60)
    ]


def _onset_within(evidence: Evidence, what: str, low: float, high: float, **where: object) -> Check:
    found = onset(evidence, **where)
    return within(what, found.frequency, low, high, found.places, "Hz")


def g4(evidence: Evidence) -> list[Check]:
    """The highest of five onsets at different damping is less than 1 Hz above the lowest."""
    found = {pair: onset(evidence, damping=pair[0], shear_damping=pair[1]) for pair in PAIRS}
    ranked = sorted(found, key=lambda pair: found[pair].frequency.nominal_value)
    low, high = ranked[0], ranked[-1]
    what = "onset at (γ, γ_s) = ({}g, {}g) less that at ({}g, {}g)".format(*high, *low)
    places = (*found[high].places, *found[low].places)
    return [below(what, found[high].frequency - found[low].frequency, 1, places, "Hz")]


def g5(evidence: Evidence) -> list[Check]:
    """At A_z = 1.5⟨d⟩ the onset is still that of ⟨d⟩, and nothing moves at 15 Hz."""
    still, flowing = along(evidence, "frequency", (15, 20), amplitude=1.5).values()
    ratio = still.velocity / flowing.velocity
    return [
        _onset_within(evidence, "onset at A_z = 1.5⟨d⟩", 15, 17, amplitude=1.5),
        within("V(15 Hz)/V(20 Hz) at A_z = 1.5⟨d⟩", ratio, -NONE, NONE, (still, flowing)),
    ]


def g6(evidence: Evidence) -> list[Check]:
    """At A_z = 0.5⟨d⟩ the onset lies between 17 and 19 Hz."""
    return [_onset_within(evidence, "onset at A_z = 0.5⟨d⟩", 17, 19, amplitude=0.5)]


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
    line = _scanned(evidence)
    if not {15, 16, 18, 20} <= set(line):
        raise Untestable("no scan of the frequency with 15, 16, 18 and 20 Hz")
    shares = _bed_by_bed(line, lambda place: place.values("velocity") / belt_speed_along_x(place))
    beds = [share.dropna() for _, share in shares.iterrows()]
    checks = []
    for part in RISE:
        reached = joined(
            np.array([_reaches(bed.index.to_numpy(), bed.to_numpy(), part) for bed in beds])
        )
        what = f"frequency at which V/(A_x ω) reaches {part:.0%} of its largest"
        checks.append(within(what, reached, *BAND, line.values(), "Hz"))
    up, down = onset(evidence), onset(evidence, prior_frequency=SWEPT_FROM)
    places = (*up.places, *down.places)
    shift = up.frequency - down.frequency
    return [*checks, within("onset from rest less that from the flow", shift, -1, 1, places, "Hz")]


def _reaches(frequencies: np.ndarray, share: np.ndarray, part: float) -> float:
    """Return where a curve first stays above a part of its largest value on the way up."""
    top = int(share.argmax())
    threshold = part * share[top]
    under = np.flatnonzero(share[:top] < threshold)
    if not under.size:
        return float(frequencies[0])
    last = under[-1]
    return float(np.interp(threshold, share[last : last + 2], frequencies[last : last + 2]))
