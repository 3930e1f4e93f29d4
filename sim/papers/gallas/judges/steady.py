"""Judges of Gallas' claims on what the steady velocity depends on: belt, damping, start."""

from collections.abc import Sequence
from contextlib import suppress
from itertools import combinations
from math import pi, radians, tan

import numpy as np
from uncertainties import UFloat

from sim.claims.checks import Numbers, Pair, above, judge_parts, within
from sim.claims.evidence import Evidence
from sim.claims.place import Place, quotient, select_replicated
from sim.claims.verdict import Check, Untestable
from sim.papers.gallas.judges.flux import determination
from sim.papers.gallas.judges.lines import bed, pair_label
from sim.papers.gallas.judges.velocity import fastest_start


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
    angles: Numbers,
    pairs: Sequence[Pair],
    amplitudes: Numbers,
    jump: Pair,
    straight: Pair,
    min_r2: float,
) -> list[Check]:
    """V jumps (a) and in the end grows linearly (b) along the curves beside the usual one.

    They are those of other angles (degrees), pairs of damping and shear damping (g), and for (b)
    amplitudes (⟨d⟩). V jumps where it rises ``min_ratio`` times as steeply between the frequencies
    (Hz) of the ``jump`` as from there to the end; it is ``straight`` between two others.
    """
    alike: list[dict[str, float]] = [
        *({"vibration_angle": angle} for angle in angles),
        *({"damping": damping, "shear_damping": shear} for damping, shear in pairs),
    ]
    others = [{"amplitude": amplitude} for amplitude in amplitudes]

    def curve(setting: dict[str, float]) -> tuple[str, dict[float, Place]]:
        line = select_replicated(evidence.line("belt", "frequency", **setting))
        needed = {*jump, straight[1]} if setting in alike else {*straight}
        label = ", ".join(f"{name.replace('_', ' ')} {value:g}" for name, value in setting.items())
        if not line.keys() >= needed:
            raise Untestable(f"no several beds at {sorted(needed)} Hz, {label}")
        return label, line

    def jumps() -> list[Check]:
        checks = []
        for label, line in map(curve, alike):
            low, high, end = places = [line[f] for f in (*jump, straight[1])]
            excess = _slope(low, high) - min_ratio * _slope(high, end)
            quantity = f"slope of V at the jump less {min_ratio:g} times that beyond, {label}"
            checks.append(above(quantity, excess, 0, places, "m/s/Hz"))
        return checks

    def lines() -> list[Check]:
        checks = []
        for setting in [*alike, *others]:
            # Under a protocol that has some of the curves, these are judged.
            with suppress(Untestable):
                label, line = curve(setting)
                fast = {f: place for f, place in line.items() if straight[0] <= f <= straight[1]}
                fit = determination(np.array([*fast]), [place.velocity for place in fast.values()])
                name = f"R² of a line through V(f), {straight[0]:g} to {straight[1]:g} Hz, {label}"
                checks.append(above(name, fit, min_r2, fast.values()))
        return checks

    return judge_parts(a=jumps, b=lines)


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
