"""The page as a whole: what it is made from, its summary, its template."""

from collections import Counter
from pathlib import Path
from typing import Any

import xarray as xr

from sim.base.files import replacing
from sim.base.program import __version__
from sim.base.words import counted
from sim.dataset.agreement import require_agreement
from sim.dataset.caveats import CLOSED
from sim.dataset.results import Results, load_results
from sim.figures.drawn import require_unchanged
from sim.report.claims import (
    PAPERS,
    REPORTED,
    VERDICTS,
    claim_rows,
    counts,
    engine_checks,
    judged_by_runs,
    read_claims,
)
from sim.report.gallery import Address, data_uri, figure_entries, headline
from sim.report.readings import reading_tables
from sim.report.runs import (
    adopted_datasets,
    boundary_rows,
    parameter_rows,
    run_rows,
    varied_columns,
)
from sim.report.state import state_of
from sim.report.templating import template
from sim.study.load import Study, load_study


def build(study_path: str | Path, results: str | Path = "results") -> Path:
    """Write ``results/<study>/report.html`` from dataset, figures and verdicts of a study.

    Parameters
    ----------
    study_path : str or Path
        The study file.
    results : str or Path
        Folder of all results.

    Returns
    -------
    Path
        The file written. It appears complete or not at all. Without a ``claims.json`` in the
        folder it says that the claims have not been judged.

    Raises
    ------
    InputError
        When the dataset, the verdicts or a file of a figure is damaged, or it or that is missing,
        naming it, or the study has changed since the dataset was made.
    """
    study = load_study(study_path, results)
    folder = Path(results) / study.name
    found = load_results(folder / "dataset.nc")
    require_agreement(study, found, folder / "dataset.nc")
    require_unchanged(study.entries.values(), folder / "figures")
    output = folder / "report.html"
    with replacing(output) as temporary:
        claims = read_claims(folder / "claims.json")
        page = render(study, found, folder / "figures", claims, data_uri)
        temporary.write_text(page, encoding="utf-8")
    return output


def render(
    study: Study,
    results: Results,
    figures: Path,
    claims: list[dict[str, Any]],
    address: Address,
) -> str:
    """Return the report as HTML text.

    Parameters
    ----------
    study : Study
        The study.
    results : Results
        Its dataset.
    figures : Path
        Folder of its figures.
    claims : list of dict
        Its claims with their verdicts, as `sim.claims.written` writes them; empty if not judged.
    address : callable
        Puts figures into the page or links them, see `sim.report.gallery.figure_entries`.
    """
    dataset = results.dataset
    caveats = Counter(str(text) for text in dataset["caveat"].values if text).most_common()
    runs = run_rows(dataset, [text for text, _ in caveats])
    for run in runs:
        run["plots"] = [
            name
            for name, spec in study.plots.items()
            if spec.is_fed_by(run["system"], run["series"])
        ]
        run["adopted"], _ = results.adopted.get(run["point"], ("", ""))
        page = Path("pages") / f"{run['point']}.html"
        run["page"] = page.as_posix() if (figures.parent / page).is_file() else ""
    every = claim_rows(claims, runs, study.figures)
    rows = [row for row in every if row["paper"] in PAPERS]
    entries = figure_entries(study.entries.values(), figures, rows, address)
    order = _order(study, entries, judged_by_runs(rows))
    return template("report.html.j2").render(
        study=study,
        study_files={file.name: file.read_text(encoding="utf-8") for file in study.sources},
        summary=_summary(dataset, runs) | {"adopted": len(results.adopted)},
        caveats=caveats,
        verdicts=VERDICTS,
        outcomes=VERDICTS | REPORTED,
        claims=rows,
        own_claims=[row for row in every if row not in rows],
        counts=counts(rows),
        reading_tables=reading_tables(rows, results) if "claims" in order["parts"] else [],
        judged_by_runs=judged_by_runs(rows),
        **order,
        plots=[
            entry | {"points": [run for run in runs if entry["name"] in run["plots"]]}
            for entry in entries
            if entry["own"]
        ],
        headline=headline(entries),
        checks=engine_checks(rows),
        state=state_of(runs),
        runs=runs,
        varied=varied_columns(dataset) if order["own"] else [],
        parameters=parameter_rows(dataset),
        boundaries=boundary_rows(study, results.boundaries),
        energy_limit=CLOSED,
        provenance=_provenance(dataset) | _adopted(results) | _plugins(study),
    )


def _order(study: Study, entries: list[dict[str, Any]], tested: bool) -> dict[str, Any]:
    """Return whether a study is one's own, its gallery, and the sections behind the summary.

    It is unless all its figures are of the papers. Its plots and its points then come first, and
    claims of the papers last, where it feeds figures of theirs and its runs test some.
    """
    own = bool(study.plots) or not study.figures
    gallery = [entry for entry in entries if not entry["own"]]
    parts = ["claims", "figures"] if tested else ["figures", "claims"]
    if own:
        parts = [
            "runs",
            *(["figures"] if gallery else []),
            *(["claims"] if gallery and tested else []),
        ]
    return {"own": own, "gallery": gallery, "parts": parts}


def _summary(dataset: xr.Dataset, runs: list[dict[str, Any]]) -> dict[str, Any]:
    """Return the numbers of the first screen: what was run, and what it took."""
    completed, sound = dataset["status"] == "completed", dataset["caveat"] == ""
    missing = dataset["missing_energy"].where(completed)
    return {
        "points": len(runs),
        "failed": sum(run["regime"] == "failed" for run in runs),
        "replicates": int((dataset["status"] != "").sum()),
        "completed": int(completed.sum()),
        "regimes": Counter(run["regime"] for run in runs).most_common(),
        "steps": int(dataset["steps"].sum()),
        "wall_time": float(dataset["wall_time"].sum()),
        "missing_energy": float(missing.where(sound).max()),
        "missing_with_caveat": float(missing.where(~sound).max()),
        "with_caveat": int((~sound).sum()),
        "dates": _dates(dataset.attrs["first_run"], dataset.attrs["last_run"]),
        "talus": __version__,
        "source_hash": dataset.attrs["source_hash"],
    }


def _dates(first: str, last: str) -> str:
    """Write the days of two ISO times, once if they are the same.

    >>> _dates("2026-01-30T22:00:00Z", "2026-02-01T01:00:00Z")
    '2026-01-30 to 2026-02-01'
    """
    return " to ".join(dict.fromkeys((first[:10], last[:10])))


def _adopted(results: Results) -> dict[str, str]:
    """Return how many points come from which adopted datasets."""
    told = "; ".join(
        f"{counted(row['points'], 'point')} from dataset {row['dataset']}, "
        f"run {_dates(row['from'], row['to'])}"
        for row in adopted_datasets(results)
    )
    return {"Adopted": told} if told else {}


def _plugins(study: Study) -> dict[str, str]:
    """Return the plug-ins of a study with the hashes of their content."""
    told = ", ".join(f"{one.name} ({one.code})" for one in study.plugins)
    return {"Plug-ins": told} if told else {}


def _provenance(dataset: xr.Dataset) -> dict[str, str]:
    return {
        "Talus": __version__,
        "Engine": dataset.attrs["engine_version"],
        "Hash of the engine's sources": dataset.attrs["source_hash"],
        "Libraries": dataset.attrs["versions"],
    }
