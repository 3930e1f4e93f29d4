"""The runs of a study as one labelled table: ``dataset.nc`` over points and replicates.

Its root holds scalars; a group per system holds the profiles of its points, and a group
``states`` those of the particles of points that a figure shows particle by particle.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any, Literal

import numpy as np
import xarray as xr

from sim.base.errors import InputError
from sim.base.files import replacing, seal
from sim.base.reading import DamagedError
from sim.dataset.boundaries import table
from sim.dataset.boundary_table import GROUP
from sim.dataset.caveats import caveat
from sim.dataset.gather import NUMBERS, WORDS, Gathered, lined_up, profiles, read_run
from sim.dataset.replicates import outcomes
from sim.dataset.results import PARTICLES
from sim.dataset.rounds import refined, sides_of
from sim.dataset.sides import side
from sim.parameters import SYSTEMS, Parameters, field_info, point_id
from sim.study.catalogue import FIGURES
from sim.study.load import Boundary, Study, load_study
from sim.study.refine import Sides

#: How arrays are stored.
COMPRESSION = {"zlib": True, "complevel": 4, "shuffle": True}

_CAVEAT = {"long_name": "what to know before trusting the point"}


def build(study_path: str | Path, results: str | Path = "results") -> Path:
    """Combine the run files of a study into ``results/<study>/dataset.nc``.

    Parameters
    ----------
    study_path : str or Path
        The study file; its points name the run files in ``results/<study>/runs``, those of all
        rounds of refinement included.
    results : str or Path
        Folder of all results.

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

    @cache
    def read(point: str, shown: bool) -> Gathered:
        return read_run(folder / "runs" / f"{point}.nc", shown)

    def side_of(boundary: Boundary, parameters: Parameters) -> str | None:
        run = read(point_id(parameters), _are_shown(boundary.figures))
        return side(run.scalars, boundary.of, parameters)

    found = [sides_of(boundary, side_of) for boundary in study.boundaries]
    study = refined(study, found)
    runs = _all_runs(study, read)
    output = folder / "dataset.nc"
    with replacing(output) as temporary:
        for group, dataset in _groups(runs, study, found):
            _write(temporary, group, dataset, output)
        seal(temporary)
    return output


def _write(temporary: Path, group: str | None, dataset: xr.Dataset, output: Path) -> None:
    """Write a group to the draft of the file ``output``, the root first."""
    encoding = {name: _stored(dataset[name]) for name in dataset.data_vars}
    mode: Literal["a", "w"] = "a" if group else "w"
    try:
        dataset.to_netcdf(temporary, mode=mode, group=group, engine="netcdf4", encoding=encoding)
    except RuntimeError as error:
        # What netCDF makes of a full disk.
        raise OSError(f"{output}: cannot be written: {error}") from None


def _stored(values: xr.DataArray) -> dict[str, Any]:
    """Return how a variable is stored."""
    if values.ndim < 2:
        return {}
    if values.dtype.kind in "OUT":
        # As characters words are compressed, unlike strings.
        return COMPRESSION | {"dtype": "S1"}
    return COMPRESSION


def _are_shown(figures: Iterable[str]) -> bool:
    """Return whether one of some figures shows its points particle by particle."""
    return any(FIGURES[name].particles for name in figures)


def _all_runs(study: Study, read: Callable[[str, bool], Gathered]) -> list[Gathered]:
    """Read the runs of a study, all of them before a damaged one is reported."""
    runs, damaged = [], []
    for point in study.points.values():
        try:
            runs.append(read(point.id, _are_shown(point.figures)))
        except DamagedError as error:
            damaged.append(error)
    if damaged:
        others = f" (and {len(damaged) - 1} more)" if len(damaged) > 1 else ""
        raise InputError(f"{damaged[0]}{others}")
    return runs


def _groups(
    runs: Sequence[Gathered], study: Study, found: Sequence[Sides]
) -> Iterator[tuple[str | None, xr.Dataset]]:
    """Yield the groups of the dataset by name, the root first."""
    root = combine([run.scalars for run in runs], study)
    yield None, root
    for system in SYSTEMS:
        own = [run for run in runs if run.scalars.attrs["system"] == system]
        if own:
            yield system, profiles(own, root.sizes["replicate"])
    for run in runs:
        if run.state is not None:
            yield f"{PARTICLES}/{run.scalars.attrs['point_id']}", run.state
    if study.boundaries:
        yield GROUP, table(study, found).to_xarray()


def combine(runs: Sequence[xr.Dataset], study: Study) -> xr.Dataset:
    """Line up runs along ``point`` and their replicates along ``replicate``.

    Parameters
    ----------
    runs : sequence of xarray.Dataset
        Scalars of the runs of the study, in the order of its points.
    study : Study
        Says which series and figures each point belongs to.

    Returns
    -------
    xarray.Dataset
        Variables over (point, replicate), padded with NaN and ``""`` where a point has fewer
        replicates than another; every parameter of both systems as a coordinate over ``point``,
        NaN or ``""`` where it is not one of the point's system.
    """
    replicates = max(run.sizes["replicate"] for run in runs)
    names = [name for name in (*NUMBERS, *WORDS) if any(name in run for run in runs)]
    own = [{name: run.variables[name] for name in names if name in run} for run in runs]
    combined = lined_up(own, "point", replicates)[names].assign_coords(
        _labels(runs, study)
        | _parameters(runs)
        | {"replicate": ("replicate", np.arange(replicates))}
    )
    combined.attrs = _attributes(runs, study)
    return combined.assign(_together(combined))


def _together(combined: xr.Dataset) -> dict[str, Any]:
    """Return what the replicates of each point say together, see `sim.dataset.replicates`."""
    found = outcomes(combined)
    numbers = {"velocity": "mean velocity", "half_width": "half width of its 95 % interval"}
    made = {
        f"point_{name}": (
            "point",
            np.array([each[name] for each in found], float),
            {"units": "m s-1", "long_name": f"{text}, all replicates together"},
        )
        for name, text in numbers.items()
    }
    for name in ("regime", "quality", "stopped"):
        made[f"point_{name}"] = _words(each[name] for each in found)
    return made


def _attributes(runs: Sequence[xr.Dataset], study: Study) -> dict[str, str]:
    """Return the global attributes: what this is and what made its runs."""
    return {
        "Conventions": "CF-1.11",
        "title": study.title or study.name,
        "study": study.name,
        "engine_version": _distinct(runs, "engine_version"),
        "numerics": _distinct(runs, "numerics"),
        "source_hash": _distinct(runs, "source_hash"),
        "versions": _distinct(runs, "versions"),
        "first_run": min(run.attrs["created"] for run in runs),
        "last_run": max(run.attrs["created"] for run in runs),
    }


def _labels(runs: Sequence[xr.Dataset], study: Study) -> dict[str, Any]:
    """Return what names a point and where its run came from, as coordinates."""
    points = list(study.points.values())
    return {
        "point": ("point", [point.id for point in points], {"long_name": "point id"}),
        "series": _words(" ".join(point.series) for point in points),
        "figures": _words(" ".join(point.figures) for point in points),
        "caveat": _words(map(_caveat, runs), _CAVEAT),
        "run_source_hash": _words(run.attrs["source_hash"] for run in runs),
        "particles": ("point", [int(run["particles"]) for run in runs], {"units": "1"}),
    }


def _caveat(run: xr.Dataset) -> str:
    return caveat(run.attrs.get("caveat", ""), run["missing_energy"].values)


def _parameters(runs: Sequence[xr.Dataset]) -> dict[str, Any]:
    """Return every parameter of both systems as a coordinate with its unit."""
    names = {name: None for model in SYSTEMS.values() for name in model.model_fields}
    return {name: _parameter(runs, name) for name in names}


def _parameter(runs: Sequence[xr.Dataset], name: str) -> Any:
    values = [run[name].values.item() if name in run else None for run in runs]
    attrs = {"long_name": _declared(name, "description")}
    if any(isinstance(value, str) for value in values):
        return _words(("" if value is None else value for value in values), attrs)
    for kind in ("units", "comment"):
        given = {run.attrs["system"]: run[name].attrs.get(kind) for run in runs if name in run}
        # Two units in one attribute could be read by nobody; as a comment they can.
        kept = kind if len(set(given.values())) == 1 else "comment"
        if any(given.values()):
            attrs[kept] = "; ".join(filter(None, (attrs.get(kept), _by_system(given))))
    return "point", np.array([np.nan if value is None else value for value in values], float), attrs


def _by_system(texts: Mapping[str, str | None]) -> str:
    """Write a text per system, or once where the systems agree."""
    if len(set(texts.values())) == 1:
        return next(iter(texts.values())) or ""
    return "; ".join(f"{system}: {text}" for system, text in texts.items() if text)


def _declared(name: str, what: str) -> str:
    """Join what the systems declare about a parameter, once where they agree."""
    rows = [field_info(model).get(name) for model in SYSTEMS.values()]
    return "; ".join(dict.fromkeys(getattr(row, what) for row in rows if row))


def _words(values: Any, attrs: Mapping[str, str] | None = None) -> Any:
    return "point", np.array(list(values), dtype=object), dict(attrs or {})


def _distinct(runs: Sequence[xr.Dataset], attribute: str) -> str:
    return ", ".join(dict.fromkeys(run.attrs[attribute] for run in runs))
