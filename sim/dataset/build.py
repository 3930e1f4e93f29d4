"""The runs of a study as one labelled table: ``dataset.nc`` over points and replicates.

Its root holds scalars; groups ``natural`` and ``si`` hold velocities in natural units and
parameters in SI, a group per system the profiles of its points, a group ``states`` those of the
particles of points that a figure shows particle by particle, and a group ``runs`` says which run
file each row was read from, so that it need not be read again.
"""

from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any, Literal

import numpy as np
import xarray as xr

from sim.base.errors import InputError
from sim.base.files import replacing, require_writable, seal
from sim.dataset.adopted import Adopted
from sim.dataset.boundaries import table
from sim.dataset.boundary_side import side
from sim.dataset.boundary_table import GROUP
from sim.dataset.combine import profiles, root, runs
from sim.dataset.earlier import keep
from sim.dataset.gather import PATH
from sim.dataset.results import PARTICLES, RUNS
from sim.dataset.rounds import as_wanted, known_points, refined, sides_of
from sim.dataset.rows import Rows, selected
from sim.dataset.runs import Runs
from sim.dataset.units import in_natural_units, in_si_units
from sim.engine.stored_run import current_status
from sim.parameters import SYSTEMS, Parameters, point_id
from sim.study.catalogue import Shown
from sim.study.figure_points import particles_in, particles_shown
from sim.study.load import Boundary, Study, as_member, load_study
from sim.study.refine import Sides

#: How arrays are stored.
COMPRESSION = {"zlib": True, "complevel": 9, "shuffle": True}

#: Profiles have 9 binary digits, an error of 1e-3 of each value, far below that of the mean of a
#: replicate, and places of particles 20; run files have all digits.
PROFILES, PLACES = 9, 20


def build(
    study_path: str | Path,
    results: str | Path = "results",
    processes: int = 1,
    scheduler: str | None = None,
    finished: Path | None = None,
) -> Path:
    """Combine the run files of a study into ``results/<study>/dataset.nc``.

    Run files that are those of an earlier dataset are not read again; the result is the same. Rows
    of adopted points are those of the adopted datasets.

    Parameters
    ----------
    study_path : str or Path
        The study file; its points name the run files in ``results/<study>/runs``, those of all
        rounds of refinement included.
    results : str or Path
        Folder of all results.
    processes : int
        How many read run files side by side.
    scheduler : str, optional
        Address of a dask scheduler whose workers read them instead.
    finished : Path, optional
        Write this file instead, which must not be there yet: a dataset of only those points that
        have whole run files with all that is wanted of them, boundaries left out.

    Returns
    -------
    Path
        The file written. It appears complete or not at all. What was found of boundaries is in
        its group ``boundaries``.

    Raises
    ------
    InputError
        When a run file is missing or is damaged, naming it. All damaged ones are set aside, so that
        the workflow computes them again. For ``finished``, when that is there or no run file is.
    """
    study = load_study(study_path, results)
    folder = Path(results) / study.name
    if finished is not None:
        study = _finished(study, folder, finished)
    adopted = Adopted(study, folder)
    held = Runs(folder, particles_shown(study), adopted, processes, scheduler)
    held.read({key: point.parameters for key, point in study.points.items()})
    found = _sides(study, held)
    study = refined(study, found)
    output = finished or folder / "dataset.nc"
    with replacing(output) as temporary:
        for group, dataset in _groups(held.rows(study.points), study, found):
            _write(temporary, group, dataset, output)
        seal(temporary)
        if not finished:
            keep(temporary, folder)
    return output


def _finished(study: Study, folder: Path, output: Path) -> Study:
    """Return a study of those points, of all rounds so far, whose run files have all of them."""
    if output.exists():
        raise InputError.of_value("--finished", "", str(output), "a file that is not there yet")
    if output.parent.resolve() == (folder / "runs").resolve():
        raise InputError.of_value(
            "--finished", "", str(output), "a file that is not among the runs"
        )
    require_writable(output.parent, "--finished")
    points = dict(study.points)
    for key, parameters in known_points(study, folder).items():
        for boundary in study.boundaries if key not in study.points else ():
            if _is_along(boundary, parameters):
                points[key] = as_member(points, parameters, boundary.name, boundary.figures)
    there = {
        key: point
        for key, point in points.items()
        if current_status(folder / "runs" / f"{key}.nc", point.parameters)
    }
    if not there:
        raise InputError(f"{study.path}: no point has a run file with all that is wanted of it")
    output.parent.mkdir(parents=True, exist_ok=True)
    return replace(study, points=there, boundaries=())


def _is_along(boundary: Boundary, parameters: Parameters) -> bool:
    """Return whether a point is one of those at which a boundary is looked for."""
    value = getattr(parameters, boundary.along, None)
    with suppress(InputError):
        return value is not None and point_id(boundary.at(value)) == point_id(parameters)
    return False


def _sides(study: Study, held: Runs) -> Sequence[Sides]:
    """Return the sides found of each boundary, round after round, whose runs are read as well."""

    def side_of(boundary: Boundary, parameters: Parameters) -> str | None:
        return side(held.scalars(point_id(parameters)), boundary.of, parameters)

    def read_round(points: Iterable[Parameters]) -> None:
        held.read({point_id(point): as_wanted(study, point) for point in points})

    return sides_of(study.boundaries, side_of, read_round)


def _groups(
    blocks: Sequence[Rows], study: Study, found: Sequence[Sides]
) -> Iterator[tuple[str | None, xr.Dataset]]:
    """Yield the groups of the dataset by name, the root first."""
    scalars = root(blocks, study)
    yield None, scalars
    yield "natural", in_natural_units(scalars)
    yield "si", in_si_units(list(study.points.values()))
    yield RUNS, runs(blocks, study.points)
    for system in SYSTEMS:
        own = [key for key, point in study.points.items() if point.parameters.system == system]
        if own:
            yield system, profiles(selected(blocks, set(own)), own, scalars.sizes["replicate"])
    states = {key: state for block in blocks for key, state in block.states.items()}
    for key, point in study.points.items():
        if key in states and (shown := particles_in(point.figures)):
            state = states[key].drop_encoding()
            if shown < Shown.PATH:
                state = state.drop_vars(PATH, errors="ignore")
            # The library gives them back in an order of its own.
            state.attrs = dict(sorted(state.attrs.items()))
            yield f"{PARTICLES}/{key}", state
    if study.boundaries:
        yield GROUP, table(study, found).to_xarray()


def _write(temporary: Path, group: str | None, dataset: xr.Dataset, output: Path) -> None:
    """Write a group to the temporary name of the file ``output``, the root first."""
    encoding = {name: _stored(dataset[name], group) for name in dataset.data_vars}
    # CF has only numbers as coordinates: labels are letters in two dimensions.
    labels = (name for name in ("point", "run") if name in dataset.coords)
    encoding |= {name: COMPRESSION | {"dtype": "S1"} for name in labels}
    mode: Literal["a", "w"] = "a" if group else "w"
    try:
        dataset.to_netcdf(temporary, mode=mode, group=group, engine="netcdf4", encoding=encoding)
    except RuntimeError as error:
        # What netCDF makes of a full disk.
        raise OSError(f"{output}: cannot be written: {error}") from None


def _stored(values: xr.DataArray, group: str | None) -> dict[str, Any]:
    """Return the netCDF encoding of a variable: compression, characters for words, digits."""
    if values.ndim < 2 and group != RUNS:
        return {}
    if values.dtype.kind in "OUT":
        # As characters words are compressed, unlike strings.
        return COMPRESSION | {"dtype": "S1"}
    if values.dtype == np.float32:
        digits = PROFILES if group in SYSTEMS else PLACES
        return COMPRESSION | {"quantize_mode": "BitRound", "significant_digits": digits}
    return COMPRESSION
