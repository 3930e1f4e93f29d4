"""Is LAMMPS computing the same physics? Rebounds on the chute, a few beads on the belt."""

import numpy as np

from benchmarks.peers.belt_input import belt_request, belt_state
from benchmarks.peers.chute_input import chute_request, chute_state
from benchmarks.peers.client import Client
from benchmarks.peers.settings import Settings
from sim.engine.systems import build
from sim.parameters import BeltParameters, ChuteParameters

#: Speed of the test impacts in √(gσ), fast enough for weight to matter little.
SPEED = 5.0

#: Friction coefficient of particles and plane.
FRICTION = 0.4

#: Largest error of a coefficient; the time step alone makes about half of it.
TOLERANCE = 0.003


def rebound(client: Client, position: list, velocity: list) -> np.ndarray:
    """Return the changes of velocity (√(gσ)) in the first collision of these particles.

    ``position`` in diameters, ``velocity`` in √(gσ); the frame moves with their mean velocity.
    """
    p = ChuteParameters(angle=0, friction=FRICTION, cell=10, stiffness=1e4)
    count = len(position)
    snapshot = {
        "position": np.array(position, float) * p.diameter,
        "particle_velocity": np.array(velocity, float) * p.velocity_unit,
        "particle_spin": np.zeros((count, 3)),
        "radius": np.full(count, 0.5 * p.diameter),
    }
    settings = Settings(frame="mean")
    state = chute_state(p, snapshot, settings)
    client.setup(chute_request(p, snapshot, settings), state)
    client.ask("run", steps=3 * p.steps_per_collision)
    return (np.array(client.ask("snapshot")["velocity"]) - state["velocity"]) / p.velocity_unit


def coefficients(client: Client) -> dict[str, tuple[float, float]]:
    """Return what was found and what is wanted: restitutions, and friction in gross slip."""
    half, fast = 0.5 * SPEED, 4.0 * SPEED
    pair = rebound(client, [[4, 5, 5], [5.001, 5, 5]], [[half, 0, 0], [-half, 0, 0]])
    plane = rebound(client, [[5, 5, 0.501]], [[fast, 0, -SPEED]])[0]
    return {
        "restitution of a pair": ((pair[1, 0] - pair[0, 0]) / SPEED - 1.0, 0.85),
        "restitution of the plane": (plane[2] / SPEED - 1.0, 0.85),
        "friction of the plane": (-plane[0] / plane[2], FRICTION),
    }


def belt_difference(client: Client, steps: int) -> float:
    """Return how far (⟨d⟩) a bed moves apart in our engine and in LAMMPS within some steps.

    Equal beads and velocity Verlet, with which both engines solve the very same equations.
    """
    p = BeltParameters(
        frequency=50,
        beads=100,
        diameter_spread=0,
        integrator="verlet",
        samples_per_cycle=2000 // steps,
    )
    system = build(p, 0)
    system.settle()
    for _ in range(p.samples_per_cycle):
        phase = system.advance()["belt_phase"]
    state = belt_state(p, system.snapshot(), phase)
    client.setup(belt_request(p, phase, Settings()), state)
    client.ask("run", steps=steps)
    phase = system.advance()["belt_phase"]
    ours = belt_state(p, system.snapshot(), phase)["position"]
    apart = ours - np.array(client.ask("snapshot")["position"])
    width = p.width * p.diameter
    apart[:, 0] -= width * np.round(apart[:, 0] / width)
    return float(np.abs(apart).max() / p.diameter)


def main() -> None:
    """Print what was found; raise when LAMMPS is not given the physics that is meant."""
    with Client() as client:
        for name, (found, wanted) in coefficients(client).items():
            print(f"{name}: {found:.4f}, wanted {wanted}")
            assert abs(found - wanted) < TOLERANCE
        apart = belt_difference(client, 100)
        print(f"belt: beads {apart:.1e} diameters apart after 100 steps")
        assert apart < 1e-3
