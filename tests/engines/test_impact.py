"""One impact in plain Python is that of closed formulas, in the conventions of both engines."""

import numpy as np
import pytest
from scipy.special import beta

from sim.laws.hertz import effective_modulus
from sim.parameters import parse_point
from tests.engine.reference.hertz_impact import Friction, rebound
from tests.engines.impact import GRANULAR, TALUS, impact, turned

#: Spheres with Poisson's ratio 0.3.
LAW = {"law": "hertz", "tangential_ratio": 14 / 17}


def parameters(**values):
    shared = {"system": "chute", "law": "spring_dashpot", "tangential_ratio": 2 / 7}
    return parse_point({**shared, "angle": 0, "stiffness": 117, **values}, "impact")


#: Radii in diameters.
PARTNERS = {"pair": (0.5, 0.5), "unlike": (0.7, 0.4), "plane": (0.5,)}


def met(partner: str, velocity, steps: int, convention=TALUS, **values):
    """Return radii and masses, and velocity and spins after an impact that is about to begin."""
    p = parameters(gravity=1e-6, **values)
    radii = np.array(PARTNERS[partner]) * p.diameter
    masses = p.mass * (2 * radii / p.diameter) ** 3
    share = masses[1] / masses.sum() if len(radii) == 2 else 1.0
    start = share * np.array([0, 0, radii.sum()])
    return radii, masses, *impact(p, radii, start, np.array(velocity), steps, convention)


@pytest.mark.parametrize("partner", PARTNERS)
def test_plain_impact_with_hertz_is_that_of_the_differential_equations(partner):
    """So slow that a pair hardly turns, once from sticking and once from sliding throughout."""
    values = {"steps_per_collision": 200, "friction": 0.3, "restitution": 0.9}
    for slope in (0.5, 3.0):
        start = np.array([slope, 0, -1]) * 1e-5
        radii, masses, velocity, spins = met(partner, start, 4000, **LAW, **values)
        parting, across, rims, _ = rebound(Friction(LAW["tangential_ratio"], 0.3, 0.9), slope)
        np.testing.assert_allclose(velocity[[2, 0]], np.array([parting, across]) * 1e-5, rtol=2e-3)
        shares = rims / masses / (1 / masses).sum()
        # The frame of the reference is that of the partner, of which the sphere has a share.
        whole = masses[0] * (1 / masses).sum()
        np.testing.assert_allclose(radii * spins[:, 1], whole * shares * 1e-5, rtol=5e-3)


@pytest.mark.parametrize("partner", ["pair", "unlike"])
def test_lammps_takes_half_the_overlap_from_the_arms_of_pairs(partner):
    """Spins are smaller by the overlap's mean, weighted with the force: B(7/5, 1/2)/2 of it."""
    start, spins = np.array([0.02, 0.0, -0.02]), {}
    for convention in (TALUS, GRANULAR):
        values = {"friction": 0.1, "restitution": 1, **LAW}
        radii, masses, _, spins[convention] = met(partner, start, 200, convention, **values)
    p = parameters(**LAW)
    mass, radius = (1 / (1 / both).sum() for both in (masses, radii))
    speed = 0.02 * masses[0] / mass
    deepest = (15 * mass * speed**2 / (16 * radius**0.5 * effective_modulus(p))) ** 0.4
    smaller = 1 - spins[GRANULAR][:, 1] / spins[TALUS][:, 1]
    np.testing.assert_allclose(smaller, beta(1.4, 0.5) / 2 * deepest / 2 / radii, rtol=0.01)


def test_a_turned_force_keeps_its_size_or_its_part_within_the_plane():
    force, normal = np.array([3.0, 0.0, 4.0]), np.array([0.0, 0.0, 1.0])
    np.testing.assert_allclose(turned(force, normal, True), [5.0, 0.0, 0.0])
    np.testing.assert_allclose(turned(force, normal, False), [3.0, 0.0, 0.0])
