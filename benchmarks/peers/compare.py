"""Both engines on the same flows, stretch by stretch in turns."""

import logging
from dataclasses import dataclass
from statistics import mean, median

from benchmarks.peers.client import Client
from benchmarks.peers.flows import Flow, Ours, developed
from benchmarks.peers.settings import Settings, chosen

log = logging.getLogger(__name__)

#: Steps that LAMMPS gets to rebuild its contacts' memory, off the clock: two collisions.
WARM_UP = 80

#: Pieces of a stretch after which LAMMPS' contacts are counted, off the clock. A prime number, lest
#: they all end in the same phase of the belt.
PIECES = 23


@dataclass
class Result:
    """Rates (million particle-steps/s) and contacts per particle, one value per stretch."""

    ours: list[float]
    theirs: list[float]
    our_contacts: list[float]
    their_contacts: list[float]

    def __str__(self) -> str:
        ratios = [a / b for a, b in zip(self.ours, self.theirs, strict=True)]
        return (
            f"{mean(self.our_contacts):8.2f}{mean(self.their_contacts):8.2f}"
            f"{median(self.ours):10.1f}{median(self.theirs):8.1f}{median(ratios):8.2f}"
            f"   {min(ratios):.2f}-{max(ratios):.2f}"
        )


def measure_theirs(client: Client, ours: Ours, settings: Settings, steps: int) -> dict:
    """Give LAMMPS our present state, let it warm up and time it; add the ``rate`` (1e6/s)."""
    client.setup(*ours.handover(settings))
    client.ask("run", steps=WARM_UP)
    piece = -(-steps // PIECES)
    answer = client.ask("measure", steps=piece, pieces=PIECES)
    work = piece * PIECES * ours.parameters.particles
    return answer | {"rate": work / answer["seconds"] / 1e6}


def stretch_samples(flow: Flow, ours: Ours) -> int:
    """Return the sample intervals in one stretch, at least one."""
    p = ours.parameters
    return max(1, round(flow.stretch / (p.sample_steps * p.particles)))


def compare(client: Client, flow: Flow, settings: Settings, pairs: int) -> Result:
    """Time both engines on one flow; LAMMPS starts from our state before each of our stretches."""
    ours = developed(flow)
    p, samples = ours.parameters, stretch_samples(flow, ours)
    steps = samples * p.sample_steps
    result = Result([], [], [], [])
    for _ in range(pairs):
        theirs = measure_theirs(client, ours, settings, steps)
        seconds, contacts = ours.advance(samples)
        if theirs["dangerous"]:
            log.warning("%s: LAMMPS' list came too late, see `tune`", flow.name)
        result.ours.append(steps * p.particles / seconds / 1e6)
        result.theirs.append(theirs["rate"])
        result.our_contacts.append(contacts)
        result.their_contacts.append(theirs["contacts"])
    return result


def main(flows: list[Flow], pairs: int) -> None:
    """Print one line per flow."""
    print(f"{'':13}{'':11}{'contacts per particle':>16}{'million particle-steps/s':>28}")
    print(f"{'flow':13}particles{'Talus':>10}  LAMMPS{'Talus':>10}  LAMMPS   ratio   range")
    for flow in flows:
        with Client() as client:
            result = compare(client, flow, chosen(flow.name), pairs)
        print(f"{flow.name:13}{flow.parameters().particles:9}  {result}", flush=True)
