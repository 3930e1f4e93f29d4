"""The whole of Gallas' Fig. 1a on two cores, start-up included: Snakemake and us, then LAMMPS."""

import shutil
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from queue import SimpleQueue

import numpy as np
import xarray as xr
import yaml

from benchmarks.peers.belt_input import belt_state, resting_request, shaking
from benchmarks.peers.client import Client
from benchmarks.peers.settings import CACHE, chosen
from sim.engine.systems import build
from sim.parameters import BeltParameters, point_id
from sim.study.load import load_study

#: Points of the figure at which the published time step is stable.
ANGLES = [30, 45, 60]
FREQUENCIES = [15, 16, 17, 18, 20, 25, 30, 40, 60, 80, 100]

#: Processes at a time.
CORES = 2

STUDY = "peers-sweep"

#: Away from other studies, of which runs would be taken.
FOLDER = CACHE / "sweep"
RESULTS = FOLDER / "results" / STUDY


def study_file(cycles: float) -> Path:
    """Write the study of these points, with as many cycles discarded as averaged."""
    series = {
        "name": "frequency-angle",
        "system": "belt",
        "grid": {"vibration_angle": ANGLES, "frequency": FREQUENCIES},
    }
    study = {
        "study": STUDY,
        "defaults": {"belt": {"transient": cycles, "average": cycles}},
        "series": [series],
    }
    path = FOLDER / "sweep.yaml"
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(yaml.safe_dump(study))
    return path


def ours(study: Path) -> float:
    """Return the seconds that the study's runs take in our workflow, compiled beforehand."""
    subprocess.run([sys.executable, "-m", "sim", "warm", study], check=True, capture_output=True)
    shutil.rmtree(RESULTS, ignore_errors=True)
    command = [sys.executable, "-m", "snakemake", "--cores", str(CORES), "--quiet", "all"]
    command += ["--snakefile", str(Path("Snakefile").absolute()), "--configfile", study.name]
    started = time.perf_counter()
    subprocess.run([*command, "--", "runs"], check=True, cwd=FOLDER)
    return time.perf_counter() - started


def our_velocity(p: BeltParameters) -> float:
    """Return the transport velocity (m/s) that our run has found."""
    with xr.open_dataset(RESULTS / "runs" / f"{point_id(p)}.nc") as run:
        return float(run.velocity.mean())


def their_run(client: Client, p: BeltParameters, snapshot: dict) -> float:
    """Settle, discard and average as our runs do; return the transport velocity (m/s)."""
    client.setup(resting_request(p, chosen("belt")), belt_state(p, snapshot, 0.0))
    interval = round(0.01 / p.settling_step)
    client.ask("settle", steps=interval, squared=p.settle_velocity_squared)
    client.ask("command", lines=shaking(p, 0.0))
    client.ask("run", steps=p.transient_samples * p.sample_steps)
    before = client.ask("travel")["along"]
    steps = p.average_samples * p.sample_steps
    client.ask("run", steps=steps)
    return (client.ask("travel")["along"] - before) / (steps * p.time_step)


def theirs(points: list[BeltParameters]) -> tuple[float, list[float]]:
    """Return the seconds that two LAMMPS processes take for all runs, and the velocities (m/s).

    Their particles are made beforehand, and they sample nothing on their way.
    """
    states = [build(p, 0).snapshot() for p in points]
    started = time.perf_counter()
    clients = SimpleQueue()

    def run(p: BeltParameters, state: dict) -> float:
        client = clients.get()
        velocity = their_run(client, p, state)
        clients.put(client)
        return velocity

    opened = [Client() for _ in range(CORES)]
    for client in opened:
        clients.put(client)
    with ThreadPoolExecutor(CORES) as pool:
        velocities = list(pool.map(run, points, states))
    for client in opened:
        client.close()
    return time.perf_counter() - started, velocities


def main(cycles: float) -> None:
    """Print wall times, their ratio and how far the curves are apart."""
    study = study_file(cycles)
    points = [run.parameters for run in load_study(study).points.values()]
    our_seconds = ours(study)
    their_seconds, velocities = theirs(points)
    steps = sum(p.steps for p in points)
    print(f"{len(points)} belts, {steps:.2e} steps in all, {CORES} cores, start-up included")
    print(f"Talus {our_seconds:.1f} s, LAMMPS {their_seconds:.1f} s")
    print(f"speed of Talus / LAMMPS: {their_seconds / our_seconds:.2f}")
    apart = np.array([our_velocity(p) for p in points]) - velocities
    rms = np.sqrt((apart**2).mean())
    print(f"V_x of Talus less that of LAMMPS: {apart.mean():+.4f} m/s on average, rms {rms:.4f}")
