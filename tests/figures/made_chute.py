"""A made-up study of the chute: profiles and particles of every point follow a known formula."""

from pathlib import Path

import numpy as np
import xarray as xr

from sim.dataset.build import build
from sim.parameters import BeltParameters, ChuteParameters, Parameters
from sim.study.load import load_study
from tests.made.netcdf import store
from tests.made.once import once
from tests.made.runs import write_run

STUDY = """\
study: made-chute
title: A made-up study of the chute
defaults:
  chute: {cell: 3, replicates: 3}
  belt: {beads: 12, width: 5, replicates: 1}
series:
  - name: rows
    system: chute
    grid: {depth: [1.24, 2.5, 5, 10, 20, 40]}
    figures:
      [walton_1_1, walton_1_2, walton_1_3, walton_1_4, walton_1_5, walton_1_6, shear_depth,
       overlaps, animation_rolling, animation_sheared, animation_plug]
  - name: longer
    system: chute
    base: {protocol: converged, replicates: 2}
    grid: {depth: [5, 10]}
    figures: [walton_1_3]
  - name: single
    system: chute
    base: {replicates: 1}
    grid: {restitution: [0.7], depth: [5, 10]}
    figures: [shear_depth]
  - name: stiff
    system: chute
    grid: {stiffness: [1000], depth: [5, 10]}
    figures: [shear_depth, overlaps]
  - name: frictions
    system: chute
    grid: {friction: [0.2, 0.65, 0.8]}
    figures: [animation_accelerating, animation_arrested]
  - name: belt
    system: belt
    cases: [{frequency: 10}, {frequency: 20}, {frequency: 80}, {frequency: 80, obstacle: 1.5}]
    figures: [animation_block, animation_onset, animation_stream, animation_obstacle]
"""

#: Differences of three replicates, relative to their mean.
SPREAD = np.array([-0.1, 0.1, 0.0])

STEPS = 41


def speed(parameters: Parameters) -> float:
    """Return the mean velocity that is made up, m/s."""
    if parameters.system == "belt":
        return 1e-3 * parameters.frequency
    return 0.1 if parameters.friction < 0.7 else 0.01


def shear_depth(depth: float) -> float:
    """Return the height of the shearing layer that is made up, m, for spheres of 1 mm."""
    return 1e-2 / depth


def overlap(parameters: dict[str, float]) -> float:
    """Return the median overlap that is made up, σ; one of a thousand contacts has ten times it."""
    return 1e-4 * parameters["depth"] * 100 / parameters["stiffness"]


def made_profiles(parameters: ChuteParameters) -> dict[str, tuple]:
    """Return a bed of packing 0.5 whose velocity rises in proportion to the height.

    The replicates differ by `SPREAD`; the last sample's profiles are 1.5 times the mean ones.
    """
    spread = 1 + SPREAD[: parameters.replicates]
    slices = int(8 * parameters.depth) + 8
    height = (np.arange(slices) + 0.5) * parameters.slice_height * parameters.diameter
    filled = height < np.pi / 3 * parameters.depth * parameters.diameter
    packing = np.outer(spread, 0.5 * filled)
    velocity = np.outer(spread, np.where(filled, speed(parameters) * height / 1e-3, np.nan))
    dims = ("replicate", "height")
    return {
        "height": ("height", height, {"units": "m"}),
        "packing_profile": (dims, packing),
        "packing_profile_instantaneous": (dims, 1.5 * packing),
        "velocity_profile": (dims, velocity),
        "velocity_profile_instantaneous": (dims, 1.5 * velocity),
    }


def made_particles(parameters: Parameters) -> dict[str, tuple]:
    """Return particles in a lattice from corner to corner that all move on at the same velocity."""
    count, size = parameters.particles, parameters.diameter
    side = parameters.cell if parameters.system == "chute" else parameters.width
    lengths = [side, side, 2] if parameters.system == "chute" else [side, 2]
    numbers = np.arange(count)[:, None]
    start = size * (0.5 + (numbers * np.sqrt([2, 3, 5][: len(lengths)])) % lengths)
    whole = 4 * parameters.time_unit if parameters.system == "chute" else 1 / parameters.frequency
    time = np.linspace(0, whole, STEPS)
    path = np.repeat(start[None], STEPS, axis=0)
    path[..., 0] += speed(parameters) * time[:, None]
    velocity = np.zeros((2, *start.shape))
    velocity[..., 0] = speed(parameters)

    def alike(values: np.ndarray) -> np.ndarray:
        return np.stack([values] * parameters.replicates)

    return {
        "path": (("replicate", "path_time", "particle", "axis"), alike(path)),
        "path_time": ("path_time", time, {"units": "s"}),
        "position": (("replicate", "frame", "particle", "axis"), alike(path[[0, -1]])),
        "particle_velocity": (("replicate", "frame", "particle", "axis"), alike(velocity)),
        "radius": (("replicate", "particle"), np.full((parameters.replicates, count), size / 2)),
    }


@once
def make_dataset(folder: Path) -> tuple[Path, Path]:
    """Write the study, all its run files and the dataset; return the study file and that."""
    study_path, results = folder / "made.yaml", folder / "results"
    study_path.write_text(STUDY)
    study = load_study(study_path, results)
    for point in study.points.values():
        parameters = point.parameters
        path = write_run(results / study.name / "runs", parameters, speed(parameters))
        with xr.open_dataset(path) as opened:
            run = opened.load()
        if isinstance(parameters, BeltParameters):
            run = run.assign(made_particles(parameters))
        else:
            made = made_profiles(parameters) | made_particles(parameters)
            run = run.drop_dims("height").assign(made)
        store(run, path)
    path = build(study_path, results)
    with xr.open_dataset(path) as opened:
        dataset = opened.load()
    rows = dataset[["depth", "stiffness"]].to_dataframe().to_dict("records")
    median = np.array([overlap(row) for row in rows])
    made = {
        "shear_depth": np.array([shear_depth(row["depth"]) for row in rows]),
        "median_overlap": median,
        "overlap_999": 10 * median,
    }
    spread = np.resize(1 + SPREAD, dataset.sizes["replicate"])
    completed = dataset["status"].values == "completed"
    for name, values in made.items():
        measure = np.where(completed, values[:, None] * spread, np.nan)
        dataset[name] = (("point", "replicate"), measure)
    store(dataset, path, mode="a")
    return study_path, path
