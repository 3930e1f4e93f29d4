"""Run a point from Python, without files, and get its data as a dataset."""

from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

from sim.engine.run import run_point
from sim.parameters import parse_python_point

if TYPE_CHECKING:
    import xarray as xr


def simulate(system: str = "chute", *, progress: bool = True, **parameters: Any) -> "xr.Dataset":
    """Run a point and return the content of its run file; nothing stays on the disk.

    Parameters
    ----------
    system : str
        ``"chute"``, ``"belt"`` or ``"conveyor"``.
    progress : bool
        Show a bar, on terminals and in notebooks.
    **parameters
        Parameters of the system by name, in the units of a study file; parameters that are omitted
        have the value of the paper.

    Returns
    -------
    xarray.Dataset
        Time series over ``(replicate, time)``, profiles over ``(replicate, height)``, first and
        last state of the particles, scalars over ``replicate``, and the parameters, each with
        ``units`` (SI) and ``long_name``. The attribute ``status`` is ``"failed"`` where a replicate
        blew up twice; ``reason`` gives the cause.

    Raises
    ------
    InputError
        When a parameter is unknown or outside its range; before anything is computed.

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

    point = parse_python_point("simulate", system, parameters)
    with TemporaryDirectory(prefix="talus-") as folder:
        output = Path(folder) / "run.nc"
        run_point(point, output, quiet=not progress, record_failure=True)
        run = xr.load_dataset(output, engine="netcdf4")
    arguments = "".join(f", {name}={value!r}" for name, value in parameters.items())
    command = f"sim.simulate({system!r}{arguments})"
    return run.assign_attrs(command=command, history=f"{run.attrs['created']}: {command}")
