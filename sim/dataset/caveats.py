"""What to know before trusting a run: what it says of itself, and whether its energy adds up."""

from collections.abc import Iterable, Mapping
from typing import Any, SupportsFloat

from sim.dataset.summary import Summary
from sim.parameters import Parameters

#: Share of the energy turned over that the ledger of a sound run does not lack by far.
UNSOUND = 0.01

#: Largest share that the ledger of a run may lack to be called closed.
CLOSED = 0.005

_LEAKING = (
    f"energy does not add up within {100 * UNSOUND:g} % of what is turned over, so the run is "
    "numerically unsound or its model makes energy"
)

#: By how much a run outlasts what is asked for beyond rounding.
_ROUNDING = 1.001

_LONGER = (
    "runs longer than is asked for, as they were made when more was; their numbers are of all of "
    "them"
)

#: The scalars that the ledger of a replicate is read from.
_OF_LEDGER = (
    "energy_residual",
    "frictional_power",
    "normal_power",
    "velocity",
    "acceleration",
)


def missing_energy(replicate: Mapping[Any, SupportsFloat]) -> float:
    """Return the share of the energy turned over that the ledger of a replicate lacks.

    A run file tells it relative to what was dissipated. Flows that accelerate, most of all those
    without friction, turn over more: what they gain counts too, from the means over the window.

    Parameters
    ----------
    replicate : mapping
        Scalars of a run file by name, ``energy_residual`` among them; without ``frictional_power``
        (belt) that is the share.
    """
    lacking = abs(float(replicate["energy_residual"]))
    if "frictional_power" not in replicate:
        return lacking
    lost = float(replicate["frictional_power"]) + float(replicate["normal_power"])
    mass = float(replicate["particles"]) * float(replicate["mass"])
    gained = mass * float(replicate["velocity"]) * float(replicate["acceleration"])
    return lacking * (lost / (lost + gained) if gained > 0 else 1.0)


def caveat(
    said: str,
    missing: Iterable[float],
    parameters: Parameters,
    overlaps: Iterable[float],
    lengths: Iterable[float],
) -> str:
    """Return all that is to be known before trusting a run, empty for a sound one.

    Parameters
    ----------
    said : str
        What the run says of itself.
    missing, overlaps : iterable of float
        Shares of the energy that are not found, and largest overlaps in diameters, of all
        replicates; NaN where not known.
    parameters : Parameters
        Of the point.
    lengths : iterable of float
        Lengths of the replicates, s.
    """
    leaking = any(share > UNSOUND for share in missing)
    soft = (parameters.caveat_of(float(overlap)) for overlap in overlaps)
    longest = _ROUNDING * parameters.steps * parameters.time_step
    longer = any(length > longest for length in lengths)
    told = (said, _LEAKING if leaking else "", *soft, _LONGER if longer else "")
    return "; ".join(filter(None, dict.fromkeys(told)))


def caveat_of_run(run: Summary, parameters: Parameters) -> str:
    """Return the caveat of the run of a point."""
    said = run.attrs.get("caveat", "")
    each = zip(run.scalars.get("max_overlap", ()), run.scalars.get("status", ()), strict=True)
    # What blew up is no flow.
    overlaps = [overlap for overlap, status in each if status == "completed"]
    steps = zip(run.scalars.get("steps", ()), run.scalars.get("time_step_used", ()), strict=True)
    lengths = [count * step for count, step in steps]
    if "energy_residual" not in run.scalars:
        return caveat(said, (), parameters, overlaps, lengths)
    shared = {"particles": parameters.particles, "mass": parameters.mass}
    columns = {name: run.scalars[name] for name in _OF_LEDGER if name in run.scalars}
    replicates = (
        dict(zip(columns, values, strict=True)) for values in zip(*columns.values(), strict=True)
    )
    missing = [missing_energy(shared | each) for each in replicates]
    return caveat(said, missing, parameters, overlaps, lengths)
