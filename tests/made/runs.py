"""Synthetic run files: small ones as the engine writes them, with known answers."""

from collections.abc import Mapping, Sequence
from math import nan, radians
from pathlib import Path
from typing import Any

import netCDF4
import numpy as np

from sim.base.seals import append_summary, seal
from sim.dataset.boundaries import added_points
from sim.engine.identity import NUMERICS
from sim.parameters import Parameters, amounts, canonical_values, point_id
from sim.parameters.variables import SCALARS
from sim.study.load import load_study
from tests.made.once import once

SAMPLES = 400
HEIGHTS = 8
FAILURE = "overlap of 0.31 diameters at step 1200"


def write_run(
    folder: Path,
    parameters: Parameters,
    velocity: float | Sequence[float] = 0.5,
    *,
    regime: str = "steady",
    failed: Sequence[int] = (),
    numerics: int = NUMERICS,
    caveat: str = "",
    arrays: Mapping[str, Any] | None = None,
) -> Path:
    """Write ``<folder>/<point id>.nc`` by the contract of a run file; return its path.

    ``velocity`` (m/s) is that of all or of each replicate, ``regime`` that of those that completed;
    ``failed`` ones blew up, and all of them make the run a failed one. ``arrays`` are further
    variables, or replacements of those made up here.
    """
    count = parameters.replicates
    velocities = np.broadcast_to(np.asarray(velocity, dtype=float), count).copy()
    velocities[list(failed)] = nan
    data = _series(parameters, velocities)
    data |= _scalars(parameters, velocities, regime, failed)
    data |= _parameters(parameters) | dict(arrays or {})
    attributes = _attributes(parameters, failed, numerics) | {"caveat": caveat}
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"{point_id(parameters)}.nc"
    _write(path, data, attributes)
    scalars = {name: np.asarray(data[name][1]).tolist() for name in SCALARS if name in data}
    summary = {"attributes": attributes, "held": [amounts(parameters)], "scalars": scalars}
    append_summary(path, summary)
    seal(path)
    return path


def _write(path: Path, data: Mapping[str, Any], attributes: Mapping[str, Any]) -> None:
    """Write variables, each given by its dimensions, values and attributes.

    xarray would take three times as long, and tests write thousands of files.
    """
    filled = []
    with netCDF4.Dataset(path, "w") as file:
        file.setncatts(attributes)
        for name, (dimensions, given, *attrs) in data.items():
            values = np.asarray(given)
            along = (dimensions,) if isinstance(dimensions, str) else tuple(dimensions)
            for dimension, size in zip(along, values.shape, strict=True):
                if dimension not in file.dimensions:
                    file.createDimension(dimension, size)
            kind = str if values.dtype.kind in "OU" else values.dtype
            fill = np.nan if values.dtype.kind == "f" else None
            variable = file.createVariable(name, kind, along, fill_value=fill)
            variable.setncatts(attrs[0] if attrs else {})
            filled.append((variable, values))
        # The library defines a variable more slowly after values than before them.
        for variable, values in filled:
            variable[...] = values


def _series(parameters: Parameters, velocities: np.ndarray) -> dict[str, Any]:
    """Return a time series that swings about its mean, and a profile."""
    span = (parameters.transient + parameters.average) * parameters.time_unit
    time = np.linspace(span / SAMPLES, span, SAMPLES)
    swing = 0.02 * parameters.velocity_unit * np.sin(2 * np.pi * time / span * 23)
    profile = np.outer(velocities, np.linspace(0.5, 1.5, HEIGHTS))
    return {
        "time": ("time", time, {"units": "s"}),
        "height": ("height", (np.arange(HEIGHTS) + 0.5) * 1e-3, {"units": "m"}),
        "mean_velocity": (("replicate", "time"), velocities[:, None] + swing, {"units": "m s-1"}),
        "velocity_profile": (("replicate", "height"), profile, {"units": "m s-1"}),
    }


def _scalars(
    parameters: Parameters, velocities: np.ndarray, regime: str, failed: Sequence[int]
) -> dict[str, Any]:
    count = len(velocities)
    lost = np.isin(np.arange(count), failed)
    # A regime is undetermined where the trend is uncertain.
    unsure = 1.0 if regime == "undetermined" else 1e-7
    known = {
        "velocity": velocities,
        "velocity_error": 0.0004,
        "velocity_half_width": 0.0009,
        "acceleration": 2.0 if regime == "accelerating" else 1e-8,
        "acceleration_error": unsure / 2,
        "acceleration_half_width": unsure,
        "average_start": 0.25,
        "independent_samples": 40.0,
        "energy_residual": 1e-4,
        "time_step_used": parameters.time_step,
    }
    if parameters.system == "chute":
        known |= {"base_normal": 1.0, "base_shear": 0.3}
    values = {name: np.where(lost, nan, value) for name, value in known.items()} | {
        "max_overlap": np.where(lost, 0.31, 0.01 + 1e-9 * np.arange(count)),
        "steps": np.where(lost, 1200, parameters.steps),
        "wall_time": np.full(count, 1.5),
        "replicate_seed": parameters.seed + np.arange(count),
        "regime": np.where(lost, "undetermined", regime).astype(object),
        "quality": np.where(lost, "failed", "reliable").astype(object),
        "stopped": np.where(lost, "failure", "length").astype(object),
        "status": np.where(lost, "failed", "completed").astype(object),
        "reason": np.where(lost, FAILURE, "").astype(object),
    }
    return {
        name: ("replicate", array, {"units": SCALARS[name].unit} if SCALARS[name].unit else {})
        for name, array in values.items()
    }


def _parameters(parameters: Parameters) -> dict[str, Any]:
    values = canonical_values(parameters) | {"particles": parameters.particles}
    return {
        name: ((), int(value) if isinstance(value, bool) else value)
        for name, value in values.items()
    }


def _attributes(parameters: Parameters, failed: Sequence[int], numerics: int) -> dict[str, Any]:
    broken = len(failed) == parameters.replicates
    return {
        "Conventions": "CF-1.11",
        "title": f"{parameters.system} run",
        "system": parameters.system,
        "point_id": point_id(parameters),
        "engine_version": "0.1.0",
        "numerics": numerics,
        "source_hash": "0123456789ab",
        "created": "2026-01-01T00:00:00Z",
        "versions": '{"python": "3.11.7", "numpy": "2.4.6"}',
        "status": "failed" if broken else "completed",
        "reason": FAILURE if broken else "",
        "steps": parameters.steps * parameters.replicates,
        "wall_time": 1.5 * parameters.replicates,
        "command": "python -m sim run -",
    }


STUDY = """\
study: made
title: A made-up study
defaults:
  chute: {replicates: 2}
  belt: {replicates: 3}
series:
  - name: depths
    system: chute
    grid: {depth: [0.5, 2.5, 5, 10], restitution: [0.7, 0.85]}
    figures: [walton_2]
  - name: rough
    system: chute
    grid: {depth: [2.5, 5], friction: [0.4, 0.5]}
    figures: [walton_2]
  - name: angles
    system: belt
    grid: {frequency: [10, 20, 50, 80], vibration_angle: [30, 45, 60]}
    figures: [gallas_1a]
  - name: amplitudes
    system: belt
    grid: {frequency: [10, 20, 50], amplitude: [0.5, 1, 1.5]}
    figures: [gallas_1b]
  - name: dampings
    system: belt
    base: {frequency: 50}
    cases:
      - {damping: 0, shear_damping: 50}
      - {damping: 10, shear_damping: 10}
      - {damping: 50, shear_damping: 100}
    figures: [gallas_1b]
  - name: shear
    system: belt
    base: {replicates: 1}
    grid: {shear_damping: [0, 10, 50], frequency: [20, 50]}
    figures: [gallas_1c]
"""


def made_velocity(parameters: Parameters) -> tuple[float, str]:
    """Return the velocity (m/s) and the regime that the made-up study gives a point."""
    if parameters.system == "chute":
        if parameters.depth < 1:
            return 4.0, "accelerating"
        return 0.3 + 0.1 * parameters.depth * (1 - parameters.restitution), "steady"
    if parameters.frequency < 16:
        return 0.0, "arrested"
    return 1e-3 * parameters.frequency * parameters.amplitude, "steady"


def is_lost(parameters: Parameters) -> bool:
    """True where all replicates of a point fail in the made-up study."""
    return parameters.system == "chute" and (parameters.depth, parameters.restitution) == (10, 0.7)


def is_hurt(parameters: Parameters) -> bool:
    """True where the first replicate of a point fails in the made-up study."""
    return parameters.system == "chute" and (parameters.depth, parameters.restitution) == (5, 0.7)


@once
def make_study(folder: Path) -> tuple[Path, Path]:
    """Write the made-up study and all its run files; return the study file and results folder."""
    study_path, results = folder / "made.yaml", folder / "results"
    study_path.write_text(STUDY)
    study = load_study(study_path, results)
    for point in study.points.values():
        mean, regime = made_velocity(point.parameters)
        count = point.parameters.replicates
        failed = range(count) if is_lost(point.parameters) else [0] * is_hurt(point.parameters)
        spread = 0.01 * np.arange(count) - 0.005 * (count - 1)
        runs = results / study.name / "runs"
        write_run(runs, point.parameters, mean + spread, regime=regime, failed=list(failed))
    return study_path, results


REGIMES = """\
study: regimes
title: Made-up regimes
boundaries:
  - {name: acceleration-friction, system: chute, of: acceleration, along: friction, tolerance: 0.05,
     range: [0.2, 0.6], grid: {depth: [5, 10]}, figures: [regimes_friction]}
  - {name: flow-friction, system: chute, of: flow, along: friction, tolerance: 0.05,
     range: [0.2, 1], grid: {depth: [5, 10]}, figures: [regimes_friction]}
  - {name: acceleration-depth, system: chute, of: acceleration, along: depth, tolerance: 0.2,
     range: [0.5, 2.5], base: {friction: 0.4}, figures: [regimes_friction]}
  - {name: acceleration-angle, system: chute, of: acceleration, along: angle, tolerance: 1,
     range: [12, 28], grid: {depth: [5, 20]}, figures: [regimes_angle]}
  - {name: flow-angle, system: chute, of: flow, along: angle, tolerance: 1,
     range: [12, 28], grid: {depth: [5, 20]}, figures: [regimes_angle]}
  - {name: onset, system: belt, of: transport, along: frequency, tolerance: 0.25,
     range: [11, 27], grid: {amplitude: [0.5, 1]}, figures: [belt_onset]}
"""


def made_regime(parameters: Parameters) -> tuple[float, str]:
    """Return the velocity (m/s) and the regime that the made-up regimes give a point.

    Accelerating above tan θ = μ and below depth 1, arrested below tan θ = μ/2 + depth/100,
    undecided about μ = 0.6 at depth 10; the belt transports beyond Γ = 1.
    """
    if parameters.system == "belt":
        acceleration = (2 * np.pi * parameters.frequency) ** 2 * 1e-3 * parameters.amplitude
        return (0.05, "steady") if acceleration > parameters.gravity else (0.0, "arrested")
    slope = np.tan(radians(parameters.angle))
    if parameters.depth == 10 and 0.55 < parameters.friction < 0.65:
        return 0.1, "undetermined"
    if slope > parameters.friction or parameters.depth < 1:
        return 4.0, "accelerating"
    if slope < parameters.friction / 2 + parameters.depth / 100:
        return 0.0, "arrested"
    return 0.5, "steady"


@once
def make_regimes(folder: Path) -> tuple[Path, Path]:
    """Write the made-up regimes and the run files of all rounds; return study file and results."""
    study_path, results = folder / "regimes.yaml", folder / "results"
    study_path.write_text(REGIMES)
    study = load_study(study_path, results)
    runs = results / study.name / "runs"
    points = [point.parameters for point in study.points.values()]
    for number in range(study.rounds + 1):
        if number:
            points = added_points(study, number, runs).values()
        for parameters in points:
            velocity, regime = made_regime(parameters)
            write_run(runs, parameters, velocity, regime=regime)
    return study_path, results
