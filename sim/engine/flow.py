"""Runs from Python: a point without files, or a flow that is run step by step."""

import warnings
from collections.abc import Mapping
from numbers import Integral, Real
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from sim.base.errors import InputError
from sim.base.messages import one_of
from sim.engine.dynamics.cells import BlowUp
from sim.engine.progress import bar
from sim.engine.replicate import origin_of
from sim.engine.run import run_point
from sim.engine.systems import SYSTEMS as FLOWS
from sim.engine.systems import build
from sim.parameters import Parameters, parse_python_point, point_id
from sim.parameters.common import MAX_SAMPLES
from sim.parameters.given import table_text
from sim.parameters.roles import id_parts
from sim.parameters.variables import mask_failed, variables_of

if TYPE_CHECKING:
    import xarray as xr


#: Parameters on which it depends whether spheres overlap too much, besides those of ids.
_OF_OVERLAPS = ("diameter", "mass", "stiffness", "overlap_limit")


def simulate(
    system: str = "chute",
    *,
    state: Any = None,
    progress: bool = True,
    keep: bool = False,
    **parameters: Any,
) -> "xr.Dataset":
    """Run a point and return the content of its run file; nothing stays on the disk.

    Parameters
    ----------
    system : str
        ``"chute"``, ``"belt"``, ``"conveyor"``, or ``"function"`` for one of a plug-in.
    state : pandas.DataFrame, mapping of columns or xarray.Dataset, optional
        Particles from which it starts, in place of ``initial_state``: columns as in such a file, or
        the last state of a run of one replicate, or `Flow.particles`. A contact starts anew.
    progress : bool
        Show a bar, on terminals and in notebooks.
    keep : bool
        Return failed replicates as they are, to look at what came before the blow-up.
    **parameters
        Parameters of the system by name, in the units of a study file; parameters that are omitted
        have the value of the paper.

    Returns
    -------
    xarray.Dataset
        Time series over ``(replicate, time)``, profiles over ``(replicate, height)``, first and
        last state of the particles, scalars over ``replicate``, and the parameters, each with
        ``units`` (SI) and ``long_name``. Where some replicates blew up twice, a warning says so,
        the attribute ``status`` is ``"failed"``, ``reason`` gives the cause, and what was measured
        of them is not-a-number, unless ``keep`` is true.

    Raises
    ------
    InputError
        When a parameter is unknown or outside its range; before anything is computed.
    BlowUp
        When all replicates blew up, unless ``keep`` is true.

    Examples
    --------
    >>> run = simulate("belt", beads=10, width=5, transient=1, average=2, progress=False)
    >>> run.mean_velocity.dims, run.mean_velocity.units
    (('replicate', 'time'), 'm s-1')
    >>> bool(abs(run.velocity[0]) < 1)
    True
    """
    # Imported late: it takes half a second, which runs of the workflow do not need.
    import xarray as xr

    given = parameters if state is None else _with_state("simulate", system, state, parameters)
    point = parse_python_point("simulate", system, given)
    with TemporaryDirectory(prefix="talus-") as folder:
        output = Path(folder) / "run.nc"
        run_point(point, output, quiet=not progress, record_failure=True, temporary=True)
        run = xr.load_dataset(output, engine="netcdf4")
    if failure := _failure(point, run):
        if not keep and (run["status"] == "failed").all():
            raise BlowUp(f"{failure}; keep=True returns what came before")
        warnings.warn(failure, stacklevel=2)
    run = run if keep else mask_failed(run)
    arguments = "".join(f", {name}={value!r}" for name, value in parameters.items())
    arguments += "" if state is None else ", state=…"
    command = f"talus.simulate({system!r}{arguments})"
    return run.assign_attrs(command=command, history=f"{run.attrs['created']}: {command}")


def _failure(point: Parameters, run: "xr.Dataset") -> str:
    """Return how many replicates blew up, why and at which parameters; empty where none did."""
    reasons = [str(reason) for reason in run["reason"].values if reason]
    if not reasons:
        return ""
    names = dict.fromkeys((*id_parts(type(point)), *_OF_OVERLAPS))
    values = ", ".join(f"{name} {getattr(point, name):g}" for name in names if hasattr(point, name))
    caveat = f"; {point.caveat}" if point.caveat else ""
    count = f"{len(reasons)} of {run.sizes['replicate']} replicates failed"
    return f"{point.system}: {count}: {reasons[0]}; at {values}{caveat}"


def _with_state(
    source: str, system: str, state: Any, parameters: Mapping[str, Any]
) -> dict[str, Any]:
    """Return parameters with a state that is given from Python."""
    if "initial_state" in parameters:
        raise InputError.of_value(source, "state", type(state), "state or initial_state, not both")
    if system == "conveyor" and hasattr(state, "data_vars"):
        allowed = "a data frame of velocities in the laboratory; those of a run are the plane's"
        raise InputError.of_value(source, "state", type(state), allowed)
    return {**parameters, "initial_state": table_text(state, source)}


def _is_number(kind: type, value: Any) -> bool:
    """True where a value is a number of a kind; ``True`` and ``False`` are no numbers."""
    return isinstance(value, kind) and not isinstance(value, bool)


class Flow:
    """One replicate of a point in motion, from its initial state on; a bed has settled already.

    It moves exactly like the same replicate of a run, to the bit, for any duration. ``transient``,
    ``average`` and ``limit`` have no effect.

    Parameters
    ----------
    system : str
        ``"chute"``, ``"belt"`` or ``"conveyor"``.
    replicate : int
        Number of the replicate, from 0: each has its own initial state.
    state : pandas.DataFrame, mapping of columns or xarray.Dataset, optional
        Particles from which it starts, as in `simulate`.
    **parameters
        Parameters of the system by name, in the units of a study file; parameters that are omitted
        have the value of the paper.

    Raises
    ------
    InputError
        When a parameter is unknown or outside its range.
    BlowUp
        When a bed blows up while it settles.

    Examples
    --------
    >>> flow = Flow("belt", beads=10, width=5)
    >>> flow.positions.shape
    (10, 2)
    >>> flow.run(3, progress=False).time
    0.15
    >>> flow.series.mean_velocity.sizes["time"] == 3 * flow.parameters.samples_per_cycle
    True
    """

    def __init__(
        self, system: str = "chute", *, replicate: int = 0, state: Any = None, **parameters: Any
    ):
        if system not in FLOWS:
            raise InputError.of_value("Flow", "system", system, one_of(str(system), FLOWS))
        given = parameters if state is None else _with_state("Flow", system, state, parameters)
        self.parameters = parse_python_point("Flow", system, given)
        if not (_is_number(Integral, replicate) and replicate >= 0):
            raise InputError.of_value("Flow", "replicate", replicate, "an integer >= 0")
        replicate = int(replicate)
        self._system = build(self.parameters, replicate)
        self._batches: list[dict[str, np.ndarray]] = []
        self._samples, self._remainder, self._failure = 0, 0.0, ""
        if origin := origin_of(self.parameters, Path("flow.nc")):
            origin.start(self._system, replicate)
        else:
            self._system.settle()

    def run(self, duration: float, *, progress: bool = True) -> Self:
        """Advance by a duration, rounded to whole sample intervals, and return the flow.

        The rounding error of a call, half an interval at most, is carried over to the next call. So
        the time after many short calls is their sum to within half an interval.

        Parameters
        ----------
        duration : float
            Duration in the unit of ``transient``: √(σ/g) for a chute, cycles for a shaken system.
        progress : bool
            Show a bar, on terminals and in notebooks.

        Raises
        ------
        InputError
            When the duration is not a positive number, or takes more than ten million samples.
        BlowUp
            When an overlap exceeds ``overlap_limit`` or a position is not a number, and in each
            further call. A run would start again with half the time step.
        """
        if self._failure:
            raise BlowUp(self._failure)
        longest = MAX_SAMPLES * self._interval / self.parameters.time_unit
        if not (_is_number(Real, duration) and 0 < duration <= longest):
            allowed = f"a number > 0 and <= {longest:.6g}"
            raise InputError.of_value("run", "duration", duration, allowed)
        intervals = duration * self.parameters.time_unit / self._interval + self._remainder
        missing = round(intervals)
        # Stays zero if a signal or a blow-up ends the loop early.
        remainder, self._remainder = intervals - missing, 0.0
        with bar(missing, point_id(self.parameters), "sample", quiet=not progress) as display:
            while missing:
                try:
                    values = self._system.sample(missing).values
                except BlowUp as error:
                    self._failure = str(error)
                    raise
                batch = {name: np.array(column, float) for name, column in values.items()}
                count = len(batch["mean_velocity"])
                self._batches.append({name: batch[name] for name in self._system.series})
                self._samples += count
                missing -= count
                display.update(count)
        self._remainder = remainder
        return self

    @property
    def _interval(self) -> float:
        """Time between two samples, s."""
        return self.parameters.sample_steps * self.parameters.time_step

    @property
    def time(self) -> float:
        """Time since the start, s."""
        return round(self._samples * self._interval, 12)

    @property
    def positions(self) -> np.ndarray:
        """Centres of the particles, (N, D) in m, within the periodic cell.

        ``x`` points down the slope, ``z`` away from the base; spheres also have ``y``, across.
        """
        return self._snapshot("position")

    @property
    def velocities(self) -> np.ndarray:
        """Velocities of the particles, (N, D) in m/s."""
        return self._snapshot("particle_velocity")

    @property
    def spins(self) -> np.ndarray:
        """Angular velocities of the spheres, (N, 3) in 1/s; (N, 0) for the beads of the belt."""
        return self._snapshot("particle_spin")

    @property
    def radii(self) -> np.ndarray:
        """Radii of the particles, (N,) in m."""
        return self._snapshot("radius")

    @property
    def series(self) -> "xr.Dataset":
        """Time series over ``time`` (s) since the start, with units and long names, as in a run."""
        import xarray as xr

        time = np.arange(1, self._samples + 1) * self._interval
        attributes = {"units": "s", "long_name": "end of the sample interval, since the start"}
        return xr.Dataset(
            {
                name: (
                    "time",
                    np.concatenate([np.empty(0), *(batch[name] for batch in self._batches)]),
                    variable.attributes,
                )
                for name, variable in self._system.series.items()
            },
            coords={"time": ("time", time, attributes)},
        )

    @property
    def particles(self) -> "xr.Dataset":
        """State of the particles over ``particle``, with units and long names, as in a run."""
        import xarray as xr

        particles, states = variables_of("particle"), {}
        for name, values in self._system.snapshot().items():
            if values.size:
                row = particles[name]
                dims = [one for one in row.dims if one not in ("replicate", "frame")]
                states[name] = dims, values, row.attributes
        time = (), self.time, {"units": "s", "long_name": "time since the start"}
        return xr.Dataset(states, {"axis": list(self._system.axes), "time": time})

    def _snapshot(self, name: str) -> np.ndarray:
        state = self._system.snapshot()
        values = np.array(state.get(name, np.empty((self.parameters.particles, 0))))
        # A copy: an assignment to it would move no particle.
        values.flags.writeable = False
        return values

    def __repr__(self) -> str:
        return f"<Flow {point_id(self.parameters)} at {self.time:.6g} s>"
