"""LAMMPS' best settings for each flow, found one setting after the other on the spot."""

from dataclasses import replace
from statistics import median

from benchmarks.peers.client import Client
from benchmarks.peers.compare import measure_theirs
from benchmarks.peers.flows import Flow, Ours, developed
from benchmarks.peers.settings import CANDIDATES, Settings, store

#: Measurements per candidate, taken in turns, of which the median counts.
ROUNDS = 3

#: Particle-steps in each, and the fewest steps, which the list has to be rebuilt in often.
STRETCH = 1e7
FEWEST_STEPS = 1000


def rates(client: Client, ours: Ours, candidates: list[Settings]) -> list[float]:
    """Return the speed (1e6/s) of LAMMPS with each candidate; 0 where its list came too late."""
    steps = max(FEWEST_STEPS, round(STRETCH / ours.parameters.particles))
    measured = [[] for _ in candidates]
    for _ in range(ROUNDS):
        for values, settings in zip(measured, candidates, strict=True):
            answer = measure_theirs(client, ours, settings, steps)
            values.append(0.0 if answer["dangerous"] else answer["rate"])
    return [median(values) if min(values) else 0.0 for values in measured]


def tune(flow: Flow) -> Settings:
    """Go through `CANDIDATES`, keep what is fastest, print what was seen."""
    ours, best = developed(flow), Settings()
    with Client() as client:
        for name, values in CANDIDATES:
            if ours.parameters.system == "belt" and name == "frame":
                continue
            candidates = [replace(best, **{name: value}) for value in values]
            speeds = rates(client, ours, candidates)
            best = candidates[speeds.index(max(speeds))]
            seen = ", ".join(f"{v}: {s:.1f}" for v, s in zip(values, speeds, strict=True))
            print(f"{flow.name:10} {name:7} {seen}", flush=True)
    print(f"{flow.name:10} best: {best}", flush=True)
    return best


def main(flows: list[Flow]) -> None:
    """Tune LAMMPS for these flows and keep what was found."""
    for flow in flows:
        store(flow.name, tune(flow))
