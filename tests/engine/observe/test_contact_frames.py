"""The contacts of a trajectory's frames: who touches whom, and forces that move the particles."""

import numpy as np
import pytest
import xarray as xr

from sim.base.errors import InputError
from sim.engine.run import run_point
from sim.engine.systems import build
from sim.parameters import parse_point

#: Other readings of the belt, whose loop other tests compile too.
OTHER = {"damping_mass": "reduced", "attraction": "clipped", "integrator": "verlet"}

POINTS = {
    "chute": {"system": "chute", "depth": 3, "cell": 5, "bumps": 0.3, "bump_coverage": 0.1},
    "discs": {"system": "conveyor", "depth": 4, "cell": 8, "shape": "disc", "law": "hertz"},
    "belt": {"system": "belt", "beads": 60, "width": 8, "obstacle": 2, "belt_ghost": "centred"},
    "reduced": {"system": "belt", "beads": 60, "width": 8, **OTHER},
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


@pytest.mark.parametrize("name", ["chute", "discs"])
def test_the_forces_are_those_that_the_next_step_has(name):
    system, pair, force = met(name, 60, {-1})
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


@pytest.mark.parametrize("name", ["belt", "reduced"])
def test_the_beads_of_a_contact_feel_what_their_law_says(name):
    _, pair, force = met(name, 30, {-1, -2} if name == "belt" else {-1})
    both = {(i, j): one for (i, j), one in zip(pair, force, strict=True)}
    inner = [key for key in both if key[1] >= 0]
    assert inner and all(key[::-1] in both for key in inner)
    lacking = max(np.abs(both[key] + both[key[::-1]]).max() for key in inner)
    largest = np.abs(force).max()
    if name == "reduced":
        assert lacking < 1e-12 * largest
    else:
        assert lacking > 1e-3 * largest
    carried = sum(one[1] for key, one in both.items() if key[1] < 0)
    assert carried > 0


@pytest.mark.parametrize("name", ["chute", "belt"])
def test_a_run_file_has_them_and_grows_with_them(name, tmp_path):
    more = {"trajectory": 1, "trajectory_contacts": True}
    whole, grown = tmp_path / "whole.nc", tmp_path / "grown.nc"
    run_point(point(name, **more), whole, quiet=True)
    run_point(point(name, **more | {"average": 2}), grown, quiet=True)
    run_point(point(name, **more), grown, quiet=True)
    with xr.open_dataset(whole) as one, xr.open_dataset(grown) as other:
        frames = one.sizes["trajectory_time"]
        assert frames == 10
        pair, force = one.trajectory_contact_pair, one.trajectory_contact_force
        assert pair.sizes["contact"] == force.sizes["contact"] == 10 * one.sizes["particle"]
        known = np.isfinite(pair).all("partner")
        assert (known == np.isfinite(force).all("axis")).all() and known.any("contact").all()
        assert force.units == "N"
        for each in (pair, force):
            np.testing.assert_array_equal(each, other[each.name])


def test_without_a_trajectory_there_are_none_to_keep():
    with pytest.raises(InputError, match="trajectory_contacts: got true; allowed: false without"):
        point("chute", trajectory_contacts=True)
