"""What plots can show: observables by their names in study files, with units and meanings."""

from dataclasses import dataclass, replace

from sim.parameters import SYSTEMS
from sim.parameters.variables import Variable, observable_variables, plotted_name, variables_of


@dataclass(frozen=True)
class Observable:
    """An observable of the points of one system.

    Attributes
    ----------
    name : str
        What study files call it.
    source : str
        Variable of the dataset, or of the run file, that it is from.
    unit, meaning : str
        Unit as UDUNITS reads it, and what it is.
    is_mean : bool
        Whether it is the mean of a profile over the particles.
    asked_by : str
        Parameter that a point needs for it to be kept, if any.
    """

    name: str
    source: str
    unit: str
    meaning: str
    is_mean: bool = False
    asked_by: str = ""


def numbers(system: str) -> dict[str, Observable]:
    """Return the numbers per replicate: scalars, observables, means of profiles."""
    rows = variables_of("scalar", system=system) | observable_variables(system)
    scalars = {name: _observable(name, row) for name, row in rows.items() if row.unit}
    means = {
        name: replace(one, meaning=f"{one.meaning}, mean of all particles", is_mean=True)
        for name, one in profiles(system).items()
        if name not in scalars
    }
    return scalars | means


def profiles(system: str) -> dict[str, Observable]:
    """Return the profiles over the height that datasets keep, averages of the window."""
    return {
        (name := plotted_name(source)): _observable(name, row)
        for source, row in variables_of("profile", system=system).items()
        if system in row.in_datasets and not row.of
    }


def series(system: str) -> dict[str, Observable]:
    """Return the time series of run files."""
    rows = variables_of("series", system=system)
    return {(name := plotted_name(source)): _observable(name, row) for source, row in rows.items()}


def _observable(name: str, row: Variable) -> Observable:
    return Observable(name, row.name, row.unit, row.meaning, asked_by=row.asked_by)


#: Observables that each kind of plot can show, by system.
SHOWN_BY = {
    "curves": numbers,
    "map": numbers,
    "profiles": profiles,
    "time_series": series,
    "distribution": numbers,
}


def every_name() -> list[str]:
    """Return the names of the observables of all kinds of plot and systems."""
    named = (SHOWN_BY[kind](system) for kind in SHOWN_BY for system in SYSTEMS)
    return list(dict.fromkeys(name for each in named for name in each))
