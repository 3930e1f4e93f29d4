"""The points of a study as a table to read and as JSON for other programs."""

import json
import sys
from collections.abc import Container, Iterator, Mapping, Sequence
from pathlib import Path

import psutil

from sim.base.errors import InputError
from sim.base.files import require_writable
from sim.base.program import program
from sim.base.words import counted, duration
from sim.dataset.adopted import Adopted
from sim.dataset.starts import require_start_files
from sim.parameters import complete
from sim.study.cost import Estimate, estimate
from sim.study.figure_points import left_out
from sim.study.load import Point, Study, load_study
from sim.study.refine import PARTS, divided

CORES = 2
MEGABYTE = 1e6

#: Most points that the line of a caveat names.
MOST_NAMED = 3

_HEADINGS = ("id", "system", "particles", "steps", "core time", "figures", "series")
_RIGHT = {"particles", "steps", "core time"}

_NONE: Mapping[str, str] = {}


def show(study_path: Path, results: Path, format: str) -> str:
    """Return the points of a study as ``table`` or ``json``, after warnings on standard error."""
    study = load_study(study_path, None)
    require_start_files(study)
    for warning in warnings(study, results):
        print(f"warning: {warning}", file=sys.stderr)
    points = {key: point.parameters for key, point in study.points.items()}
    sources = Adopted(study, results / study.name).sources(points)
    adopted = {key: held.dataset.stem for key, held in sources.items()}
    return as_json(study, adopted) if format == "json" else as_table(study, adopted)


def as_table(study: Study, adopted: Mapping[str, str] = _NONE) -> str:
    """Return one aligned line per point; below, what figures leave out, caveats, and the totals.

    ``adopted`` are the datasets from which points are taken, by id of the point.
    ``steps`` and ``core time`` are over all replicates of a point.
    """
    costs = _costs(study)
    rows = [_row(point, costs[point.id]) for point in study.points.values()]
    sections = [
        aligned(_HEADINGS, rows, _RIGHT),
        _plots(study),
        left_out(study),
        _caveats(study),
        [
            _totals(list(costs.values())),
            *_adopted(adopted, costs),
            *_trajectories(list(costs.values())),
            *([_refinement(study)] if study.rounds else []),
            *([_decisions(study.decide.budget)] if study.decide else []),
        ],
    ]
    return "\n\n".join("\n".join(lines) for lines in sections if lines)


def as_json(study: Study, adopted: Mapping[str, str] = _NONE) -> str:
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
            "adopted": adopted.get(point.id, ""),
            "particles": costs[point.id].particles,
            "steps": costs[point.id].steps,
            "core_seconds": round(costs[point.id].core_seconds, 3),
            "trajectory_megabytes": round(costs[point.id].trajectory, 3),
            "parameters": complete(point.parameters),
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
    document = {"study": study.name, "title": study.title, "points": points, "totals": totals}
    return json.dumps(document, indent=2, ensure_ascii=False)


def warnings(study: Study, results: Path) -> Iterator[str]:
    """Yield what would keep the study from being run here: too little memory, no place to write."""
    here = psutil.virtual_memory().total / MEGABYTE
    for key, cost in _costs(study).items():
        if cost.memory > here:
            yield f"{key}: needs about {cost.memory:,} MB of memory, this machine has {here:,.0f}"
    try:
        require_writable(results / study.name, f"{study.path}: study")
    except InputError as error:
        yield str(error)


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


def aligned(
    headings: Sequence[str], rows: Sequence[tuple[str, ...]], right: Container[str]
) -> list[str]:
    """Return a table as lines; the columns whose headings are in ``right`` end together."""
    columns = list(zip(headings, *rows, strict=True))
    widths = [max(map(len, column)) for column in columns]
    lines = []
    for row in (headings, *rows):
        cells = [
            cell.rjust(width) if heading in right else cell.ljust(width)
            for cell, width, heading in zip(row, widths, headings, strict=True)
        ]
        lines.append("  ".join(cells).rstrip())
    return lines


def _plots(study: Study) -> list[str]:
    """Return a line per plot of the study's own."""
    return [
        f"plot {name}: {spec.title} ({counted(len(study.figures[name]), 'point')})"
        for name, spec in study.plots.items()
    ]


def _caveats(study: Study) -> list[str]:
    """Return a line per caveat that is known before any run, with the first points it is of."""
    found: dict[str, list[str]] = {}
    for point in study.points.values():
        if point.parameters.caveat:
            found.setdefault(point.parameters.caveat, []).append(point.id)
    return [
        f"caveat for {len(ids):,} of {counted(len(study.points), 'point')}: {text} "
        f"({', '.join(ids[:MOST_NAMED])}"
        + (f" and {len(ids) - MOST_NAMED:,} more)" if len(ids) > MOST_NAMED else ")")
        for text, ids in found.items()
    ]


def _totals(costs: Sequence[Estimate]) -> str:
    steps = sum(cost.steps for cost in costs)
    total = sum(cost.core_seconds for cost in costs)
    longest = max(cost.core_seconds for cost in costs)
    return (
        f"{counted(len(costs), 'point')}, {steps:,} steps, estimated core time {duration(total)}, "
        f"on {CORES} cores {duration(max(total / CORES, longest))}; computing alone, without "
        "compilation, Snakemake and figures"
    )


def _adopted(adopted: Mapping[str, str], costs: Mapping[str, Estimate]) -> list[str]:
    """Return the line that says how many points are adopted, and what the others take."""
    if not adopted:
        return []
    left = sum(cost.core_seconds for key, cost in costs.items() if key not in adopted)
    names = ", ".join(sorted(set(adopted.values())))
    return [
        f"{counted(len(adopted), 'point')} adopted from {names}, not to be run; "
        f"core time of the others {duration(left)}"
    ]


def _trajectories(costs: Sequence[Estimate]) -> list[str]:
    """Return the line that says what trajectories take on the disk, where there are any."""
    sizes = [cost.trajectory for cost in costs if cost.trajectory]
    if not sizes:
        return []
    return [
        f"trajectories of {len(sizes):,} points: at most {sum(sizes):,.1f} MB on the disk, "
        f"{max(sizes):,.1f} MB of one point"
    ]


def _decisions(budget: float) -> str:
    return f"decisions ({program()} decide) may add up to {budget:g} core hours"


def _refinement(study: Study) -> str:
    """Say what rounds of refinement add where no run is undecided: one gap divided in each."""
    count, total = 0, 0.0
    for boundary in study.boundaries:
        first = [estimate(boundary.at(value)) for value in divided(boundary.low, boundary.high)]
        added = (PARTS - 1) * boundary.rounds
        count += added
        total += added * sum(cost.core_seconds for cost in first) / len(first)
    return (
        f"{study.rounds} rounds of refinement for {len(study.boundaries):,} boundaries: about "
        f"{count:,} further points, estimated core time {duration(total)}"
    )
