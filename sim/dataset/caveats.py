"""Caveats of a run: its own, and whether its energy adds up, overlaps are small, length fits."""

from collections.abc import Iterable
from math import nan
from typing import Any

from sim.dataset.run_file import Replicate, RunFile, Summary
from sim.measures.balance import missing_energy
from sim.parameters import Parameters
from sim.parameters.images import WIDE_CELL
from sim.parameters.variables import observables

#: The run is unsound if its ledger lacks more than this share of the energy turned over.
UNSOUND_SHARE = 0.01

#: Largest share of the energy that a closed ledger may lack.
CLOSED_SHARE = 0.005

_LEAK_TEXT = (
    f"energy does not add up within {100 * UNSOUND_SHARE:g} % of what is turned over, so the run "
    "is numerically unsound or its model makes energy"
)

#: A run is longer than its point asks for if its length exceeds that by more than this factor.
_LENGTH_TOLERANCE = 1.001

_LENGTH_TEXT = (
    "runs longer than is asked for, as they were made when more was; their numbers are of all of "
    "them"
)

#: With bumps a flow counts as layered from this order on. In cells of 5 σ it is 0.75 to 0.79 where
#: layers glide on each other, in cells of 8 σ 0.16 to 0.28 (depth 12, 24°, bumps of 1 σ).
LAYERED = 0.5

_LAYERS_TEXT = (
    f"on bumps in a cell narrower than {WIDE_CELL} σ the flow has ordered in layers (layer_order "
    f"above {LAYERED:g}), which may glide on each other and be several times as fast as a flow in "
    "a wider cell"
)

#: The scalars that make up the energy ledger of a replicate.
LEDGER_SCALARS = (
    "energy_residual",
    "frictional_power",
    "normal_power",
    "velocity",
    "acceleration",
)


def caveat(
    own_caveat: str,
    missing_shares: Iterable[float],
    parameters: Parameters,
    overlaps: Iterable[float],
    lengths: Iterable[float],
    orders: Iterable[float] = (),
) -> str:
    """Return all caveats of a run as one text, empty for a sound run.

    Parameters
    ----------
    own_caveat : str
        Caveat in the run file.
    missing_shares, overlaps : iterable of float
        Missing shares of the energy, and largest overlaps in diameters, per replicate; NaN where
        not known.
    parameters : Parameters
        The point.
    lengths : iterable of float
        Lengths of the replicates, s.
    orders : iterable of float
        Order of layers of the replicates, NaN where not known.
    """
    is_leaking = any(share > UNSOUND_SHARE for share in missing_shares)
    overlap_caveats = (parameters.caveat_of(float(overlap)) for overlap in overlaps)
    longest = _LENGTH_TOLERANCE * parameters.steps * parameters.time_step
    is_longer = any(length > longest for length in lengths)
    texts = (
        own_caveat,
        _LEAK_TEXT if is_leaking else "",
        *overlap_caveats,
        _LENGTH_TEXT if is_longer else "",
        _LAYERS_TEXT if is_narrow(parameters) and any(one > LAYERED for one in orders) else "",
    )
    return "; ".join(filter(None, dict.fromkeys(texts)))


def is_narrow(parameters: Any) -> bool:
    """Return whether a flow on bumps has a cell so narrow that it may order in layers."""
    return getattr(parameters, "bumps", 0) > 0 and parameters.cell < WIDE_CELL


def layer_orders(run: RunFile, parameters: Parameters) -> list[float]:
    """Return the order of layers of the completed replicates of a run where it may count."""
    if not (is_narrow(parameters) and parameters.system == "chute"):
        return []
    measured = observables(parameters.system)["layer_order"].measure
    completed = (run["status"] == "completed").nonzero()[0]
    orders: Any = [measured(Replicate(run, int(k))) for k in completed]
    return [one.get("layer_order", nan) for one in orders]


def caveat_of_run(run: Summary, parameters: Parameters, orders: Iterable[float] = ()) -> str:
    """Return all caveats of the run of a point as one text; ``orders`` as of `caveat`."""
    own_caveat = run.attrs.get("caveat", "")
    # A replicate that blew up is not a flow. Not every engine tells overlaps.
    pairs = zip(run.scalars.get("max_overlap", ()), run.scalars.get("status", ()), strict=False)
    overlaps = [overlap for overlap, status in pairs if status == "completed"]
    steps = zip(run.scalars.get("steps", ()), run.scalars.get("time_step_used", ()), strict=True)
    lengths = [count * step for count, step in steps]
    if "energy_residual" not in run.scalars:
        return caveat(own_caveat, (), parameters, overlaps, lengths, orders)
    shared = {"particles": parameters.particles, "mass": parameters.mass}
    columns = {name: run.scalars[name] for name in LEDGER_SCALARS if name in run.scalars}
    replicates = (
        dict(zip(columns, values, strict=True)) for values in zip(*columns.values(), strict=True)
    )
    missing_shares = [missing_energy(shared | scalars) for scalars in replicates]
    return caveat(own_caveat, missing_shares, parameters, overlaps, lengths, orders)
