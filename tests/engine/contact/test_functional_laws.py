"""What Hertz's law and the drags of the belt have of their own."""

import numpy as np
import pytest

from sim.engine.contact import Partners, law_of
from sim.laws.hertz import effective_modulus, force
from sim.parameters import ChuteParameters
from tests.engine_motion.impacts import Impacts


def test_hertz_at_a_hundredth_of_a_diameter_is_the_spring():
    point = ChuteParameters(law="hertz")
    law = law_of(point, Partners(0.4, 0.5 * point.mass, point.time_step))
    overlap, radius, zero = point.diameter / 100, point.diameter / 4, (0.0, 0.0, 0.0)
    normal = force(law, overlap, 0.0, zero, zero, (0.0,) * 4, radius, point.mass)[0]
    assert normal == pytest.approx(point.stiffness * overlap)
    assert law.modulus == effective_modulus(point)


def test_the_shear_drag_stops_a_slip_exponentially():
    """Two equal solid spheres lose their slip at the rate (7/2) γ_s while they touch."""
    point = ChuteParameters(law="drag", restitution=0.9, steps_per_collision=400, shear_damping=20)
    law = law_of(point, Partners(0.4, 0.5 * point.mass, point.time_step))
    radii, mass = [0.5 * point.diameter] * 2, [point.mass] * 2
    made, steps = Impacts(law, radii, mass, point.time_step, 0.002, 0.001), 0
    made.motion.run(1)
    while not steps or made.touching:
        made.motion.run(1)
        steps += 1
    slowing = np.exp(-3.5 * 20 * point.gravity * (steps - 1) * point.time_step)
    assert made.slips() == pytest.approx(0.001 * slowing, rel=0.01)
