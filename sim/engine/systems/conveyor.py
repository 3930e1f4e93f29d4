"""A vibrating plane with spheres or discs on it, computed in the frame of the plane."""

from math import inf, pi

import numpy as np

from sim.engine.boundary.drive import (
    OwnVibration,
    Vibration,
    plane_position,
    plane_velocity,
    vibration,
)
from sim.engine.dynamics.cells import Box, make_box
from sim.engine.dynamics.spheres import SOLID
from sim.engine.observe.profiles import AREA, VOLUME
from sim.engine.observe.regime import Scales
from sim.engine.systems.chute import Chute
from sim.engine.systems.chute_start import Layer, initial_layer, initial_row
from sim.engine.systems.series import CONVEYOR_LEDGER, total_since_start
from sim.parameters import ConveyorParameters
from sim.parameters.belt import LEAST_TRANSPORT
from sim.parameters.chute import negligible_acceleration

#: Moment of inertia of a disc over m r².
DISC = 0.5

#: Breadth of the cell of discs in their largest diameters: no disc meets its own image.
BREADTH = 3.0


class Conveyor(Chute):
    """One replicate of a flow on a vibrating plane.

    Positions and velocities of the particles are those relative to the plane; time series and
    energies are those of the laboratory.
    """

    ledger = CONVEYOR_LEDGER
    state_names = (*Chute.state_names, "drive", "plane_work")
    path_interval = 1 / 40

    parameters: ConveyorParameters
    drive: Vibration | OwnVibration

    def __init__(self, parameters: ConveyorParameters, replicate: int, substeps: int = 1):
        flat = parameters.is_flat
        self.profile_weight = AREA if flat else VOLUME
        self.inertia = (DISC if flat else SOLID) if parameters.rotation else inf
        self.plane_work = 0.0
        super().__init__(parameters, replicate, substeps)
        self.period = parameters.samples_per_cycle

    def _box(self) -> Box:
        p = self.parameters
        if not p.is_flat:
            return super()._box()
        breadth = BREADTH * max(p.diameter * (1 + p.diameter_spread), p.bumps * p.diameter)
        return make_box(p.cell * p.diameter, breadth)

    def _layer(self, replicate: int) -> Layer:
        """Return the initial state in the frame of the plane, which already moves."""
        make_layer = initial_row if self.parameters.is_flat else initial_layer
        layer = make_layer(self.parameters, self.box, replicate)
        layer.velocity[layer.mass > 0.0, ::2] -= self._starting_velocity()
        return layer

    def _base_area(self) -> float:
        """Return the area of the cell (m²); for discs its length (m)."""
        return self.box.length[0] if self.parameters.is_flat else super()._base_area()

    def _drive(self) -> Vibration | OwnVibration:
        return vibration(self.parameters, self.gravity)

    def _scales(self) -> Scales:
        p = self.parameters
        # Without a slope no flow accelerates for ever.
        negligible = negligible_acceleration(p.gravity, p.angle) if p.angle else inf
        still = LEAST_TRANSPORT * p.velocity_amplitude
        return Scales(still, acceleration=negligible, drift=p.drift, target=p.target)

    def take_over(self, other: Chute) -> None:
        """Continue with the particles of another flow, the plane in its initial phase.

        They keep their velocities in the laboratory, whatever the plane does from now on.
        """
        assert isinstance(other, Conveyor), "starts are alike"
        if other.flow.step[0] % other._cycle_steps:
            raise ValueError("that flow has been shaken for no whole number of cycles")
        super().take_over(other)
        if self.flow.step[0] % 2:
            # Even and odd steps write the two memories in turn, and the next step is the first.
            self.memory = self.memory[::-1].copy()
            self.plane = self.plane._replace(memory=self.plane.memory[::-1].copy())
        self.flow.step[0] = 0
        mobile = self.spheres.mass > 0.0
        self.spheres.velocity[::2, mobile] += (
            other._starting_velocity() - self._starting_velocity()
        )[:, None]

    def _starting_velocity(self) -> np.ndarray:
        """Return the velocity of the plane along x and z half a step before it starts, m/s."""
        time = -0.5 * self.time_step
        return np.array([plane_velocity(self.drive, axis, time) for axis in (0, 1)])

    def _state(self) -> tuple[float, ...]:
        """Return the numbers of a sample: those of the chute, momentum (x, z), work, step."""
        spheres, step = self.spheres, int(self.flow.step[0])
        momentum = (spheres.mass * spheres.velocity[::2]).sum(axis=1)
        work, self.drive.work[0] = float(self.drive.work[0]), 0.0
        return (*super()._state(), *momentum.tolist(), work, float(step))

    def _values(self, states: np.ndarray) -> dict[str, np.ndarray]:
        """Return the values (S,) of each time series from states (K, S), in the laboratory."""
        *chute, along, upward, work, step = states
        values = super()._values(np.array(chute))
        time, interval = step * self.time_step, chute[0] * self.time_step
        # Velocities live half a step before the positions.
        ux, uz = (plane_velocity(self.drive, d, time - 0.5 * self.time_step) for d in (0, 1))
        x, z = (plane_position(self.drive, d, time) for d in (0, 1))
        distance = x - plane_position(self.drive, 0, time - interval)
        displacement = x - plane_position(self.drive, 0, np.zeros(1))
        values["mean_velocity"] = values["mean_velocity"] + distance / interval
        values["mass_flux"] = values["mean_velocity"] * self.mass / self._flux_area()
        values["kinetic_energy"] = (
            values["kinetic_energy"]
            + (along * ux + upward * uz)
            + 0.5 * self.mass * (ux * ux + uz * uz)
        )
        potential = -self.gravity[2] * z - self.gravity[0] * displacement
        values["potential_energy"] = values["potential_energy"] + self.mass * potential
        values["height_of_mass"] = values["height_of_mass"] + z
        return values | {
            "plane_work": total_since_start(self, "plane_work", work),
            "plane_phase": 2.0 * pi * (step % self._cycle_steps) / self._cycle_steps,
        }

    @property
    def _cycle_steps(self) -> int:
        return self.sample_steps * self.parameters.samples_per_cycle

    def _flux_area(self) -> float:
        """Return the area (m²) of the cell; discs count as one mean diameter thick."""
        length = self.box.length[0]
        return length * (self.parameters.diameter if self.parameters.is_flat else length)
