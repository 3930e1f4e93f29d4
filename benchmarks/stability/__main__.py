"""``python -m benchmarks.stability``: which step Gear's correctors bear, for docs/physics.md.

Prints the limits of each corrector, the rates of settled beds, and the frequency above which the
paper's step, 1/(2000 f), is stable in them; draws the maps into docs/images/stability.png. About
two minutes.
"""

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from benchmarks.stability.amplification import SCHEMES, limit
from benchmarks.stability.beds import Bed, largest, lowest_frequency, rates, settled
from benchmarks.stability.figure import Path as BedPath
from benchmarks.stability.figure import write
from sim.parameters import BeltParameters

FIGURE = Path(__file__).parents[2] / "docs" / "images" / "stability.png"

#: Readings of the mass in the damping terms.
READINGS: dict[str, dict[str, str]] = {
    "own mass": {},
    "reduced mass": {"damping_mass": "reduced"},
    "reduced mass, ghost of mass ⟨m⟩": {"damping_mass": "reduced", "ghost_mass": "mean"},
}

#: Pairs (γ, γ_s) in g from which rates are fitted, and those whose lowest frequency is told.
FITTED = ((50, 50), (50, 1), (50, 100), (0, 50), (50, 0), (25, 50), (50, 25))
TOLD = ((50, 50), (50, 1), (500, 500))

#: Beds of which rates, and of which lowest frequencies are taken.
BEDS, FEW = 10, 3


def limits() -> Iterator[str]:
    """Yield lines on the limits of each corrector."""
    yield "largest λΔt: order, corrections, at ωΔt = 0, 0.25, 0.5, 0.7"
    for scheme in SCHEMES:
        found = "  ".join(f"{limit(scheme, each):.3f}" for each in (0.0, 0.25, 0.5, 0.7))
        yield f"  {scheme.order}  {scheme.corrections}  {found}"


def fitted(reading: dict[str, str], beds: list[Bed]) -> tuple[np.ndarray, np.ndarray, float]:
    """Return a and b of λ = a max(γ, γ_s) + b min, λ over that, and ω/√(Yg/⟨d⟩)."""
    pairs, found, frequency = [], [], []
    for bed in beds:
        for damping, shear in FITTED:
            p = BeltParameters.model_validate(
                {"damping": damping, "shear_damping": shear} | reading
            )
            both = rates(p, bed)
            pairs.append(sorted((p.normal_damping, p.shear_damping * p.gravity), reverse=True))
            found.append(largest(both.damped))
        frequency.append(np.sqrt(largest(both.stiff) / (p.stiffness * p.gravity / p.diameter)))
    factors = np.linalg.lstsq(np.array(pairs), np.array(found), rcond=None)[0]
    return factors, found / (np.array(pairs) @ factors), float(np.mean(frequency))


def lowest(reading: dict[str, str], beds: list[Bed]) -> Iterator[str]:
    """Yield lines on the frequencies above which the paper's step is stable."""
    yield "  lowest stable f (Hz) of corrector (order, corrections), mean of beds"
    yield "  (γ, γ_s)  " + "  ".join(f"({one.order}, {one.corrections})" for one in SCHEMES)
    for damping, shear in TOLD:
        p = BeltParameters.model_validate({"damping": damping, "shear_damping": shear} | reading)
        each = [rates(p, bed) for bed in beds]
        values = [np.mean([lowest_frequency(one, bed) for bed in each]) for one in SCHEMES]
        yield f"  {damping:g}g, {shear:g}g  " + "  ".join(f"{value:6.1f}" for value in values)


def main() -> None:
    """Print all tables and draw the map."""
    print("\n".join(limits()))
    paths = []
    for name, reading in READINGS.items():
        beds = [settled(BeltParameters.model_validate(reading), one) for one in range(BEDS)]
        factors, scatter, frequency = fitted(reading, beds)
        print(
            f"{name}: λ = {factors[0]:.2f} max(γ, γ_s) + {factors[1]:.2f} min, beds and pairs "
            f"within {scatter.min() - 1:+.0%} and {scatter.max() - 1:+.0%}; "
            f"ω = {frequency:.2f} √(Yg/⟨d⟩)"
        )
        print("\n".join(lowest(reading, beds[:FEW])), flush=True)
        paths.append(BedPath(name, 500.0 * factors.sum(), frequency * 1e7**0.5))
    write(FIGURE, paths[:2])


if __name__ == "__main__":
    main()
