"""The variables: all that run files and datasets say of a run besides its parameters.

Numbers that are computed from run files are observables, declared where they are measured. All
others are in one table, ``variables.csv``; every other list is a selection of it. Its columns are
the attributes of `Variable`; an empty one stands for the usual value:

- ``systems``: all of them;
- ``dims``: those of its kind, `DIMS`;
- ``cell_method``: ``point``;
- ``part``: the average of the window, for a profile;
- ``in_datasets``: all of its systems, for a profile. What no figure and no claim looks at is left
  out of datasets.
"""

import csv
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

from sim.base.additions import additions, shipped

if TYPE_CHECKING:
    import xarray as xr

#: Systems that the table knows.
ALL = ("chute", "belt", "conveyor")

#: Dimensions of a variable by its kind, where the kind has the same for all: scalars, time series
#: and profiles are in run files, observables and what is said of points in datasets alone.
DIMS = {
    "scalar": ("replicate",),
    "series": ("replicate", "time"),
    "profile": ("replicate", "height"),
    "observable": ("replicate",),
    "point": ("point",),
}

#: Kinds whose dimensions differ: numbers of each particle and each contact, those at each
#: frame of a trajectory, tables of run files, and arrays of the group of a system in a dataset.
OTHER_KINDS = ("particle", "contact", "trajectory", "table", "group")

_OF_RUN_FILES = ("series", "particle", "contact", "trajectory", "table")

#: Endings of the name of a profile that is not the average of the window: of the last sample, of
#: the beginning of the belt's cycle, and of successive blocks of samples.
INSTANTANEOUS, AT_PHASE_0, HISTORY = "_instantaneous", "_at_phase_0", "_history"

#: Kind of the additions that are observables.
OBSERVABLE = "observable"

#: Gives observables from the arrays of one replicate of a run: a number, or several by name.
Measuring = Callable[[Mapping[str, Any]], float | Mapping[str, float]]


@dataclass(frozen=True)
class Variable:
    """A variable of run files or datasets, by its name there.

    Its ``kind`` is one of `DIMS` or `OTHER_KINDS`, its ``unit`` as UDUNITS reads it (``"1"`` for a
    pure number, empty for words), its ``meaning`` for axes and captions. Runs of ``systems`` have
    it, where the parameter ``asked_by`` asks for it, if there is one; datasets of ``in_datasets``
    keep it. ``cell_method`` is how a value of a time series stands for its sample interval (CF),
    ``part`` the part of the run that a profile is of, and ``of`` the variable that this one is
    another part of, if any.
    """

    kind: str
    name: str
    unit: str
    meaning: str
    systems: tuple[str, ...]
    asked_by: str
    dims: tuple[str, ...]
    cell_method: str
    part: str
    of: str
    in_datasets: tuple[str, ...]

    @property
    def attributes(self) -> dict[str, str]:
        """Unit and long name, which are its attributes in a file."""
        meaning = f"{self.meaning}, {self.part}" if self.part else self.meaning
        return ({"units": self.unit} if self.unit else {}) | {"long_name": meaning}


def variable(kind: str, systems: str, **row: str) -> Variable:
    """Return the variable that a row of the table declares."""
    runs = tuple(systems.split()) or ALL
    datasets = () if kind in _OF_RUN_FILES else runs
    if kept := row.get("in_datasets"):
        datasets = () if kept == "none" else tuple(kept.split())
    usual_part = "average of the window" if kind == "profile" else ""
    read: dict[str, Any] = {
        "dims": tuple(row.get("dims", "").split()) or DIMS[kind],
        "cell_method": f"time: {row.get('cell_method') or 'point'}",
        "part": row.get("part") or usual_part,
        "in_datasets": datasets,
    }
    return Variable(kind=kind, systems=runs, **{"of": ""} | row | read)


#: All variables, in the order of the table.
with Path(__file__).with_suffix(".csv").open(encoding="utf-8", newline="") as _file:
    VARIABLES = tuple(variable(**row) for row in csv.DictReader(_file))


@dataclass(frozen=True)
class Observable:
    """A number per replicate that is computed from run files: its variable and its function."""

    variable: Variable
    measure: Measuring


def observables(system: str | None = None) -> dict[str, Observable]:
    """Return all observables by name, of one system or of all; those of plug-ins come last."""
    # They import NumPy, which parameters do without.
    import_module("sim.measures")
    plugins = {name: one.value for name, one in additions(OBSERVABLE).items()}
    every: dict[str, Observable] = {**shipped(OBSERVABLE), **plugins}
    return {n: one for n, one in every.items() if system in (None, *one.variable.systems)}


def observable_variables(system: str | None = None) -> dict[str, Variable]:
    """Return the variables of all observables by name, of one system or of all."""
    return {name: one.variable for name, one in observables(system).items()}


def variables_of(*kinds: str, system: str | None = None) -> dict[str, Variable]:
    """Return the variables of some kinds by name, of one system or of all, in the table's order.

    Time series of several systems may share a name: ask for those of one system.
    """
    rows = [one for one in VARIABLES if one.kind in kinds]
    return {one.name: one for one in rows if system is None or system in one.systems}


def recorded_by(parameters: Any, *kinds: str) -> dict[str, Variable]:
    """Return the variables of some kinds that runs of a point record.

    They are those that it asks for and that its engine can tell.
    """
    lacks = parameters.option("engine").lacks
    return {
        name: one
        for name, one in variables_of(*kinds, system=parameters.system).items()
        if name not in lacks and (not one.asked_by or getattr(parameters, one.asked_by))
    }


def parts(ending: str, system: str) -> dict[str, str]:
    """Return the profiles of a system whose name has an ending: name -> that of the average."""
    profiles = variables_of("profile", system=system).values()
    return {one.name: one.of for one in profiles if one.name.endswith(ending)}


#: Scalars of each replicate in a run file.
SCALARS = variables_of("scalar")

#: Scalars that tell how a replicate was run, and how its spheres overlapped: failed ones have them.
OF_FAILURES = ("steps", "time_step_used", "wall_time", "loop_time", "replicate_seed", "max_overlap")


def mask_failed(data: "xr.Dataset") -> "xr.Dataset":
    """Return a run or a dataset with not-a-number for what was measured of failed replicates.

    They would be averages over what came before a blow-up.
    """
    is_failed = data["status"] == "failed"
    if not bool(is_failed.any()):
        return data
    named = variables_of("scalar", "series", "profile", "table").keys() | observable_variables()
    measured = [
        name
        for name, values in data.data_vars.items()
        if name in named - set(OF_FAILURES)
        and "replicate" in values.dims
        and values.dtype.kind == "f"
    ]
    return data.assign({name: data[name].where(~is_failed) for name in measured})


def reserved_names() -> set[str]:
    """Return the names that no parameter and no observable of a plug-in may have.

    They are those of all variables that studies can plot, also without their endings.
    """
    import_module("sim.measures")
    names = variables_of("scalar", "profile", "series").keys() | shipped(OBSERVABLE).keys()
    return names | {plotted_name(name) for name in names}


def plotted_name(name: str) -> str:
    """Return what study files call a profile or a time series.

    >>> plotted_name("velocity_profile"), plotted_name("mean_velocity")
    ('velocity', 'velocity')
    """
    return name.removesuffix("_profile").removeprefix("mean_")
