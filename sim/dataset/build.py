"""The runs of a study as one labelled table: ``dataset.nc`` over points and replicates.

Its root holds scalars; groups ``natural`` and ``si`` hold velocities in natural units and
parameters in SI, a group per system the profiles of its points, a group ``states`` those of the
particles of points that a figure shows particle by particle, and a group ``runs`` says which run
file each row was read from, so that it need not be read again.
"""

from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any, Literal

import xarray as xr

from sim.base.files import replacing, seal
from sim.dataset.boundaries import table
from sim.dataset.boundary_side import side
from sim.dataset.boundary_table import GROUP
from sim.dataset.combine import profiles, root, runs
from sim.dataset.earlier import RUNS, keep
from sim.dataset.results import PARTICLES
from sim.dataset.rounds import as_wanted, refined, sides_of
from sim.dataset.rows import Rows, selected
from sim.dataset.runs import Runs
from sim.dataset.units import in_natural_units, in_si_units
from sim.parameters import SYSTEMS, Parameters, point_id
from sim.study.catalogue import FIGURES
from sim.study.load import Boundary, Study, load_study
from sim.study.refine import Sides

#: How arrays are stored.
COMPRESSION = {"zlib": True, "complevel": 4, "shuffle": True}


def build(
    study_path: str | Path,
    results: str | Path = "results",
    processes: int = 1,
    scheduler: str | None = None,
) -> Path:
    """Combine the run files of a study into ``results/<study>/dataset.nc``.

    Run files that are those of an earlier dataset are not read again; the result is the same.

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

    Returns
    -------
    Path
        The file written. It appears complete or not at all. What was found of boundaries is in
        its group ``boundaries``.

    Raises
    ------
    InputError
        When a run file is missing or is damaged, naming it. All damaged ones are set aside, so that
        the workflow computes them again.
    """
    study = load_study(study_path, results)
    folder = Path(results) / study.name
    shown = {point.id for point in study.points.values() if _are_shown(point.figures)}
    # Which points of later rounds there are, and which figures they feed, is not known yet.
    everything = any(_are_shown(boundary.figures) for boundary in study.boundaries)
    held = Runs(folder, lambda point: everything or point in shown, processes, scheduler)
    held.read({key: point.parameters for key, point in study.points.items()})
    found = _sides(study, held)
    study = refined(study, found)
    output = folder / "dataset.nc"
    with replacing(output) as temporary:
        for group, dataset in _groups(held.rows(study.points), study, found):
            _write(temporary, group, dataset, output)
        seal(temporary)
        keep(temporary, folder)
    return output


def _sides(study: Study, held: Runs) -> Sequence[Sides]:
    """Return the sides found of each boundary, round after round, whose runs are read as well."""

    def side_of(boundary: Boundary, parameters: Parameters) -> str | None:
        return side(held.scalars(point_id(parameters)), boundary.of, parameters)

    def read_round(points: Iterable[Parameters]) -> None:
        held.read({point_id(point): as_wanted(study, point) for point in points})

    return sides_of(study.boundaries, side_of, read_round)


def _are_shown(figures: Iterable[str]) -> bool:
    """Return whether one of some figures shows its points particle by particle."""
    return any(FIGURES[name].particles for name in figures)


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
        if key in states and _are_shown(point.figures):
            state = states[key].drop_encoding()
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
    """Return the netCDF encoding of a variable: compression, and characters for words."""
    if values.ndim < 2 and group != RUNS:
        return {}
    if values.dtype.kind in "OUT":
        # As characters words are compressed, unlike strings.
        return COMPRESSION | {"dtype": "S1"}
    return COMPRESSION
