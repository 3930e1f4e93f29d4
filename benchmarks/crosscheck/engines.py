"""One replicate of a flow in either engine, from the same random packing."""

from collections.abc import Callable, Iterator
from math import cos, radians, sin
from typing import NamedTuple

import numpy as np

from benchmarks.crosscheck.flows import BLOCKS, Flow
from benchmarks.peers.chute_input import chute_request, chute_state, frame_velocity
from benchmarks.peers.client import Client
from benchmarks.peers.settings import Settings
from sim.engine.observe.profiles import VOLUME, Profile, add_sample, empty_profile
from sim.engine.observe.samples import add_samples
from sim.engine.systems import build
from sim.parameters import ChuteParameters

#: LAMMPS looks at its list in every step: slower than need be, but no contact is missed.
SETTINGS = Settings(skin=0.2, every=1, frame="mean")


class Record(NamedTuple):
    """What one replicate gave.

    ``transient`` and ``velocity`` (S,): mean velocity (√(gσ)) per sample, before and while
    averaging; ``contacts`` (S,) per particle; per block of the averaging and slice ``packing``
    (B, H) and ``flux`` (B, H), packing fraction times velocity.
    """

    transient: np.ndarray
    velocity: np.ndarray
    contacts: np.ndarray
    packing: np.ndarray
    flux: np.ndarray


class Stretch(NamedTuple):
    """Some samples: mean velocities (m/s), contacts per particle, and the sums of the profiles."""

    velocity: np.ndarray
    contacts: np.ndarray
    profile: Profile


def synchronised(p: ChuteParameters, snapshot: dict) -> dict:
    """Return the initial state with velocities at the time of the positions.

    Ours belong to half a step earlier, LAMMPS wants them at the same time. No particles may touch.
    """
    angle, half = radians(p.angle), 0.5 * p.gravity * p.time_step
    kick = np.array([half * sin(angle), 0.0, -half * cos(angle)])
    return snapshot | {"particle_velocity": snapshot["particle_velocity"] + kick}


def _ours(p: ChuteParameters, replicate: int, lengths: list[int]) -> Iterator[Stretch]:
    """Yield stretches of so many samples each by Talus."""
    system = build(p, replicate)
    for samples in lengths:
        velocity, contacts, (profile, _) = [], [], system.no_profiles()
        while len(velocity) < samples:
            taken = system.sample(samples - len(velocity), profiles=True)
            velocity += list(taken.values["mean_velocity"])
            contacts += list(taken.values["contact_number"])
            add_samples(profile, taken.profiles[0], 0, len(taken.values["mean_velocity"]))
        yield Stretch(np.array(velocity), np.array(contacts), profile)


def _theirs(p: ChuteParameters, replicate: int, lengths: list[int]) -> Iterator[Stretch]:
    """Yield the same by LAMMPS; its velocities and contacts are those at the end of a sample."""
    system = build(p, replicate)
    snapshot = synchronised(p, system.snapshot())
    drift = frame_velocity(snapshot["particle_velocity"], SETTINGS.frame)
    with Client() as client:
        request = chute_request(p, snapshot, SETTINGS)
        client.setup(request, chute_state(p, snapshot, SETTINGS))
        for samples in lengths:
            record = client.record(p.sample_steps, samples)
            profile = empty_profile(system.slices.slices, 3)
            thickness = system.slices.slice_height
            record["velocity"][:, 0] += drift
            for height, velocity in zip(record["height"], record["velocity"], strict=True):
                radius = snapshot["radius"]
                add_sample(profile, VOLUME, thickness, height, radius, velocity)
            along = record["velocity"][:, 0].mean(axis=1)
            yield Stretch(along, record["contacts"], profile)


ENGINES: dict[str, Callable] = {"Talus": _ours, "LAMMPS": _theirs}


def run(engine: str, flow: Flow, replicate: int) -> Record:
    """Return what one replicate gives in one engine, in natural units."""
    p = flow.parameters()
    block = max(1, p.average_samples // BLOCKS)
    lengths = [max(1, p.transient_samples), *[block] * BLOCKS]
    first, *blocks = ENGINES[engine](p, replicate, lengths)
    profiles = [stretch.profile for stretch in blocks]
    slab = block * p.cell**2 * p.slice_height * p.diameter**3
    return Record(
        first.velocity / p.velocity_unit,
        np.concatenate([stretch.velocity for stretch in blocks]) / p.velocity_unit,
        np.concatenate([stretch.contacts for stretch in blocks]),
        np.array([profile.weight for profile in profiles]) / slab,
        np.array([profile.moved for profile in profiles]) / slab / p.velocity_unit,
    )
