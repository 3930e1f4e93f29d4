"""The flows that are compared, developed by our engine and kept for the next time."""

import logging
import pickle
import time
from dataclasses import dataclass
from pathlib import Path

from benchmarks.peers.belt_input import belt_request, belt_state
from benchmarks.peers.chute_input import chute_request, chute_state
from benchmarks.peers.settings import CACHE, Settings
from sim.engine.identity import source_hash
from sim.engine.systems import build
from sim.parameters import Parameters, parse_point, point_id

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Flow:
    """One flow: its point, how long it develops and how much of it one timed stretch covers.

    ``relaxation`` in time units of the system (chute √(σ/g), belt cycles), ``stretch`` in
    particle-steps: short, because the two contact laws let the flow drift apart in contacts.
    """

    name: str
    point: dict
    relaxation: float
    stretch: float

    def parameters(self) -> Parameters:
        """Return the validated point."""
        return parse_point(self.point, self.name)


def _chute(depth: int, cell: int, stiffness: float, relaxation: float, stretch: float) -> Flow:
    values = {"depth": depth, "cell": cell, "stiffness": stiffness}
    velocity = {5: 8.0, 10: 16.0, 20: 25.0, 40: 25.0}[depth]
    name = f"{'soft' if stiffness < 1000 else 'hard'}-{depth * cell**2}"
    return Flow(
        name,
        {"system": "chute", "initial_velocity": velocity, **values},
        relaxation,
        stretch,
    )


#: Soft: K₁ = 117 N/m, K* = 8·10³; hard: ten times that. The number is that of the particles.
FLOWS = [
    _chute(5, 10, 117, 40.0, 5e6),
    _chute(10, 10, 117, 40.0, 5e6),
    _chute(40, 10, 117, 40.0, 1e7),
    _chute(20, 40, 117, 16.0, 4e7),
    _chute(5, 10, 1170, 40.0, 5e6),
    _chute(10, 10, 1170, 40.0, 5e6),
    _chute(40, 10, 1170, 40.0, 1e7),
    _chute(20, 40, 1170, 10.0, 4e7),
    Flow("belt", {"system": "belt", "frequency": 50, "transient": 10}, 40.0, stretch=2e7),
]


class Ours:
    """A flow in our engine: a system in motion and what it last sampled."""

    def __init__(self, system, sample: dict):
        self.system = system
        self.sample = sample

    @property
    def parameters(self) -> Parameters:
        """The point of the flow."""
        return self.system.parameters

    def advance(self, samples: int) -> tuple[float, float]:
        """Advance by sample intervals; return processor seconds taken and contacts per particle."""
        contacts = 0.0
        started = time.process_time()
        for _ in range(samples):
            self.sample = self.system.advance()
            contacts += self.sample["contact_number"]
        return time.process_time() - started, contacts / samples

    def handover(self, settings: Settings) -> tuple[dict, dict]:
        """Return request and particles that put LAMMPS into the present state."""
        p, snapshot = self.parameters, self.system.snapshot()
        if p.system == "chute":
            return chute_request(p, snapshot, settings), chute_state(p, snapshot, settings)
        phase = self.sample["belt_phase"]
        return belt_request(p, phase, settings), belt_state(p, snapshot, phase)


def developed(flow: Flow) -> Ours:
    """Return the flow after its relaxation, from the cache when this very code made it."""
    p = flow.parameters()
    path = CACHE / f"{point_id(p)}-{flow.relaxation:g}-{source_hash()[:12]}.pickle"
    ours = Ours(build(p, 0), {})
    if path.exists():
        moving, ours.sample = pickle.loads(path.read_bytes())
        for name, value in moving.items():
            setattr(ours.system, name, value)
        return ours
    log.info("%s: developing for %g time units", flow.name, flow.relaxation)
    ours.system.settle()
    ours.advance(round(flow.relaxation * p.time_unit / (p.sample_steps * p.time_step)))
    moving = {name: getattr(ours.system, name) for name in ours.system.state_names}
    _store(path, (moving, ours.sample))
    return ours


def _store(path: Path, value: object) -> None:
    path.parent.mkdir(exist_ok=True)
    path.write_bytes(pickle.dumps(value))
