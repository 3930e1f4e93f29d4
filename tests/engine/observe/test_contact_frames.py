"""The contacts of a trajectory's frames: who touches whom, and forces that move the particles."""

import numpy as np
import pytest

from sim.engine.systems import build
from sim.parameters import parse_point

POINTS = {
    "chute": {"system": "chute", "depth": 3, "cell": 5, "bumps": 0.3, "bump_coverage": 0.1},
    "belt": {"system": "belt", "beads": 60, "width": 8, "obstacle": 2, "belt_ghost": "centred"},
}


def point(name: str, **more):
    return parse_point(POINTS[name] | {"transient": 5, "average": 5} | more, "point")


def met(name: str, samples: int, partners: set[int]):
    """Return a flow after so many samples and as many more as it takes to touch such partners.

    And its contacts, pairs and forces.
    """
    parameters = point(name)
    system = build(parameters, 0)
    system.settle()
    most = parameters.most_contacts * (parameters.particles + parameters.glued_particles)
    for taken in range(samples + 400):
        system.advance()
        listed = system.current_contacts(most)
        number = int(listed.number[0])
        if taken > samples and partners <= set(listed.pair[:number, 1]) and number > 20:
            return system, listed.pair[:number].astype(int), listed.force[:number]
    raise AssertionError("they never touch")


def test_the_forces_are_those_that_the_next_step_has():
    system, pair, force = met("chute", 60, {-1})
    total = np.zeros((len(system.spheres.mass), 3))
    np.add.at(total, pair[:, 0], force)
    inner = pair[:, 1] >= 0
    np.add.at(total, pair[inner, 1], -force[inner])
    system._run(1)
    found = np.zeros_like(total)
    found[system.spheres.label[0]] = system.spheres.force.sum(axis=0).T
    mobile = np.zeros(len(total), bool)
    mobile[system.spheres.label[0]] = system.spheres.mass > 0
    assert total[mobile] == pytest.approx(found[mobile], abs=1e-9 * abs(found).max())


def test_the_beads_of_a_contact_feel_what_their_law_says():
    """Forces of a pair are not opposite, as each bead is damped by its own mass."""
    _, pair, force = met("belt", 30, {-1, -2})
    both = {(i, j): one for (i, j), one in zip(pair, force, strict=True)}
    inner = [key for key in both if key[1] >= 0]
    assert inner and all(key[::-1] in both for key in inner)
    lacking = max(np.abs(both[key] + both[key[::-1]]).max() for key in inner)
    assert lacking > 1e-3 * np.abs(force).max()
    assert sum(one[1] for key, one in both.items() if key[1] < 0) > 0
