"""Walton's inclined chute: particles that gravity drives down a resting plane."""

from sim.engine.boundary.drive import Gravity
from sim.engine.observe.regime import Scales
from sim.engine.systems.plane_flow import PlaneFlow
from sim.parameters import ChuteParameters
from sim.parameters.chute import negligible_acceleration


class Chute(PlaneFlow):
    """One replicate of a chute flow in motion."""

    parameters: ChuteParameters

    def __init__(self, parameters: ChuteParameters, replicate: int, substeps: int = 1):
        super().__init__(parameters, replicate, substeps, path_interval=0.1)
        p = parameters
        negligible = negligible_acceleration(p.gravity, p.angle)
        self.scales = Scales(1e-3 * p.velocity_unit, negligible, p.drift, p.target)

    def _drive(self) -> Gravity:
        return Gravity(self.gravity)
