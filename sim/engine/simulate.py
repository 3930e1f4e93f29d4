"""A point given in Python, run without files, as a dataset."""

from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

from sim.engine.run import run_point
from sim.parameters import point_in_python

if TYPE_CHECKING:
    import xarray as xr


def simulate(system: str = "chute", *, progress: bool = True, **parameters: Any) -> "xr.Dataset":
    """Run a point and return what its run file holds; nothing stays on the disk.

    Parameters
    ----------
    system : str
        ``"chute"`` or ``"belt"``.
    progress : bool
        Show a bar, on terminals and in notebooks.
    **parameters
        Parameters of the system by name, in the units of a study file; those left out have the
        value of the paper.

    Returns
    -------
    xarray.Dataset
        Time series over ``(replicate, time)``, profiles over ``(replicate, height)``, first and
        last state of the particles, scalars over ``replicate``, and the parameters, each with
        ``units`` (SI) and ``long_name``. The attribute ``status`` is ``"failed"`` where a replicate
        blew up twice, and ``reason`` says why.

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
    # Only here: half a second, which a run of the workflow does without.
    import xarray as xr

    point = point_in_python("simulate", system, parameters)
    with TemporaryDirectory(prefix="talus-") as folder:
        output = Path(folder) / "run.nc"
        run_point(point, output, quiet=not progress, record_failure=True)
        run = xr.load_dataset(output, engine="netcdf4")
    given = "".join(f", {name}={value!r}" for name, value in parameters.items())
    command = f"sim.simulate({system!r}{given})"
    return run.assign_attrs(command=command, history=f"{run.attrs['created']}: {command}")
