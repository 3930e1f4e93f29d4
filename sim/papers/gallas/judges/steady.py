"""Judges of Gallas' claims on what the steady velocity depends on: belt, damping, start."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import combinations
from math import pi, radians, tan

from uncertainties import UFloat

from sim.claims.checks import Numbers, Pair, above, judge_parts, within
from sim.claims.evidence import Evidence
from sim.claims.place import Place, quotient, select_replicated
from sim.claims.verdict import Check, Untestable
from sim.papers.gallas.judges.lines import bed, pair_label, velocity_trend
from sim.papers.gallas.judges.velocity import fastest_start

#: Frequencies (Hz) of a curve that are needed, just after its jump and at its end.
ENDS = (25, 80)


def g37(evidence: Evidence, *, max_change: float, angles: Numbers, lowest: float) -> list[Check]:
    """V over the belt's horizontal velocity is the same at all angles (degrees).

    That is at each frequency from ``lowest`` (Hz) on at which all angles have been run: any two
    differ by less than ``max_change``.
    """
    lines = [
        select_replicated(evidence.line("belt", "frequency", vibration_angle=angle))
        for angle in angles
    ]
    shared = [f for f in sorted(set.intersection(*map(set, lines))) if f >= lowest]
    if not shared:
        raise Untestable(f"no frequency from {lowest:g} Hz on at all angles")
    return [
        within(
            f"V/(A_x ω), {one['vibration_angle']:g}° over {two['vibration_angle']:g}°, {f:g} Hz,"
            " less 1",
            quotient(transport(one), transport(two)) - 1,
            -max_change,
            max_change,
            (one, two),
        )
        for f in shared
        for one, two in combinations([line[f] for line in lines], 2)
    ]


def transport(place: Place) -> UFloat:
    """Return V/(A_x ω), the mean velocity over the largest horizontal one of the belt."""
    reach = place["amplitude"] * place["diameter"] / tan(radians(place["vibration_angle"]))
    return place.velocity / (2 * pi * place["frequency"] * reach)


def g38(
    evidence: Evidence,
    *,
    min_ratio: float,
    pairs: Sequence[Pair],
    jump: Pair,
    lowest: float,
    highest: float,
    margin: float,
) -> list[Check]:
    """At each pair of damping and shear damping (g) V jumps (a), and then rises (b).

    It jumps where it rises ``min_ratio`` times as steeply between the two frequencies of the
    ``jump`` (Hz) as from there to the ``highest``; it then rises from the ``lowest`` on.
    """
    lines = {
        pair_label(damping, shear): select_replicated(
            evidence.line("belt", "frequency", damping=damping, shear_damping=shear)
        )
        for damping, shear in pairs
    }

    def jumps() -> list[Check]:
        checks = []
        for label, line in lines.items():
            places = [_on(line, f, label) for f in (*jump, highest)]
            steep, gentle = (_slope(*places[first : first + 2]) for first in (0, 1))
            quantity = f"slope of V, {jump[0]:g} to {jump[1]:g} Hz, less {min_ratio:g} times that"
            quantity = f"{quantity} from there to {highest:g} Hz, {label}"
            checks.append(above(quantity, steep - min_ratio * gentle, 0, places, "m/s/Hz"))
        return checks

    def rises() -> list[Check]:
        checks = []
        for label, line in lines.items():
            for frequency in ENDS:
                _on(line, frequency, label)
            flowing = {f: place for f, place in line.items() if f >= lowest}
            check = velocity_trend(flowing, "f (Hz)", margin=margin, unit="Hz")
            checks.append(replace(check, what=f"{check.what}, {label}"))
        return checks

    return judge_parts(a=jumps, b=rises)


def _on(line: dict[float, Place], frequency: float, label: str) -> Place:
    if frequency not in line:
        raise Untestable(f"no several beds at {frequency:g} Hz, {label}")
    return line[frequency]


def _slope(low: Place, high: Place) -> UFloat:
    return (high.velocity - low.velocity) / (high["frequency"] - low["frequency"])


def g39(
    evidence: Evidence, *, max_change: float, frequency: float, pairs: Sequence[Pair]
) -> list[Check]:
    """Beds that start faster than they end have, in the end, the V of those that start at rest."""
    checks = []
    for damping, shear in pairs:
        where = {"damping": damping, "shear_damping": shear}
        places = (
            fastest_start(evidence, frequency=frequency, **where),
            bed(evidence, frequency, **where),
        )
        change = quotient(*(place.velocity for place in places)) - 1
        quantity = f"V started fast over that from rest, less 1, {pair_label(damping, shear)}"
        checks.append(within(quantity, change, -max_change, max_change, places))
    return checks
