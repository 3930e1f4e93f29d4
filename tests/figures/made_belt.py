"""A made-up study of the belt: profiles and particles of every point follow a known formula."""

from pathlib import Path

import numpy as np

from sim.dataset.build import build
from sim.parameters import BeltParameters
from sim.study.figure_spec import FIGURES
from sim.study.load import load_study
from tests.made.once import once
from tests.made.runs import SAMPLES, write_run

STUDY = """\
study: made-belt
title: A made-up study of the belt
defaults:
  belt: {beads: 12, width: 5, replicates: 3}
series:
  - name: frequencies
    system: belt
    grid: {frequency: [10, 15, 20, 60, 80]}
    figures: [gallas_2a, gallas_3a, gallas_4a, gallas_4c, gallas_4d]
  - name: longer
    system: belt
    base: {protocol: converged}
    grid: {frequency: [10, 80]}
    figures: [gallas_2a, gallas_4d]
  - name: angles
    system: belt
    base: {frequency: 60}
    grid: {vibration_angle: [30, 45, 60, 90]}
    figures: [gallas_2b, gallas_3b]
  - name: dampings
    system: belt
    base: {frequency: 80}
    cases:
      - {damping: 10, shear_damping: 10}
      - {damping: 0, shear_damping: 50}
      - {damping: 50, shear_damping: 100}
    figures: [gallas_2c, gallas_3c]
  - name: starts
    system: belt
    base: {frequency: 80, damping: 10, shear_damping: 10}
    cases: [{initial_velocity: 4}, {initial_velocity: 4.5, protocol: converged}]
    figures: [gallas_2c, gallas_3c]
  - name: frictionless
    system: belt
    cases: [{frequency: 10, shear_damping: 1}, {frequency: 80, shear_damping: 0}]
    figures: [gallas_4b, gallas_4e]
  - name: finer
    system: belt
    base: {protocol: converged, steps_per_cycle: 5000}
    cases: [{frequency: 10, vibration_angle: 60}]
    figures: [gallas_5a]
  - name: snapshots
    system: belt
    cases:
      - {frequency: 10, vibration_angle: 60}
      - {frequency: 40, vibration_angle: 30, damping: 10, shear_damping: 10}
      - {frequency: 100}
      - {frequency: 100, damping: 1}
    figures: [gallas_5a, gallas_5b, gallas_5c, gallas_5d]
  - name: obstacles
    system: belt
    grid: {obstacle: [0, 0.5, 1.5], frequency: [20, 80]}
    figures: [gallas_6, gallas_7a, gallas_7b, gallas_7c]
  - name: shear
    system: belt
    grid: {shear_damping: [0, 10, 50], frequency: [20, 50], protocol: [published, converged]}
    figures: [protocols_1c]
  - name: onsets
    system: belt
    grid: {amplitude: [0.5, 1], frequency: [15, 20, 80]}
    figures: [onset_acceleration, belt_void, density_waves]
  - name: stiffness
    system: belt
    grid: {stiffness: [500, 1000, 2000], frequency: [20, 80]}
    figures: [belt_stiffness]
"""

SLICES = 30

#: Differences of the replicates, relative to the mean of the three.
SPREAD = np.array([-0.1, 0.0, 0.1])


def plateau(parameters: BeltParameters) -> float:
    """Return the number density (1/⟨d⟩²) of the made-up bed, which ends at 10 over it (⟨d⟩)."""
    return 1.0 / (1.0 + 0.01 * parameters.frequency)


def transport(parameters: BeltParameters) -> float:
    """Return the made-up velocity (m/s), zero at γ_s = 0."""
    return 1e-3 * parameters.frequency * min(parameters.shear_damping, 50) / 50


def made_profiles(parameters: BeltParameters) -> dict[str, tuple]:
    """Return densities and velocities of the replicates over slices of ⟨d⟩."""
    height = (np.arange(SLICES) + 0.5) * parameters.diameter
    filled = height < 10 / plateau(parameters) * parameters.diameter
    density = plateau(parameters) / parameters.diameter**2
    velocity = np.where(filled, transport(parameters), np.nan)
    dims = ("replicate", "height")
    return {
        "height": ("height", height, {"units": "m"}),
        "number_density": (dims, np.outer(1 + SPREAD, density * filled)),
        "velocity_profile": (dims, np.outer(1 + SPREAD, velocity)),
    }


def made_series(parameters: BeltParameters) -> dict[str, tuple]:
    """Return a share of the beads near the belt, and waves twice as strong in the first 10 cycles.

    Both are 1/f of the frequency f in Hz, in any phase of the belt.
    """
    cycles = np.linspace(0, parameters.transient + parameters.average, SAMPLES + 1)[1:]
    power = np.where(cycles <= 10, 2, 1) / parameters.frequency
    dims = ("replicate", "time")
    return {
        "base_occupancy": (dims, np.outer(1 + SPREAD, np.full(SAMPLES, 1 / parameters.frequency))),
        "wave_power": (dims, np.outer(1 + SPREAD, power)),
        "belt_phase": (dims, np.tile(2 * np.pi * (cycles % 1), (SPREAD.size, 1))),
    }


def made_particles(parameters: BeltParameters) -> dict[str, tuple]:
    """Return beads in a row that go up and down once, and by one cell along the belt, in a cycle.

    The last bead begins at the end of the cell, and its circle crosses it.
    """
    beads, diameter = parameters.beads, parameters.diameter
    start = np.stack([np.linspace(0.3, parameters.width - 0.1, beads), np.full(beads, 2.0)], axis=1)
    phase = np.linspace(0, 1, 41)
    shift = np.stack([parameters.width * phase, np.sin(2 * np.pi * phase)], axis=1)
    path = diameter * (start + shift[:, None, :])
    speed = transport(parameters)
    frames = np.stack([path[0], path[-1]])

    def alike(values: np.ndarray) -> np.ndarray:
        return np.stack([values] * parameters.replicates)

    return {
        "path": (("replicate", "path_time", "particle", "axis"), alike(path)),
        "path_time": ("path_time", phase / parameters.frequency, {"units": "s"}),
        "position": (("replicate", "frame", "particle", "axis"), alike(frames)),
        "particle_velocity": (
            ("replicate", "frame", "particle", "axis"),
            alike(np.broadcast_to([speed, -0.5 * speed], frames.shape)),
        ),
        "radius": (("replicate", "particle"), alike(diameter / 2 * np.linspace(0.5, 1.5, beads))),
    }


@once
def make_dataset(folder: Path) -> tuple[Path, Path]:
    """Write the study, all its run files and the dataset; return the study file and that."""
    study_path, results = folder / "made.yaml", folder / "results"
    study_path.write_text(STUDY)
    study = load_study(study_path, results)
    for point in study.points.values():
        parameters = point.parameters
        velocity = transport(parameters) / (1 + parameters.obstacle) * (1 + SPREAD)
        arrays = made_profiles(parameters) | made_series(parameters)
        if any(FIGURES[name].keys.particles for name in point.figures):
            arrays |= made_particles(parameters)
        write_run(results / study.name / "runs", parameters, velocity, arrays=arrays)
    return study_path, build(study_path, results)
