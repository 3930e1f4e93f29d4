"""Measures of chute flows, from one replicate of a run file."""

import numpy as np
import xarray as xr

MEASURES = {
    "median_overlap": ("1", "median overlap of the contacts, in diameters"),
    "overlap_999": ("1", "99.9th percentile of the overlaps of the contacts, in diameters"),
}

#: Measures that are quantiles of the overlaps.
_QUANTILES = {"median_overlap": 0.5, "overlap_999": 0.999}


def measure(run: xr.Dataset) -> dict[str, float]:
    """Return the measures that the arrays of a replicate allow."""
    if "overlap_histogram" not in run:
        return {}
    counts, edges = run["overlap_histogram"].values, run["overlap_edges"].values
    return {name: quantile(counts, edges, share) for name, share in _QUANTILES.items()}


def quantile(counts: np.ndarray, edges: np.ndarray, share: float) -> float:
    """Return a quantile of a histogram (B,) with edges (B + 1,), log-linear within a bin."""
    total = counts.sum()
    if not total > 0:
        return np.nan
    below = np.concatenate([[0.0], np.cumsum(counts)]) / total
    return float(np.exp(np.interp(share, below, np.log(edges))))
