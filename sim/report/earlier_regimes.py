"""How runs of a length ended before: the regimes of points in the results at hand."""

from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from statistics import median

from sim.base.errors import count_text
from sim.parameters import Parameters
from sim.study.model import Study

#: Lengths are similar up to this factor.
SIMILAR = 2.0

#: A point of a dataset: its system, its length in the time unit of the system, and its regime.
Earlier = tuple[str, float, str]


def lines(study: Study, results: Path) -> list[str]:
    """Return a line for each series that is asked a question: regimes of runs of its lengths.

    Runs of a length are those of the system with at most twice and at least half of it. There is
    no line where the results have none.
    """
    series = dict.fromkeys(spec.of.series for spec in study.questions)
    earlier = list(_earlier_points(results)) if series else []
    return [line for name in series if (line := _line(study, name, earlier))]


def _line(study: Study, series: str, earlier: list[Earlier]) -> str:
    points = [study.points[key].parameters for key in study.series[series]]
    length = median(map(_length, points))
    regimes = Counter(
        regime
        for system, other, regime in earlier
        if system == points[0].system and length / SIMILAR <= other <= length * SIMILAR
    )
    if not regimes:
        return ""
    names = ["steady", *(name for name, _ in regimes.most_common() if name != "steady")]
    return (
        f"series {series}: of {count_text(regimes.total(), 'point')} with runs of such a length in "
        f"the results here, {', '.join(f'{regimes[name]:,} {name}' for name in names)}"
    )


def _length(point: Parameters) -> float:
    return point.transient + point.average


def _earlier_points(results: Path) -> Iterator[Earlier]:
    """Yield the points of all datasets in a folder of results; damaged ones have none."""
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
