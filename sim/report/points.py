"""The points of a study, as a table and as JSON."""

import json
import sys
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import psutil

from sim.base.errors import InputError, align_table, count_text, duration
from sim.base.files import require_writable
from sim.base.program import program
from sim.dataset.rounds import require_start_files
from sim.engine.shared_runs import SharedRun, describe, find_runs
from sim.parameters import complete_values, field_info
from sim.parameters.density import doubts_of
from sim.report import earlier_regimes
from sim.study.load import Point, Study, load_study
from sim.study.papers import paper_value_lines
from sim.study.plot_contents import SCATTER_HINT
from sim.study.points import PARTS, Estimate, divide_range, estimate

CORES = 2
MEGABYTE = 1e6

#: Most points named in the line of a caveat.
MOST_NAMED = 3

#: Largest length (m) of a particle that is not taken for one in another unit.
LARGEST_LENGTH = 0.1

_HEADINGS = ("id", "system", "particles", "steps", "core time", "figures", "series")
_RIGHT = {"particles", "steps", "core time"}

_NOTHING: Mapping[str, Any] = {}


def show(path: Path, results: Path, format: str, as_point: bool = False) -> str:
    """Return the points of a study as ``table`` or ``json``, after warnings on standard error.

    Of a run file it is what the file holds, or with ``as_point`` the point file that makes it.
    """
    if path.suffix == ".nc":
        # It needs the libraries of run files.
        from sim.report.info import describe as describe_run

        return describe_run(path, as_point)
    study = load_study(path, None)
    require_start_files(study)
    for warning in warnings(study, results):
        print(f"warning: {warning}", file=sys.stderr)
    points = {key: point.parameters for key, point in study.points.items()}
    shared = find_runs(results / study.name / "runs", points, study.need)
    if format == "json":
        return as_json(study, shared)
    earlier = earlier_regimes.lines(study, results)
    return "\n".join((as_table(study, shared), *_run_lines(study, results), *earlier))


def as_table(study: Study, shared: Mapping[str, SharedRun] = _NOTHING) -> str:
    """Return an aligned line per point, then what is known of the study, and totals.

    That is designs, plots, points that figures omit, and caveats. ``shared`` are the runs that
    other studies have. ``steps`` and ``core time`` are sums over all replicates of a point.
    """
    costs = _costs(study)
    rows = [_row(point, costs[point.id]) for point in study.points.values()]
    sections = [
        align_table(_HEADINGS, rows, _RIGHT),
        _design_lines(study),
        _plot_lines(study),
        study.omission_notes,
        [*_caveat_lines(study), *_pair_lines(study)],
        paper_value_lines(point.parameters for point in study.points.values()),
        [
            _total_line(list(costs.values())),
            *_shared_lines(shared, costs),
            *_trajectory_lines(list(costs.values())),
            *([_refinement_line(study)] if study.boundaries else []),
            *_surrogate_lines(study),
            *([_decision_line(study.decide.budget)] if study.decide else []),
        ],
    ]
    return "\n\n".join("\n".join(lines) for lines in sections if lines)


def as_json(study: Study, shared: Mapping[str, SharedRun] = _NOTHING) -> str:
    """Return the study, its points with all parameters, and the totals as JSON; see `as_table`."""
    costs = _costs(study)
    points = [
        {
            "id": point.id,
            "system": point.parameters.system,
            "series": point.series,
            "figures": point.figures,
            "left_out": point.left_out,
            "caveat": point.parameters.caveat,
            "shared": str(shared[point.id].path) if point.id in shared else "",
            "particles": costs[point.id].particles,
            "steps": costs[point.id].steps,
            "core_seconds": round(costs[point.id].core_seconds, 3),
            "trajectory_frames": costs[point.id].frames,
            "trajectory_megabytes": round(costs[point.id].trajectory, 3),
            "parameters": complete_values(point.parameters),
        }
        for point in study.points.values()
    ]
    totals = {
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
    yield from _doubtful_lengths(study)
    yield from doubts_of(point.parameters for point in study.points.values())
    memory = psutil.virtual_memory().total / MEGABYTE
    for key, cost in _costs(study).items():
        if cost.memory > memory:
            yield f"{key}: needs about {cost.memory:,} MB of memory, this machine has {memory:,.0f}"
    try:
        require_writable(results / study.name, f"{study.path}: study")
    except InputError as error:
        yield str(error)


def _doubtful_lengths(study: Study) -> Iterator[str]:
    lengths = Counter(
        (row.name, getattr(parameters, row.name))
        for parameters in (point.parameters for point in study.points.values())
        for row in field_info(parameters).values()
        if row.unit == "m"
    )
    for (name, value), count in lengths.items():
        if value > LARGEST_LENGTH:
            yield (
                f"{name}: {value:g} at {count_text(count, 'point')} is {value:g} m; if you mean "
                f"{value:g} mm, write {value / 1000:g}"
            )


def _costs(study: Study) -> dict[str, Estimate]:
    return {key: estimate(point.parameters) for key, point in study.points.items()}


def _row(point: Point, cost: Estimate) -> tuple[str, ...]:
    return (
        point.id,
        point.parameters.system,
        f"{cost.particles:,}",
        f"{cost.steps:,}",
        duration(cost.core_seconds),
        ",".join(point.figures) or "-",
        ",".join(point.series),
    )


def _design_lines(study: Study) -> list[str]:
    return [
        f"design {name}: {design.kind}, {count_text(design.size, 'point')} over "
        f"{', '.join(design.names)}"
        + (f", of which {different:,} differ and are run once" if different < design.size else "")
        + f"; more points later {'replace' if design.kind == 'latin_hypercube' else 'keep'} these"
        for name, design in study.designs.items()
        for different in [len({tuple(row.values()) for row in design.rows(design.size)})]
    ]


def _plot_lines(study: Study) -> list[str]:
    return [
        f"plot {name}: {spec.title} ({count_text(len(study.figures[name]), 'point')})"
        + f"; {SCATTER_HINT}" * bool(spec.scattered)
        for name, spec in study.plots.items()
    ]


def _caveat_lines(study: Study) -> list[str]:
    """Return a line per caveat that is known before any run, with its first points."""
    ids_by_caveat: dict[str, list[str]] = {}
    for point in study.points.values():
        if point.parameters.caveat:
            ids_by_caveat.setdefault(point.parameters.caveat, []).append(point.id)
    return [
        f"caveat for {len(ids):,} of {count_text(len(study.points), 'point')}: {text} "
        f"({', '.join(ids[:MOST_NAMED])}"
        + (f" and {len(ids) - MOST_NAMED:,} more)" if len(ids) > MOST_NAMED else ")")
        for text, ids in ids_by_caveat.items()
    ]


def _pair_lines(study: Study) -> list[str]:
    pairs = sum(point.parameters.replicates == 2 for point in study.points.values())
    return [
        f"warning of replicates: 2 at {count_text(pairs, 'point')}: the 95 % interval of two is "
        "12.7 standard errors to either side, of three 4.3; three or more are better"
    ] * (pairs > 0)


def _total_line(costs: Sequence[Estimate]) -> str:
    steps = sum(cost.steps for cost in costs)
    total = sum(cost.core_seconds for cost in costs)
    longest = max(cost.core_seconds for cost in costs)
    return (
        f"{count_text(len(costs), 'point')}, {steps:,} steps, estimated core time "
        f"{duration(total)}, on {CORES} cores {duration(max(total / CORES, longest))}; "
        "computing alone, without compilation, Snakemake and figures"
    )


def _shared_lines(shared: Mapping[str, SharedRun], costs: Mapping[str, Estimate]) -> list[str]:
    seconds = sum(
        cost.core_seconds
        for key, cost in costs.items()
        if not (key in shared and shared[key].is_enough)
    )
    line = describe(shared.values())
    return [f"{line}; core time of the others {duration(seconds)}"] if line else []


def _trajectory_lines(costs: Sequence[Estimate]) -> list[str]:
    sizes = [cost.trajectory for cost in costs if cost.trajectory]
    if not sizes:
        return []
    frames = sum(cost.frames for cost in costs)
    return [
        f"trajectories of {count_text(len(sizes), 'point')}: at most "
        f"{count_text(frames, 'frame')}, {sum(sizes):,.1f} MB on the disk, "
        f"{max(sizes):,.1f} MB of one point"
    ]


def _run_lines(study: Study, results: Path) -> list[str]:
    folder = results / study.name
    if not (folder / "runs").is_dir():
        return []
    # It needs the libraries of run files.
    from sim.report.status import survey

    status = survey(study, results)
    ended = sum(status.points[point].state in ("done", "failed") for point in study.points)
    return [
        f"{ended:,} of {count_text(len(study.points), 'point')} have been run in {folder}; core "
        f"time of the others {duration(status.core_seconds_left)}"
    ] * (ended > 0)


def _decision_line(budget: float) -> str:
    return f"decisions ({program()} decide) may add up to {budget:g} core hours"


def _surrogate_lines(study: Study) -> list[str]:
    return [
        f"surrogate {one.name}: rounds of {count_text(one.batch, 'point')} may add up to "
        f"{one.budget:g} core hours, until its error is {100 * one.error:g} %"
        for one in study.surrogates
        if one.has_rounds
    ]


def _refinement_line(study: Study) -> str:
    """Write what rounds of refinement add: each divides one gap per boundary.

    The estimate assumes that no run is undecided.
    """
    count, total = 0, 0.0
    rounds = max(boundary.rounds for boundary in study.boundaries)
    for boundary in study.boundaries:
        estimates = [
            estimate(boundary.parameters_at(value))
            for value in divide_range(boundary.low, boundary.high)
        ]
        points_added = (PARTS - 1) * boundary.rounds
        count += points_added
        total += points_added * sum(cost.core_seconds for cost in estimates) / len(estimates)
    return (
        f"{rounds} rounds of refinement for {len(study.boundaries):,} boundaries: about "
        f"{count:,} further points, estimated core time {duration(total)}"
    )
