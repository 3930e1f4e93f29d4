"""What plots can show: observables by their names in study files, with units and meanings."""

from collections.abc import Mapping
from dataclasses import dataclass

from sim.parameters import SYSTEMS
from sim.parameters.observables import (
    ASKED_FOR,
    BELT_FORCES,
    LACKING,
    LEFT_OUT,
    MEASURES,
    PROFILES,
    SCALARS,
    SERIES,
)
from sim.parameters.own import own_observables

#: Parameters without which an observable is not kept.
_ASKED_BY = (
    dict.fromkeys(ASKED_FOR, "stress_profiles")
    | {"fluctuation_temperature_profile": "fluctuation_profiles"}
    | dict.fromkeys((*BELT_FORCES, "belt_force_phase"), "belt_forces")
)

_PROFILE = "_profile"


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
    """Return what is one number per replicate: scalars, measures, means of profiles, plug-ins'."""
    scalars = _own(system, SCALARS | MEASURES)
    found = {
        name: Observable(name, name, unit, meaning, asked_by=_ASKED_BY.get(name, ""))
        for name, (unit, meaning) in scalars.items()
        if unit
    }
    means = {
        name: Observable(
            name, one.source, one.unit, f"{one.meaning}, mean of all particles", True, one.asked_by
        )
        for name, one in profiles(system).items()
        if name not in found
    }
    own = {
        name: Observable(name, name, one.unit, one.meaning)
        for name, one in own_observables(system).items()
    }
    return found | means | own


def profiles(system: str) -> dict[str, Observable]:
    """Return what is known over the height."""
    return {
        (name := source.removesuffix(_PROFILE)): Observable(
            name, source, unit, meaning, asked_by=_ASKED_BY.get(source, "")
        )
        for source, (unit, meaning) in _own(system, PROFILES | ASKED_FOR).items()
    }


def series(system: str) -> dict[str, Observable]:
    """Return what run files hold as time series."""
    return {
        (name := source.removeprefix("mean_")): Observable(
            name, source, unit, meaning, asked_by=_ASKED_BY.get(source, "")
        )
        for source, (unit, meaning) in SERIES.get(system, {}).items()
    }


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


def _own(system: str, rows: Mapping[str, tuple[str, str]]) -> dict[str, tuple[str, str]]:
    """Return the rows of what a system has."""
    lacking = LACKING[system] | LEFT_OUT[system] if system in LACKING else MEASURES.keys()
    return {name: row for name, row in rows.items() if name not in lacking}
