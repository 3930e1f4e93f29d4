"""The results of a study in Python: a short table of them, grids over parameters, and plots."""

import subprocess
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from html import escape
from math import prod
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pandas as pd
import xarray as xr
import yaml
from pydantic import ValidationError

from sim.base.errors import Allowed, InputError, count_text, printable
from sim.base.files import atomic_write
from sim.base.messages import input_error, one_of
from sim.base.numbers import plain
from sim.dataset import results as datasets
from sim.dataset.results import require_known_options
from sim.figures.caption import first_clause
from sim.parameters import NUMERICAL, SYSTEMS
from sim.parameters.variables import mask_failed
from sim.report.table import known_observables, point_table, points_of
from sim.study.command import environment, snakemake_command
from sim.study.feed import plot_entry
from sim.study.figure_spec import written
from sim.study.load import folder_of_results, load_study, parse_study
from sim.study.model import Point
from sim.study.plot_contents import PlotContents
from sim.study.plot_file import PlotFile
from sim.study.plottable import find_observable
from sim.surrogates.answers import answer_name, caveats_in, refusal_in, sentence
from sim.surrogates.storage import answer_files, find_surrogate, load_table
from sim.surrogates.surrogate import Surrogate

if TYPE_CHECKING:
    from matplotlib.figure import Figure

#: Most names, and most values of a parameter, in a line of the table.
MOST_SHOWN = 6

#: First line of a study file of a mapping.
_MARK = "# Written by talus.study, which replaces it.\n"

#: Most places of a grid per point.
MOST_PLACES = 10


@dataclass(frozen=True, repr=False)
class LabelledResults(datasets.Results):
    """The results of a study, with its surrogates, a table of what they hold, grids and plots.

    Of a study of one system, the dataset has no parameters of other systems.
    """

    def surrogate(self, name: str) -> Surrogate:
        """Return a surrogate of the study by its name, or the only one of an observable.

        Raises
        ------
        InputError
            When the results have no such surrogate, or its file is damaged.
        """
        return find_surrogate(self.runs.parent if self.runs else Path(), name)

    def table(
        self, name: str = "", *, of: Sequence[str] = (), system: str = "", series: str = ""
    ) -> pd.DataFrame:
        """Return the points as a table, or the table of a sensitivity or a propagation.

        Parameters
        ----------
        name : str
            The sensitivity or propagation; its last column has what is doubtful about it, if
            anything is. By default the table has a row per point: what varies, the regime, caveats,
            replicates that completed, and each observable with the half width of its 95 % interval.
        of : sequence of str
            Observables, with a unit if it is not to be that of the dataset: ``velocity (mm/s)``. By
            default the velocity and all declared ones that have a value.
        system, series : str
            System of the points, and their series; by default all.

        Raises
        ------
        InputError
            When the results have no such answer, observable, system or series, the answer was
            refused, or its file is damaged.
        """
        if not name:
            systems = [system] if system else list(dict.fromkeys(self.dataset["system"].values))
            parts = {
                str(one): point_table(self, str(one), self._series(str(one), series), of)
                for one in map(self._system, systems)
            }
            if len(parts) == 1:
                return next(iter(parts.values()))
            joined = pd.concat(parts, names=["system", None])
            return joined.reset_index("system").reset_index(drop=True)
        files = answer_files(self.runs.parent) if self.runs else []
        tables = {path.stem: path for path in files if path.suffix == ".csv"}
        if name not in tables:
            raise InputError.of_value("results", "table", name, one_of(name, tables))
        return load_table(tables[name])

    def to_grid(
        self, observable: str = "velocity", system: str = "", series: str = ""
    ) -> xr.DataArray:
        """Return an observable over the parameters that the points vary.

        Parameters
        ----------
        observable : str
            A number per replicate, named as in plots of a study.
        system : str
            System of the points, where the study has several.
        series : str
            Series of the points; by default all of the system.

        Returns
        -------
        xarray.DataArray
            Means over the replicates in SI units, NaN where no point stands. Its coordinates
            ``half_width``, ``regime`` and ``caveat`` have the half widths of the 95 % intervals,
            the regimes of the points and their caveats, empty where there is none.

        Raises
        ------
        InputError
            When there is no such observable, no parameter varies, several points share a place, or
            the points are spread as those of a design.
        """
        from sim.figures.data import varying_parameters
        from sim.figures.plot import observed_quantity

        system = self._system(system)
        found = find_observable("curves", "observable", observable, system, _grid_error)
        data = points_of(self, system, self._series(system, series), observable)
        names = varying_parameters(data.rows, list(SYSTEMS[system].model_fields))
        _require_grid(data.rows, names)
        quantity = observed_quantity(data)
        columns = {observable: quantity.value, "half_width": quantity.half_width}
        table, doubts = data.rows[names].assign(**columns), ["regime", "caveat"]
        table[doubts] = data.rows[doubts]
        stored = table.set_index(names).to_xarray()
        stored[doubts] = stored[doubts].fillna("").astype(str)
        grid = stored.set_coords(["half_width", *doubts])[observable]
        for name in names:
            grid[name].attrs = dict(self.dataset[name].attrs)
        grid["half_width"].attrs = {"units": found.unit, "long_name": "half width of 95 % interval"}
        return grid.assign_attrs(units=found.unit, long_name=found.meaning)

    def plot(self, **keys: Any) -> "Figure":
        """Draw a plot of the points, as the study would draw it.

        The keys are those of an entry under ``plots`` of a study file, without its ``name``. What
        would be a mistake there raises `InputError`.
        """
        from sim.figures.render import draw

        try:
            plot = PlotFile.model_validate({"name": "plot"} | keys)
        except ValidationError as error:
            paths = {name: f"plot.{name}" for name in (*PlotFile.model_fields, *keys)}
            raise input_error(error, PlotFile, "results", paths) from None
        require_known_options(self.dataset, Path("results"))
        points = self._points()
        series = list(dict.fromkeys(name for point in points for name in point.series))
        for name in plot.series or []:
            if name not in series:
                raise InputError.of_value("results", "plot.series", name, one_of(name, series))
        names = plot.series or series
        shown = [point for point in points if not set(names).isdisjoint(point.series)]
        return draw(plot_entry(PlotContents(plot, shown, "results", "plot"), names), self)

    def _points(self) -> list[Point]:
        columns = {str(name): one.values for name, one in self.dataset.coords.variables.items()}
        return [
            Point(
                str(point),
                datasets.parameters_of_row(columns, row),
                tuple(str(columns["series"][row]).split()),
                tuple(str(columns["figures"][row]).split()),
            )
            for row, point in enumerate(columns["point"])
        ]

    def _system(self, system: str) -> str:
        systems = list(dict.fromkeys(map(str, self.dataset["system"].values)))
        if not system and len(systems) == 1:
            return systems[0]
        if system not in systems:
            raise InputError.of_value("results", "system", system or None, one_of(system, systems))
        return system

    def _series(self, system: str, series: str) -> Sequence[str]:
        every = list(dict.fromkeys(" ".join(self.of(system)["series"].values).split()))
        if series and series not in every:
            raise InputError.of_value("results", "series", series, one_of(series, every))
        return [series] if series else every

    def _lines(self) -> list[tuple[str, str]]:
        from sim.figures.data import varying_parameters

        dataset = self.dataset
        lines = [("study", f"{dataset.attrs.get('study', '')}: {dataset.attrs.get('title', '')}")]
        for system in dict.fromkeys(map(str, dataset["system"].values)):
            rows = self.of(system)
            runs = int((rows["status"] == "completed").sum())
            regimes = pd.Series(rows["point_regime"].values).value_counts(sort=False)
            counts = ", ".join(f"{count} {name}" for name, count in regimes.items())
            lines.append((system, f"{count_text(rows.sizes['point'], 'point')}, {runs:,} runs"))
            lines.append(("  regimes", counts))
            fields = datasets.fields_of(system)
            table = pd.DataFrame({name: rows[name].values for name in fields if name in rows})
            varied = varying_parameters(table, list(table))
            texts = [f"{name} ({_few(pd.unique(table[name].sort_values()))})" for name in varied]
            lines.append(("  varied", _few(texts, "; ")))
            lines.append(("  observables", _few(known_observables(self, system))))
            texts = [str(text) for text in rows["caveat"].values if text]
            if texts:
                mostly = first_clause(max(dict.fromkeys(texts), key=texts.count))
                lines.append(("  caveats", f"{count_text(len(texts), 'point')}, mostly {mostly}"))
        for path in answer_files(self.runs.parent) if self.runs else ():
            lines.append((answer_name(path), sentence(caveats_in(path)) or refusal_in(path)))
        if len(self.boundaries):
            lines.append(("boundaries", count_text(len(self.boundaries), "row")))
        return [(heading, printable(text)) for heading, text in lines]

    def __repr__(self) -> str:
        return "\n".join(f"{heading:<13} {text}".rstrip() for heading, text in self._lines())

    def _repr_html_(self) -> str:
        rows = "".join(
            f"<tr><th style='text-align:left'>{escape(heading)}</th>"
            f"<td style='text-align:left'>{escape(text)}</td></tr>"
            for heading, text in self._lines()
        )
        return f"<table>{rows}</table>"


def load(results: str | Path) -> LabelledResults:
    """Load the results of a study.

    What was measured of failed replicates is not-a-number, and a warning counts their points.

    Parameters
    ----------
    results : str or Path
        The folder of the results, or the dataset in it.

    Raises
    ------
    InputError
        When there is no dataset, or it is damaged.
    """
    loaded = LabelledResults(**vars(datasets.load_results(results)))
    is_failed = (loaded.dataset["status"] == "failed").values
    if failed := int(is_failed.any(axis=1).sum()):
        counts = f"{failed} of {count_text(loaded.dataset.sizes['point'], 'point')}"
        warnings.warn(f"{results}: runs of {counts} failed, see status and reason", stacklevel=2)
    loaded = replace(loaded, dataset=mask_failed(loaded.dataset))
    systems = set(map(str, loaded.dataset["system"].values))
    return replace(loaded, dataset=loaded.of(*systems)) if len(systems) == 1 else loaded


def study(study: str | Path | Mapping[str, Any], cores: int | None = None) -> LabelledResults:
    """Run what is new of a study, up to its report, and load its results.

    It runs as by ``talus study``: in the present folder, or where its results are.

    Parameters
    ----------
    study : str, Path or mapping
        The study file, or a mapping with its contents. That is written to ``NAME.yaml`` in the
        present folder, unless a file of somebody else has that name.
    cores : int, optional
        Cores to use, by default all.

    Raises
    ------
    InputError
        For any mistake that prevents the study from being run as written.
    RuntimeError
        When a job failed; what it says was printed.
    """
    path = _written_study(study) if isinstance(study, Mapping) else Path(study)
    loaded = load_study(path)
    results = folder_of_results(loaded, Path("results"))
    # Its results beside the study file go on there.
    command = snakemake_command(path.absolute(), cores or "all")
    piped: dict[str, Any] = {"stdout": subprocess.PIPE, "stderr": subprocess.STDOUT}
    piped["cwd"] = results.parent
    # A notebook shows what is printed, and nothing of a process of its own.
    with subprocess.Popen(command, env=environment(), text=True, **piped) as process:
        for line in process.stdout or ():
            print(line, end="", flush=True)
    if process.returncode:
        raise RuntimeError(f"{path}: the study ended with code {process.returncode}, see above")
    return load(results / loaded.name)


def _written_study(contents: Mapping[str, Any]) -> Path:
    """Write the contents of a study file into the present folder, and return its path."""
    path = Path(f"{parse_study(plain(contents), 'study', None).name}.yaml")
    text = _MARK + yaml.safe_dump(plain(contents), sort_keys=False, allow_unicode=True)
    if path.exists() and not path.read_text("utf-8").startswith(_MARK):
        allowed = f"another name: {path} is there, and is not of talus.study"
        raise InputError.of_value("talus.study", "study", path.stem, allowed)
    with atomic_write(path) as temporary:
        temporary.write_text(text, "utf-8")
    return path


def _grid_error(key: str, value: Any, allowed: str | Allowed) -> InputError:
    return InputError.of_value("to_grid", key, value, allowed)


def _require_grid(rows: pd.DataFrame, names: list[str]) -> None:
    """Raise unless points vary parameters, each at a place of its own, and fill much of a grid."""
    if not names:
        allowed = "results whose points vary a parameter"
        raise _grid_error("", count_text(len(rows), "point"), allowed)
    shared = rows[rows.duplicated(names, keep=False)]
    if len(shared):
        place = shared[names].iloc[0]
        same = shared[(shared[names] == place).all(axis=1)]
        same = same[[name for name in sorted(NUMERICAL) if name in same]]
        differing = same.columns[same.nunique() > 1]
        got = ", ".join(f"{name} {written(value)}" for name, value in place.items())
        allowed = f"one point at each place: these differ in {', '.join(differing)}"
        raise _grid_error("", f"{len(same)} points at {got}", allowed)
    counts = {name: rows[name].nunique() for name in names}
    distinct = [name for name, count in counts.items() if count == len(rows) > 2]
    if len(distinct) > 1 or prod(counts.values()) > MOST_PLACES * len(rows):
        got = f"{len(rows):,} points at {prod(counts.values()):,} places of {', '.join(names)}"
        allowed = "a grid, as of one series; results.dataset has the points of a design as rows"
        raise _grid_error("", got, allowed)


def _few(items: Any, separator: str = ", ") -> str:
    texts = [written(item) if isinstance(item, float | int) else str(item) for item in items]
    others = [f"{len(texts) - MOST_SHOWN} more"] if len(texts) > MOST_SHOWN else []
    return separator.join(texts[:MOST_SHOWN] + others)
