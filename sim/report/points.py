"""The points of a study, as a table and as JSON."""

import json
import re
import sys
from collections import Counter
from collections.abc import Iterator, Mapping
from pathlib import Path
from statistics import fmean, median
from typing import Any

import psutil

from sim.base.errors import InputError, align_table, count_text, duration
from sim.base.files import require_writable
from sim.base.program import program
from sim.base.yaml import read_yaml
from sim.dataset.rounds import require_start_files
from sim.engine.shared_runs import SharedRun, describe, find_runs
from sim.parameters import Parameters, complete_values
from sim.parameters.doubts import doubts_of
from sim.parameters.points import ID_LENGTH
from sim.study.entries import ends_left_out
from sim.study.figure_spec import written
from sim.study.load import Study, as_study, folder_of_results, parse_study
from sim.study.model import PARTS, Boundary, Estimate, divide_range, estimate
from sim.study.papers import paper_value_lines
from sim.study.plot_contents import SCATTER_HINT, varying_parameters

CORES = 2
MEGABYTE = 1e6

#: Lengths of runs are similar up to this factor.
SIMILAR = 2.0

_HEADINGS = ("id", "system", "particles", "steps", "core time", "figures", "series")
_RIGHT = {"particles", "steps", "core time"}

_NOTHING: Mapping[str, Any] = {}


def show(path: Path, format: str, as_point: bool = False, results: Path = Path("results")) -> str:
    """Return the points of a study as ``table`` or ``json``, after warnings on standard error.

    A point file is a study of one point. Of a run file it is what the file holds, or with
    ``as_point`` the point file that makes it.
    """
    if path.suffix == ".nc":
        # It needs the libraries of run files.
        from sim.report.runs import describe_run

        return describe_run(path, as_point)
    contents = read_yaml(path)
    study = parse_study(as_study(contents, path), path, None)
    results = folder_of_results(study, results)
    require_start_files(study)
    if study.plugins:
        # It needs the libraries of judges.
        from sim.claims.sources import require_plugins

        require_plugins(study.plugins)
    for warning in (*ends_left_out(contents), *warnings(study, results)):
        print(f"warning: {warning}", file=sys.stderr)
    points = {key: point.parameters for key, point in study.points.items()}
    shared = find_runs(results / study.name / "runs", points, study.need)
    if format == "json":
        return as_json(study, shared)
    table = as_table(study, shared, _what_has_run(study, results))
    return "\n".join((table, *earlier_lines(study, results)))


def as_table(
    study: Study, shared: Mapping[str, SharedRun] = _NOTHING, run: Mapping[str, Any] = _NOTHING
) -> str:
    """Return an aligned line per point, then what is known of the study, and totals.

    That is designs, plots, points that figures omit, and caveats. ``shared`` are the runs that
    other studies have; ``run`` is what `_what_has_run` tells of those of this study. ``steps`` and
    ``core time`` are sums over all replicates of a point.
    """
    # Imported here, as few commands write by templates.
    from sim.report.numbers import template

    costs, shown, points = _costs(study), _shown_ids(study), study.points.values()
    rows = [
        (
            shown[point.id],
            point.parameters.system,
            f"{costs[point.id].particles:,}",
            f"{costs[point.id].steps:,}",
            duration(costs[point.id].core_seconds),
            ",".join(point.figures) or "-",
            ",".join(point.series),
        )
        for point in points
    ]
    designs = [
        (name, design, len({tuple(row.values()) for row in design.rows(design.size)}))
        for name, design in study.designs.items()
    ]
    caveats: dict[str, list[str]] = {}
    restitutions: dict[str, list[float]] = {}
    for point in points:
        if text := point.parameters.caveat:
            caveats.setdefault(text, []).append(point.id)
        for partner, value in getattr(point.parameters, "restitutions", {}).items():
            restitutions.setdefault(partner, []).append(value)
    throws = [getattr(point.parameters, "throw_number", 0.0) for point in points]
    seconds = {key: cost.core_seconds for key, cost in costs.items()}
    total = sum(seconds.values())
    text = template("points.txt.j2").render(
        study=study,
        table=align_table(_HEADINGS, rows, _RIGHT),
        designs=designs,
        hint=SCATTER_HINT,
        caveats=caveats,
        pairs=sum(point.parameters.replicates == 2 for point in points),
        paper_values=paper_value_lines([one.parameters for one in points], study.paper),
        restitutions=restitutions,
        throws=sorted(filter(None, throws)),
        costs=list(costs.values()),
        cores=CORES,
        seconds=total,
        seconds_on_cores=max(total / CORES, *seconds.values()),
        seconds_not_shared=total - sum(seconds[key] for key in shared if shared[key].is_enough),
        shared=describe(shared.values()),
        sizes=[cost.trajectory for cost in costs.values() if cost.trajectory],
        further=(PARTS - 1) * sum(boundary.rounds for boundary in study.boundaries),
        seconds_further=sum(map(_further_seconds, study.boundaries)),
        program=program(),
        run=run,
    )
    return re.sub(r"\n{3,}", "\n\n", text).strip()


def _shown_ids(study: Study) -> dict[str, str]:
    """Return what the table shows of ids: of one that is cut, what varies, and its hash.

    A study names it so in ``start_from``, too.
    """
    by_system: dict[str, list[Parameters]] = {}
    for point in study.points.values():
        by_system.setdefault(point.parameters.system, []).append(point.parameters)
    varied = {system: varying_parameters(members) for system, members in by_system.items()}
    shown = {}
    for key, point in study.points.items():
        one, is_cut = point.parameters, len(key) > ID_LENGTH
        left = one.without_effect(vars(one)) | {"start_from"}
        names = (name for name in varied[one.system] if name not in left)
        texts = [f"{name}{written(getattr(one, name))}" for name in names]
        shown[key] = "-".join([one.system, *texts, key.rpartition("-")[2]]) if is_cut else key
    return shown


def as_json(study: Study, shared: Mapping[str, SharedRun] = _NOTHING) -> str:
    """Return the study, its points with all parameters, and the totals as JSON; see `as_table`."""
    costs = _costs(study)
    points = [
        {
            "id": key,
            "system": point.parameters.system,
            "series": point.series,
            "figures": point.figures,
            "left_out": point.left_out,
            "caveat": point.parameters.caveat,
            "shared": str(shared[key].path) if key in shared else "",
            "particles": costs[key].particles,
            "steps": costs[key].steps,
            "core_seconds": round(costs[key].core_seconds, 3),
            "trajectory_frames": costs[key].frames,
            "trajectory_megabytes": round(costs[key].trajectory, 3),
            "parameters": complete_values(point.parameters),
        }
        for key, point in study.points.items()
    ]
    totals: dict[str, float] = {
        "points": len(points),
        "steps": sum(cost.steps for cost in costs.values()),
        "core_seconds": round(sum(cost.core_seconds for cost in costs.values()), 3),
    }
    if study.decide:
        totals["decisions_core_hours"] = study.decide.budget
    if any(one.has_rounds for one in study.surrogates):
        totals["surrogates_core_hours"] = sum(one.budget for one in study.surrogates)
    document = {"study": study.name, "title": study.title, "points": points, "totals": totals}
    return json.dumps(document, indent=2, ensure_ascii=False)


def warnings(study: Study, results: Path) -> Iterator[str]:
    """Yield what to look at before a run of the study here.

    That is too little memory, no permission to write, and sizes that are probably not meant.
    """
    points = [point.parameters for point in study.points.values()]
    yield from () if study.units == "natural" else doubts_of(points)
    memory = psutil.virtual_memory().total / MEGABYTE
    for key, cost in _costs(study).items():
        if cost.memory > memory:
            yield f"{key}: needs about {cost.memory:,} MB of memory, this machine has {memory:,.0f}"
    try:
        require_writable(results / study.name, f"{study.path}: study")
    except InputError as error:
        yield str(error)


def _costs(study: Study) -> dict[str, Estimate]:
    return {key: estimate(point.parameters) for key, point in study.points.items()}


def _further_seconds(boundary: Boundary) -> float:
    """Return the core time (s) of the points that rounds of a boundary add, each dividing one gap.

    The estimate assumes that no run is undecided.
    """
    values = divide_range(boundary.low, boundary.high)
    each = fmean(estimate(boundary.parameters_at(value)).core_seconds for value in values)
    return (PARTS - 1) * boundary.rounds * each


def _what_has_run(study: Study, results: Path) -> Mapping[str, Any]:
    """Return how many points have ended, if any, where, and the core time (s) of the others."""
    folder = results / study.name
    if not (folder / "runs").is_dir():
        return _NOTHING
    # It needs the libraries of run files.
    from sim.report.status import survey

    status = survey(study, results)
    ended = sum(status.points[point].state in ("done", "failed") for point in study.points)
    left = {"ended": ended, "folder": folder, "seconds_left": status.core_seconds_left}
    return left if ended else _NOTHING


def earlier_lines(study: Study, results: Path) -> list[str]:
    """Return a line for each series that is asked a question: how runs of its length ended before.

    These are points of all datasets in the results, of the system, with at most twice and at least
    half of the length. There is no line where the results have none.
    """
    lines = []
    series = dict.fromkeys(spec.of.series for spec in study.questions)
    earlier = list(_earlier_points(results)) if series else []
    for name in series:
        points = [study.points[key].parameters for key in study.series[name]]
        length = median(point.transient + point.average for point in points)
        regimes = Counter(
            regime
            for system, other, regime in earlier
            if system == points[0].system and length / SIMILAR <= other <= length * SIMILAR
        )
        if regimes:
            names = ["steady", *(one for one, _ in regimes.most_common() if one != "steady")]
            lines.append(
                f"series {name}: of {count_text(regimes.total(), 'point')} with runs of such a "
                "length in the results here, "
                + ", ".join(f"{regimes[one]:,} {one}" for one in names)
            )
    return lines


def _earlier_points(results: Path) -> Iterator[tuple[str, float, str]]:
    """Yield system, length in its time unit and regime of the points of all datasets in results.

    Damaged datasets have none.
    """
    # Imported here: it takes longer than a table without such lines.
    import netCDF4

    names = ("system", "transient", "average", "point_regime")
    for path in sorted(results.glob("*/dataset.nc")):
        try:
            with netCDF4.Dataset(path) as file:
                columns = [file[name][:].tolist() for name in names]
        except (OSError, RuntimeError, LookupError):
            continue
        for system, transient, average, regime in zip(*columns, strict=True):
            yield str(system), float(transient) + float(average), str(regime)
