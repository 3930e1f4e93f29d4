"""A made-up study of belt and chute: profiles and particles of all points follow known formulas."""

from pathlib import Path

import numpy as np
import xarray as xr

from sim.dataset.build import build
from sim.parameters import BeltParameters, ChuteParameters, Parameters
from sim.study.figure_spec import FIGURES
from sim.study.load import load_study
from tests.made.netcdf import store
from tests.made.once import once
from tests.made.runs import write_run

STUDY = """\
study: made
title: A made-up study of belt and chute
defaults:
  belt: {beads: 12, width: 5, replicates: 3}
  chute: {cell: 3, replicates: 3}
series:
  - name: frequencies
    system: belt
    grid: {frequency: [10, 15, 20, 60, 80]}
    figures: [gallas_2a, gallas_3a, gallas_4a, gallas_4d]
  - name: longer
    system: belt
    base: {protocol: converged}
    grid: {frequency: [10, 80]}
    figures: [gallas_2a, gallas_4d]
  - name: dampings
    system: belt
    base: {frequency: 80}
    cases:
      - {damping: 10, shear_damping: 10}
      - {damping: 0, shear_damping: 50}
      - {damping: 50, shear_damping: 100}
      - {damping: 10, shear_damping: 10, initial_velocity: 4}
      - {damping: 10, shear_damping: 10, initial_velocity: 4.5, protocol: converged}
    figures: [gallas_3c]
  - name: snapshots
    system: belt
    base: {frequency: 10, vibration_angle: 60}
    cases: [{}, {protocol: converged, steps_per_cycle: 5000}]
    figures: [gallas_5a]
  - name: obstacles
    system: belt
    grid: {obstacle: [0, 0.5, 1.5], frequency: [20, 80]}
    figures: [gallas_6, gallas_7a]
  - name: shear
    system: belt
    grid: {shear_damping: [0, 10, 50], frequency: [20, 50], protocol: [published, converged]}
    figures: [protocols_1c]
  - name: onsets
    system: belt
    grid: {amplitude: [0.5, 1], frequency: [15, 20, 80]}
    figures: [onset_acceleration]
  - name: rows
    system: chute
    grid: {depth: [1.24, 2.5, 5, 10, 20, 40]}
    figures:
      [walton_1_1, walton_1_2, walton_1_3, walton_1_4, walton_1_5, overlaps,
       animation_rolling, animation_sheared, animation_plug]
  - name: longer_rows
    system: chute
    base: {protocol: converged}
    grid: {depth: [5, 10]}
    figures: [walton_1_3]
  - name: stiff
    system: chute
    grid: {stiffness: [1000], depth: [5, 10]}
    figures: [overlaps]
  - name: stiff_row
    system: chute
    grid: {stiffness: [1000], depth: [40]}
    figures: [walton_1_6]
  - name: frictions
    system: chute
    grid: {friction: [0.2, 0.65, 0.8]}
    figures: [animation_accelerating, animation_arrested]
  - name: animations
    system: belt
    cases: [{frequency: 10}, {frequency: 20}, {frequency: 80}, {frequency: 80, obstacle: 1.5}]
    figures: [animation_block, animation_onset, animation_stream, animation_obstacle]
"""

#: Differences of the replicates, relative to the mean of the three.
SPREAD = np.array([-0.1, 0.0, 0.1])

#: Slices of the belt, and states of a path.
_SLICES, _STATES = 30, 41


def plateau(parameters: BeltParameters) -> float:
    """Return the number density (1/⟨d⟩²) of the made-up bed, which ends at 10 over it (⟨d⟩)."""
    return 1.0 / (1.0 + 0.01 * parameters.frequency)


def transport(parameters: BeltParameters) -> float:
    """Return the made-up velocity of the bed (m/s), zero at γ_s = 0."""
    return 1e-3 * parameters.frequency * min(parameters.shear_damping, 50) / 50


def speed(parameters: ChuteParameters) -> float:
    """Return the made-up velocity of a flow, m/s."""
    return 0.1 if parameters.friction < 0.7 else 0.01


def overlap(parameters: dict[str, float]) -> float:
    """Return the median overlap that is made up, σ; one of a thousand contacts has ten times it."""
    return 1e-4 * parameters["depth"] * 100 / parameters["stiffness"]


def belt_profiles(parameters: BeltParameters) -> dict[str, tuple]:
    """Return densities and velocities of the replicates over slices of ⟨d⟩."""
    height = (np.arange(_SLICES) + 0.5) * parameters.diameter
    filled = height < 10 / plateau(parameters) * parameters.diameter
    density = plateau(parameters) / parameters.diameter**2 * filled
    velocity = np.where(filled, transport(parameters), np.nan)
    return _profiles(height, {"number_density": density, "velocity_profile": velocity})


def chute_profiles(parameters: ChuteParameters) -> dict[str, tuple]:
    """Return a bed of packing 0.5 whose velocity rises in proportion to the height.

    The last sample's profiles are 1.5 times the mean ones.
    """
    slices = np.arange(int(8 * parameters.depth) + 8) + 0.5
    height = slices * parameters.slice_height * parameters.diameter
    filled = height < np.pi / 3 * parameters.depth * parameters.diameter
    velocity = np.where(filled, speed(parameters) * height / 1e-3, np.nan)
    means = {"packing_profile": 0.5 * filled, "velocity_profile": velocity}
    latest = {f"{name}_instantaneous": 1.5 * mean for name, mean in means.items()}
    return _profiles(height, means | latest)


def _profiles(height: np.ndarray, means: dict[str, np.ndarray]) -> dict[str, tuple]:
    dims = ("replicate", "height")
    profiles = {name: (dims, np.outer(1 + SPREAD, mean)) for name, mean in means.items()}
    return {"height": ("height", height, {"units": "m"})} | profiles


def _particles(parameters: Parameters) -> dict[str, tuple]:
    """Return particles of a path that is the same in all replicates.

    Spheres in a lattice all move on at the same velocity. Beads in a row go up and down once, and
    by one cell along the belt, in a cycle; the circle of the last one crosses the end of the cell.
    """
    count, size, phase = parameters.particles, parameters.diameter, np.linspace(0, 1, _STATES)
    if isinstance(parameters, BeltParameters):
        width, time = parameters.width, phase / parameters.frequency
        start = np.stack([np.linspace(0.3, width - 0.1, count), np.full(count, 2.0)], axis=1)
        shift = np.stack([width * phase, np.sin(2 * np.pi * phase)], axis=1)
        velocity = np.array([1, -0.5]) * transport(parameters)
        sizes = size * np.linspace(0.5, 1.5, count)
    else:
        time, lengths = 4 * parameters.time_unit * phase, [parameters.cell, parameters.cell, 2]
        start = 0.5 + (np.arange(count)[:, None] * np.sqrt([2, 3, 5])) % lengths
        velocity, sizes = np.array([speed(parameters), 0, 0]), np.full(count, size)
        shift = np.outer(time, velocity / size)
    path = size * (start + shift[:, None, :])
    frames = ("replicate", "frame", "particle", "axis")

    def alike(values: np.ndarray) -> np.ndarray:
        return np.stack([values] * len(SPREAD))

    return {
        "path": (("replicate", "path_time", "particle", "axis"), alike(path)),
        "path_time": ("path_time", time, {"units": "s"}),
        "position": (frames, alike(path[[0, -1]])),
        "particle_velocity": (frames, alike(np.broadcast_to(velocity, (2, *start.shape)))),
        "radius": (("replicate", "particle"), alike(sizes / 2)),
    }


@once
def make_dataset(folder: Path) -> tuple[Path, Path]:
    """Write the study, all its run files and the dataset; return the study file and that."""
    study_path, results = folder / "made.yaml", folder / "results"
    study_path.write_text(STUDY)
    study = load_study(study_path, results)
    for point in study.points.values():
        parameters = point.parameters
        if isinstance(parameters, BeltParameters):
            arrays, velocity = belt_profiles(parameters), transport(parameters) * (1 + SPREAD)
            velocity = velocity / (1 + parameters.obstacle)
        else:
            arrays, velocity = chute_profiles(parameters), speed(parameters)
        if any(FIGURES[name].keys.particles for name in point.figures):
            arrays |= _particles(parameters)
        write_run(results / study.name / "runs", parameters, velocity, arrays=arrays)
    path = build(study_path, results)
    with xr.open_dataset(path) as opened:
        dataset = opened.load()
    median = overlap({name: dataset[name].values for name in ("depth", "stiffness")})
    for name, values in (("median_overlap", median), ("overlap_999", 10 * median)):
        dataset[name] = (("point", "replicate"), np.outer(values, 1 + SPREAD))
    store(dataset, path, mode="a")
    return study_path, path
