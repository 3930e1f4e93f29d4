"""Fit a surrogate to what the runs say."""

import xarray as xr

from sim.base.errors import InputError
from sim.study.plottable import numbers
from sim.study.surrogate import SurrogateSpec
from sim.surrogates.process import fit
from sim.surrogates.regimes import fit_regimes
from sim.surrogates.sample import points_of_mean, unit_cube
from sim.surrogates.surrogate import Surrogate

#: Fewest points of which a mean can be.
FEWEST_POINTS = 4


def fit_surrogate(spec: SurrogateSpec, sample: xr.Dataset) -> Surrogate:
    """Return the surrogate through some points.

    Raises
    ------
    InputError
        When fewer than `FEWEST_POINTS` have a mean and a regime that counts.
    """
    chosen = points_of_mean(sample, spec.regimes)
    if chosen.sum() < FEWEST_POINTS:
        regimes = sample["regime"].values.astype(str).tolist()
        found = ", ".join(f"{regimes.count(name)} {name}" for name in sorted(set(regimes)))
        allowed = (
            f"{FEWEST_POINTS} or more points of regime {', '.join(spec.regimes)}: longer runs "
            "settle more, and regimes may name more"
        )
        raise InputError.of_value(
            f"surrogate {spec.name}", "series", f"{spec.series}: {found}", allowed
        )
    x = unit_cube(spec.axes, {axis.name: sample[axis.name].values for axis in spec.axes})
    process = fit(
        x[chosen],
        sample["mean"].values[chosen],
        sample["standard_error"].values[chosen] ** 2,
        bool(sample.attrs["scatter"]),
    )
    observable = numbers(spec.system)[spec.observable]
    return Surrogate(
        name=spec.name,
        observable=spec.observable,
        unit=observable.unit,
        meaning=observable.meaning,
        system=spec.system,
        axes=spec.axes,
        fixed=sample.attrs["fixed"],
        mean_regimes=spec.regimes,
        sample=sample,
        process=process,
        regimes=fit_regimes(x, sample["regime"].values, spec.regimes),
    )
