"""Fit a surrogate to what the runs say."""

import xarray as xr

from sim.parameters.forms import forms
from sim.study.plottable import numbers
from sim.study.surrogate import SurrogateSpec, fewest_points
from sim.surrogates.fits import fit
from sim.surrogates.frames import Frame
from sim.surrogates.refusals import Refusal
from sim.surrogates.regimes import fit_regimes
from sim.surrogates.sample import left_out, points_of_mean, unit_cube
from sim.surrogates.surrogate import Surrogate


def fit_surrogate(spec: SurrogateSpec, sample: xr.Dataset) -> Surrogate:
    """Return the surrogate through some points.

    Raises
    ------
    Refusal
        When fewer than `fewest_points` have a mean and a regime that counts.
    """
    chosen = points_of_mean(sample, spec.regimes)
    fewest = fewest_points(len(spec.axes))
    if chosen.sum() < fewest:
        others = left_out(sample, spec.regimes).items()
        counts = "".join(f" {count} {name}," for name, count in others)
        raise Refusal(
            f"surrogate {spec.name}: no mean, as {chosen.sum()} of {len(chosen)} points of series "
            f"{spec.series} count ({' or '.join(spec.regimes)}) and {fewest} are needed; "
            f"left out are{counts.rstrip(',') or ' none'}; more points, other ranges or the key "
            "regimes may give others"
        )
    x = unit_cube(spec.axes, {axis.name: sample[axis.name].values for axis in spec.axes})
    process = fit(
        x[chosen],
        sample["mean"].values[chosen],
        sample["standard_error"].values[chosen] ** 2,
        bool(sample.attrs["scatter"]),
        [
            Frame(one, spec.axes, sample.attrs["fixed"])
            for one in forms(spec.system, spec.observable).values()
        ],
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
