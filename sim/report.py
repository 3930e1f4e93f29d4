"""The report of a study: one HTML file that needs nothing beside it."""

import base64
from collections.abc import Sequence
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import jinja2
import numpy as np
import pandas as pd
import xarray as xr

from sim import __version__
from sim.claims import force_balance
from sim.cost import duration
from sim.figures import FIGURES
from sim.figures.caption import setting
from sim.files import replacing
from sim.outcome import outcome
from sim.parameters import SYSTEMS, field_info
from sim.regime_boundaries import read_table
from sim.stored import reading
from sim.study import Study, load_study

TEMPLATES = Path(__file__).parent / "templates"

#: Largest part of the energy turned over that the ledger of a run may lack.
ENERGY_LIMIT = 0.005

_MEDIA = {".svg": "image/svg+xml", ".csv": "text/csv"}


def build(study_path: str | Path, results: str | Path = "results") -> Path:
    """Write ``results/<study>/report.html`` from the dataset and the figures of a study.

    Parameters
    ----------
    study_path : str or Path
        The study file.
    results : str or Path
        Folder of all results.

    Returns
    -------
    Path
        The file written. It appears complete or not at all.

    Raises
    ------
    InputError
        When the dataset or a file of a figure is missing or damaged, naming it.
    """
    study = load_study(study_path, results)
    folder = Path(results) / study.name
    path = folder / "dataset.nc"
    with (
        reading(path, "dataset", replaceable=True),
        xr.open_dataset(path, engine="netcdf4") as opened,
    ):
        dataset = opened.load()
    page = render(study, dataset, read_table(path), folder / "figures")
    output = folder / "report.html"
    with replacing(output) as temporary:
        temporary.write_text(page, encoding="utf-8")
    return output


def render(study: Study, dataset: xr.Dataset, found: pd.DataFrame, figures: Path) -> str:
    """Return the report as HTML text.

    Parameters
    ----------
    study : Study
        The study.
    dataset : xarray.Dataset
        Its dataset, loaded.
    found : pandas.DataFrame
        Its boundaries, as `sim.regime_boundaries.table` returns them.
    figures : Path
        Folder of its figures.
    """
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(TEMPLATES),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters["duration"] = duration
    runs = run_rows(dataset)
    completed = dataset["status"] == "completed"
    return environment.get_template("report.html.j2").render(
        study=study,
        study_text=Path(study.path).read_text(encoding="utf-8"),
        figures=[figure_entry(name, figures) for name in study.figures],
        runs=runs,
        failed=[run for run in runs if run["regime"] == "failed"],
        counts=pd.Series([run["regime"] for run in runs]).value_counts().to_dict(),
        steps=int(dataset["steps"].sum()),
        wall_time=float(dataset["wall_time"].sum()),
        parameters=parameter_rows(dataset),
        boundaries=boundary_rows(study, found),
        balance=force_balance.judge(dataset),
        energy_residual=float(np.abs(dataset["energy_residual"]).where(completed).max()),
        energy_limit=ENERGY_LIMIT,
        limits=force_balance.LIMITS,
        provenance={"talus": __version__, **_provenance(dataset)},
    )


def figure_entry(name: str, folder: Path) -> dict[str, Any]:
    """Return what the report shows of one figure, its files as data URIs."""
    files = {suffix: folder / f"{name}{suffix}" for suffix in (".svg", ".csv", ".caption.txt")}
    with reading(files[".csv"], "table of a figure", replaceable=True):
        velocities = pd.read_csv(files[".csv"])["mean velocity [m s-1]"].dropna().astype(float)
    with reading(files[".svg"], "picture", replaceable=True):
        ElementTree.parse(files[".svg"])
    with reading(files[".caption.txt"], "caption", replaceable=True):
        caption = files[".caption.txt"].read_text(encoding="utf-8").strip()
    extent = (
        f"from {velocities.min():.3g} to {velocities.max():.3g} m/s"
        if len(velocities)
        else "of no point"
    )
    spec = FIGURES[name]
    return {
        "name": name,
        "title": spec.title,
        "paper": spec.paper,
        "alt": f"{spec.title}: {len(velocities)} points, velocities {extent}.",
        "caption": caption,
        "svg": data_uri(files[".svg"]),
        "csv": data_uri(files[".csv"]),
    }


def data_uri(path: Path) -> str:
    """Return a file as a data URI."""
    content = base64.b64encode(path.read_bytes()).decode("ascii")
    return f"data:{_MEDIA[path.suffix]};base64,{content}"


def run_rows(dataset: xr.Dataset) -> list[dict[str, Any]]:
    """Return one row per point for the table of runs."""
    rows = []
    for index in range(dataset.sizes["point"]):
        point = dataset.isel(point=index)
        rows.append(
            {
                "point": str(point["point"].values),
                "series": str(point["series"].values).split(),
                "replicates": int(point["replicates"]),
                "steps": int(point["steps"].sum()),
                "wall_time": float(point["wall_time"].sum()),
                "max_overlap": float(point["max_overlap"].max()),
                "energy_residual": float(np.abs(point["energy_residual"]).max()),
                **outcome(point),
            }
        )
    return rows


def boundary_rows(study: Study, found: pd.DataFrame) -> list[dict[str, Any]]:
    """Return one row per boundary for the table of boundaries, its place in the grid in words."""
    rows = found.to_dict("records")
    for row, boundary in zip(rows, study.boundaries, strict=True):
        row["at"] = "; ".join(
            setting(row["system"], name, value) for name, value in boundary.grid.items()
        )
        row["tolerance"] = boundary.tolerance
    return rows


def parameter_rows(dataset: xr.Dataset) -> dict[str, list[dict[str, Any]]]:
    """Return the parameters of each system in the study with the values they take."""
    tables = {}
    for system, model in SYSTEMS.items():
        points = dataset.isel(point=(dataset["system"] == system).values)
        if points.sizes["point"]:
            tables[system] = [
                {
                    "name": name,
                    "symbol": row.symbol,
                    "unit": row.scale or row.unit.replace("1", ""),
                    "description": row.description,
                    "values": _values(points[name].values.tolist()),
                }
                for name, row in field_info(model).items()
                if name != "system"
            ]
    return tables


def _values(values: Sequence[Any]) -> str:
    """List distinct values in order, numbers with up to six digits."""
    distinct = sorted(set(values))
    return ", ".join(f"{v:.6g}" if isinstance(v, float) else str(v) for v in distinct)


def _provenance(dataset: xr.Dataset) -> dict[str, str]:
    return {
        "engine": dataset.attrs["engine_version"],
        "hash of the engine's sources": dataset.attrs["source_hash"],
        "libraries": dataset.attrs["versions"],
    }
