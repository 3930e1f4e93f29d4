"""The comparison of two runs or two studies, or of the engines that run the points of one."""

import json
import os
import subprocess
import sys
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import ceil, exp, log
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from scipy.stats import combine_pvalues

from sim.base.additions import plain_name
from sim.base.errors import InputError, align_table, count_text
from sim.base.messages import one_of
from sim.base.plugins import VARIABLE
from sim.base.statistics import CONFIDENCE, student
from sim.dataset.compare import Comparison, Mean, Pair, compare, mean_of, read_side
from sim.dataset.results import load_current
from sim.parameters import SYSTEMS, Parameters, canonical_values, point_id
from sim.parameters.laws import engine_of
from sim.parameters.words import setting
from sim.report.numbers import finite_or_none, template, value_with_interval
from sim.study.load import OWN, folder_of_results, load_study, other_engines, twins
from sim.study.model import Study

_HEADINGS = ("point", "A", "B", "B - A", "p", "")
_RIGHT = {"p"}


def show(
    first: Path,
    second: Path | None,
    quantity: str = "velocity",
    ignored: Sequence[str] = (),
    format: str = "text",
    **opinion: Any,
) -> str:
    """Return the comparison of two runs or two studies as ``text`` or ``json``.

    Without a second it is what another engine says of a study, see `ask`.

    Raises `InputError` when a file cannot be read or lacks the quantity, when an ignored parameter
    is unknown, or when they have no point in common.
    """
    if second is None:
        if format != "text":
            raise InputError.of_value("--format", "", format, "text, where another engine is asked")
        return "\n".join(ask(first, **opinion))
    parameters = {name for model in SYSTEMS.values() for name in model.model_fields}
    for name in ignored:
        if name not in parameters:
            raise InputError.of_value("--ignore", "", name, "a parameter of a system")
    (first_side, unit), (second_side, _) = (read_side(path, quantity) for path in (first, second))
    comparison = compare(first_side, second_side, ignored)
    if format == "json":
        return as_json(comparison, quantity, unit)
    heading = {"first": first, "second": second, "heading": f"{quantity} ({unit})"}
    return template("compare.txt.j2").render(**heading, **_contents(comparison)).strip()


def _contents(comparison: Comparison) -> dict[str, Any]:
    """Return what the text tells of a comparison: a row per pair of points, and counts."""
    usual_values = _distinguishing_parameters(comparison.pairs)
    rows: list[tuple[str, ...]] = []
    for pair, differs in zip(comparison.pairs, comparison.is_real, strict=True):
        words = [
            setting(pair.system, name, pair.key[name])
            for name, usual in usual_values.items()
            if name in pair.key and pair.key[name] != usual
        ]
        rows.append(
            (
                ", ".join(words) or pair.system,
                *(_mean_text(mean) for mean in (pair.first, pair.second, pair.difference)),
                f"{pair.chance:.2g}" if np.isfinite(pair.chance) else "not known",
                "differs" if differs else "",
            )
        )
    ratios = [pair.second.value / pair.first.value for pair in comparison.pairs if pair.first.value]
    return {
        "comparison": comparison,
        "table": align_table(_HEADINGS, rows, _RIGHT),
        "differing": sum(comparison.is_real),
        "unknown": sum(not np.isfinite(pair.chance) for pair in comparison.pairs),
        "ratios": np.quantile(ratios, (0.1, 0.5, 0.9)).tolist() if len(ratios) > 1 else [],
    }


def _distinguishing_parameters(pairs: Sequence[Pair]) -> dict[str, Any]:
    """Return the parameters that distinguish pairs, each with its most common value.

    Parameters that vary exactly like an earlier one are left out. The value is None unless more
    than half of the pairs have it; lines of pairs omit it.
    """
    usual_values: dict[str, Any] = {}
    patterns: set[tuple[int, ...]] = set()
    for name in dict.fromkeys(name for pair in pairs for name in pair.key):
        values = [pair.key.get(name) for pair in pairs]
        pattern = tuple(map(values.index, values))
        if len(set(pattern)) > 1 and pattern not in patterns:
            value, count = Counter(values).most_common(1)[0]
            usual_values[name] = value if 2 * count > len(values) else None
            patterns.add(pattern)
    return usual_values


def _mean_text(mean: Mean) -> str:
    error = f"± {mean.half_width:.2g}" if np.isfinite(mean.half_width) else "(error not known)"
    return f"{mean.value:.4g} {error}"


def as_json(comparison: Comparison, quantity: str, unit: str) -> str:
    """Return the comparison as JSON, with null for unknown numbers."""

    def entry(mean: Mean) -> Mapping[str, Any]:
        return {"value": mean.value, "half_width": finite_or_none(mean.half_width)}

    pairs = [
        {
            "system": pair.system,
            "parameters": dict(pair.key),
            "a": entry(pair.first),
            "b": entry(pair.second),
            "difference": entry(pair.difference),
            "p": finite_or_none(pair.chance),
            "differs": differs,
        }
        for pair, differs in zip(comparison.pairs, comparison.is_real, strict=True)
    ]
    document = {
        "quantity": quantity,
        "unit": unit,
        "different": {name: list(two) for name, two in comparison.differing_parameters.items()},
        "alone": list(comparison.unmatched_counts),
        "shorter": list(comparison.shorter_counts),
        "points": pairs,
    }
    return json.dumps(document, indent=1, ensure_ascii=False, allow_nan=False)


#: What is compared, and the numbers of a replicate that its interval takes.
QUANTITIES = ("velocity", "velocity_half_width", "independent_samples")


@dataclass(frozen=True)
class Opinion:
    """Points that two engines have run: their names; id in Talus -> mean velocities of both."""

    names: tuple[str, str]
    pairs: Mapping[str, Pair]

    @cached_property
    def ratios(self) -> dict[str, Mean]:
        """Ratio of the other's mean to ours, by id; the errors are those of small relative ones."""
        # No ratio says anything of a flow at rest.
        ratios = dict.fromkeys(self.pairs, Mean(np.nan, np.nan, np.nan))
        for key, pair in self.pairs.items():
            if pair.first.value and pair.second.value:
                ratio = pair.second.value / pair.first.value
                first, second = (one.error / one.value for one in (pair.first, pair.second))
                error = np.hypot(first, second)
                ratios[key] = Mean(ratio, abs(ratio) * float(error), pair.difference.freedom)
        return ratios

    @cached_property
    def pooled(self) -> Mean:
        """Geometric mean of all ratios, weighted by their errors."""
        ratios = [one for one in self.ratios.values() if one.half_width > 0 and one.value > 0]
        if not ratios:
            return Mean(np.nan, np.nan, np.nan)
        # Few degrees of freedom make an error too small as often as too large: intervals weigh.
        widths = np.array([one.half_width / one.value for one in ratios])
        weight = widths**-2.0
        mean = exp((weight * [log(one.value) for one in ratios]).sum() / weight.sum())
        freedom = sum(one.freedom for one in ratios)
        return Mean(mean, mean * weight.sum() ** -0.5 / float(student(freedom)), freedom)

    @cached_property
    def chance(self) -> float:
        """The p-value of all points together: Fisher's combination of Welch's tests."""
        chances = [one.chance for one in self.pairs.values() if np.isfinite(one.chance)]
        return float(combine_pvalues(chances, "fisher").pvalue) if chances else np.nan

    @property
    def sentence(self) -> str:
        """What all of them say, in one sentence."""
        if not np.isfinite(self.chance):
            return "No point has an interval in both engines: nothing can be said."
        ratio = value_with_interval(self.pooled.value, self.pooled.half_width)
        agrees = self.chance > 1 - CONFIDENCE
        verdict = "Nothing tells the engines apart" if agrees else "The engines differ"
        return (
            f"{verdict}: over {count_text(len(self.pairs), 'point')} the ratio of mean velocities, "
            f"{' over '.join(reversed(self.names))}, is {ratio} (p = {self.chance:.2g})."
        )

    @property
    def rows(self) -> list[tuple[str, ...]]:
        """Per point: its id, the means of both in m/s, their ratio and the p-value, as text."""
        return [
            (
                key,
                *(
                    _known(one.value, value_with_interval(one.value, one.half_width))
                    for one in (pair.first, pair.second, self.ratios[key])
                ),
                _known(pair.chance, f"{pair.chance:.2g}"),
            )
            for key, pair in self.pairs.items()
        ]


def _known(value: float, text: str) -> str:
    return text if np.isfinite(value) else "not known"


def opinions_of(study: Study, dataset: xr.Dataset, folder: Path) -> list[Opinion]:
    """Return the opinion of each other engine that has run points of a study."""
    every = (opinion_of(study, dataset, folder, other) for other in other_engines().values())
    return [opinion for opinion in every if opinion.pairs]


def opinion_of(study: Study, dataset: xr.Dataset, folder: Path, other: str) -> Opinion:
    """Return the means of both engines, from a study's dataset and the runs in its folder."""
    places = {str(key): place for place, key in enumerate(dataset["point"].values)}

    def mean(name: str) -> Mean | None:
        if name in places:
            row = dataset.isel(point=places[name])
            is_done = row["status"].values == "completed"
            columns = [row[one].values[is_done].astype(float) for one in QUANTITIES]
            return mean_of(*columns) if is_done.any() else None
        try:
            return read_side(folder / "runs" / f"{name}.nc", QUANTITIES[0])[0]["_mean"].iloc[0]
        except InputError:
            return None

    pairs = {}
    for key, twin in twins(study, other).items():
        is_own = getattr(twin, "engine", "") == OWN
        ours, theirs = (point_id(twin), key) if is_own else (key, point_id(twin))
        first, second = mean(ours), mean(theirs)
        if first and second:
            pairs[ours] = Pair(twin.system, {}, first, second)
    return Opinion((OWN, plain_name(other)), pairs)


def ask(study_path: Path, results: Path, share: float, cores: int, engine: str = "") -> list[str]:
    """Run a sample of a study's points by another engine; return what it says of them.

    The dataset of the study is in the folder of all results. The runs go to those of the study, as
    ordinary run files of points of the other engine; those that are there already are kept. They
    are a ``share`` of the points that both engines know, as many at a time as there are ``cores``.
    ``engine`` is the name of the other engine; empty where there is but one.

    Raises `InputError` when there is no such engine, or several and none is named; when no point is
    known to both, the dataset is missing, or a package is; when a point did not run, after what the
    others say is printed.
    """
    if not 0 < share <= 1:
        raise InputError.of_value("--share", "", share, "a number > 0 and <= 1")
    if cores < 1:
        raise InputError.of_value("--cores", "", cores, "an integer >= 1")
    study = load_study(study_path, results)
    folder = folder_of_results(study, results) / study.name
    # The study has loaded its plug-ins.
    others = other_engines()
    if not engine and len(others) == 1:
        (engine,) = others
    if engine not in others:
        raise InputError.of_value("--engine", "", engine or None, one_of(engine, others))
    other = others[str(engine)]
    dataset = load_current(study, folder).dataset
    candidates = {
        key: twin for key, twin in twins(study, other).items() if point_id(twin) not in study.points
    }
    if not candidates and not opinion_of(study, dataset, folder, other).pairs:
        reason = "knows none of its points, as of their laws: docs/second_engine.md"
        raise InputError(f"{study_path}: {engine} {reason}")
    # The same sample each time, so that another call goes on.
    keys = np.random.default_rng(0).permutation(sorted(candidates))
    chosen = [candidates[str(key)] for key in keys[: ceil(share * len(candidates))]]
    for twin in chosen:
        engine_of(twin)
    failed = _run(chosen, study, folder, cores)
    opinion = opinion_of(study, dataset, folder, other)
    headings = ("point", *(f"{one} (m/s)" for one in opinion.names), "ratio", "p")
    lines = align_table(headings, opinion.rows, {"p"})
    lines += ["", opinion.sentence]
    if failed:
        print("\n".join(lines))
        raise InputError(f"{study_path}: some points did not run: see {folder / 'logs' / 'runs'}")
    return lines


def _run(points: list[Parameters], study: Study, folder: Path, cores: int) -> bool:
    """Run points as the jobs of the workflow do; return whether one could not be run."""
    program = str(Path(__file__).parents[1] / "__main__.py")
    command = [sys.executable, program, "job", "batch", str(folder)]
    plugins = {VARIABLE: os.pathsep.join(plugin.pinned_name for plugin in study.plugins)}
    environment = os.environ | (plugins if study.plugins else {})
    parts = [points[number::cores] for number in range(cores)]
    jobs = []
    for part in filter(None, parts):
        job = subprocess.Popen(command, stdin=subprocess.PIPE, text=True, env=environment)
        if job.stdin:
            job.stdin.write(json.dumps([canonical_values(one) for one in part]))
            job.stdin.close()
        jobs.append(job)
    return any([job.wait() for job in jobs])
