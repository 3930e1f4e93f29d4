"""Simulation-based calibration: made-up materials, and how often intervals hold them.

`python -m benchmarks.calibration` prints in how many of 40 materials the 95 % interval of each
parameter holds the truth; 33 to 40 are wanted. It also prints how evenly the truth lies among the
draws of the posterior (Talts et al. 2018, arXiv:1804.06788): a probability below 0.01 says that
posteriors are too wide, too narrow or shifted. A material that fits nowhere does not count as held.
"""

import numpy as np
from scipy.stats import chisquare

from sim.surrogates.posterior import calibrate, summarize
from tests.surrogates.made_calibration import RANGES, made_measurements

#: Materials, seed of the first, and bins of the ranks.
MATERIALS, SEED, BINS = 40, 1000, 4


def ranks_and_intervals(
    materials: int = MATERIALS,
) -> tuple[dict[str, list[float]], dict[str, int]]:
    """Return the rank of each truth among the draws, 0 to 1, and how many intervals hold it."""
    ranks: dict[str, list[float]] = {name: [] for name in RANGES}
    held = dict.fromkeys(RANGES, 0)
    for seed in range(SEED, SEED + materials):
        truth, calibration = made_measurements(seed)
        groups = calibrate(calibration)
        if "posterior" not in groups:
            continue
        rows = summarize(groups).set_index("parameter")
        for name, value in truth.items():
            ranks[name].append(float(np.mean(groups["posterior"][name].to_numpy() < value)))
            held[name] += bool(rows["low"][name] <= value <= rows["high"][name])
    return ranks, held


def main() -> None:
    """Print the table."""
    ranks, held = ranks_and_intervals()
    for name, values in ranks.items():
        counts, _ = np.histogram(values, BINS, (0, 1))
        print(
            f"{name}: {held[name]} of {MATERIALS} held, {MATERIALS - len(values)} fit nowhere; "
            f"ranks {counts.tolist()}, probability {chisquare(counts).pvalue:.2g}"
        )


if __name__ == "__main__":
    main()
