"""A vibrating plane with spheres or discs on it, computed in the frame of the plane."""

from math import inf, pi

import numpy as np

from sim.engine.boundary.drive import Vibration, plane_position, plane_velocity, vibration
from sim.engine.observe.regime import Scales
from sim.engine.observe.samples import make_ledger
from sim.engine.systems import leap_frog
from sim.engine.systems.chute import LOSSES, TERMS, PlaneFlow, State
from sim.parameters import ConveyorParameters
from sim.parameters.belt import LEAST_TRANSPORT
from sim.parameters.chute import negligible_acceleration


class Conveyor(PlaneFlow):
    """One replicate of a flow on a vibrating plane.

    Positions and velocities of the particles are those relative to the plane; time series and
    energies are those of the laboratory.
    """

    ledger = make_ledger(*TERMS, "plane_work", turnover=LOSSES)
    state_names = (*PlaneFlow.state_names, "drive", "plane_work")

    parameters: ConveyorParameters
    drive: Vibration

    def __init__(self, parameters: ConveyorParameters, replicate: int, substeps: int = 1):
        super().__init__(parameters, replicate, substeps, path_interval=1 / 40)
        p, (length, breadth, _) = parameters, self.box.length
        self.plane_work = 0.0
        self.period = p.samples_per_cycle
        if not p.rotation:
            self.inertia = inf
        # Discs count as one mean diameter thick.
        self.flux_area = length * (p.diameter if p.is_flat else breadth)
        # Without a slope no flow accelerates for ever.
        negligible = negligible_acceleration(p.gravity, p.angle) if p.angle else inf
        still = LEAST_TRANSPORT * p.velocity_amplitude
        self.scales = Scales(still, negligible, p.drift, p.target)
        self._add_velocity(-self._starting_velocity())

    def _drive(self) -> Vibration:
        return vibration(self.parameters, self.tilt or self.gravity)

    def take_over(self, other: "Conveyor") -> None:
        """Continue with the particles of another flow, the plane in its initial phase.

        They keep their velocities in the laboratory, whatever the plane does from now on.
        """
        other.require_whole_cycles()
        super().take_over(other)
        self._add_velocity(other._starting_velocity() - self._starting_velocity())

    def _add_velocity(self, velocity: np.ndarray) -> None:
        """Add a velocity along x and z (m/s) to those of all mobile particles."""
        self.spheres.velocity[::2, self.spheres.mass > 0.0] += velocity[:, None]

    def _starting_velocity(self) -> np.ndarray:
        """Return the velocity of the plane along x and z half a step before it starts, m/s."""
        return self._plane_velocity(-0.5 * self.time_step)

    def _plane_velocity(self, time: float) -> np.ndarray:
        return np.array([plane_velocity(self.drive, axis, time) for axis in (0, 1)])

    def _frame_change(self) -> np.ndarray:
        along, normal = self._plane_velocity(0.5 * self.time_step) - self._starting_velocity()
        return np.array([[along], [0.0], [normal]])

    def _state(self) -> State:
        """Add the momentum ``along`` x and ``upward``, and the ``work`` of the plane."""
        spheres = self.spheres
        along, upward = (spheres.mass * spheres.velocity[::2]).sum(axis=1)
        work, self.drive.work[0] = float(self.drive.work[0]), 0.0
        return super()._state() | {"along": along, "upward": upward, "work": work}

    def _values(self, state: State) -> dict[str, np.ndarray]:
        """Return the values (K,) of each time series in the laboratory."""
        values = super()._values(state)
        time = state["step"] * self.time_step
        interval = state["sums"][:, leap_frog.STEPS] * self.time_step
        # Velocities live half a step before the positions.
        ux, uz = (plane_velocity(self.drive, d, time - 0.5 * self.time_step) for d in (0, 1))
        x, z = (plane_position(self.drive, d, time) for d in (0, 1))
        distance = x - plane_position(self.drive, 0, time - interval)
        displacement = x - plane_position(self.drive, 0, np.zeros(1))
        values["mean_velocity"] = values["mean_velocity"] + distance / interval
        values["mass_flux"] = values["mean_velocity"] * self.mass / self.flux_area
        values["kinetic_energy"] = (
            values["kinetic_energy"]
            + (state["along"] * ux + state["upward"] * uz)
            + 0.5 * self.mass * (ux * ux + uz * uz)
        )
        potential = -self.gravity[2] * z - self.gravity[0] * displacement
        values["potential_energy"] = values["potential_energy"] + self.mass * potential
        values["height_of_mass"] = values["height_of_mass"] + z
        values |= self._tilted(state, values)
        return values | {
            "plane_work": self._total("plane_work", state["work"]),
            "plane_phase": 2.0 * pi * (state["step"] % self.cycle_steps) / self.cycle_steps,
        }
