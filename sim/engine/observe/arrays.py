"""The arrays that a run file holds besides time series and scalars."""

from sim.parameters.observables import ASKED_FOR, PROFILES

#: Ends the name of a profile of successive blocks of samples, where its course is asked for, and
#: which there are.
HISTORY = "_history"
FOLLOWED = ("velocity_profile", "packing_profile", "granular_temperature_profile")

#: Ends the name of a profile of the last sample alone.
INSTANTANEOUS = "_instantaneous"

#: Ends the name of a profile of the beginning of the belt's cycle alone, and which there are.
AT_PHASE_0 = "_at_phase_0"
PHASED = ("velocity_profile", "packing_profile", "number_density")

#: Unit, long name and dimensions of what is known of each particle, at the first and last state.
SNAPSHOTS = {
    "position": ("m", "position of the centre", ("frame", "particle", "axis")),
    "particle_velocity": ("m s-1", "velocity of the centre", ("frame", "particle", "axis")),
    "particle_spin": ("s-1", "angular velocity", ("frame", "particle", "axis")),
    "orientation": (
        "1",
        "orientation quaternion (w, x, y, z)",
        ("frame", "particle", "quaternion"),
    ),
    "radius": ("m", "radius", ("particle",)),
    "fixed": ("1", "1 for a sphere glued to the plane, 0 for one that moves", ("particle",)),
}

#: What contacts of a frame are told where they are asked for, as `SNAPSHOTS`.
OF_CONTACTS = {
    "contact_pair": (
        "1",
        "numbers of both partners, the second -1 for plane or belt and -2 for the obstacle",
        ("frame", "contact", "partner"),
    ),
    "contact_force": ("N", "force of the contact on the first", ("frame", "contact", "axis")),
}

#: The frames of a trajectory: name -> what of a snapshot they hold.
FRAMES = {
    "trajectory_position": "position",
    "trajectory_velocity": "particle_velocity",
    "trajectory_spin": "particle_spin",
    "trajectory_contact_pair": "contact_pair",
    "trajectory_contact_force": "contact_force",
}

#: Unit, long name and dimensions of tables with dimensions of their own.
TABLES = {
    "overlap_histogram": (
        "1",
        "contacts per interval of overlap, of all samples of the window",
        ("overlap_bin",),
    ),
    "field_velocity": ("m s-1", "mean velocity along x in the laboratory", ("column", "level")),
    "field_density": (
        "m-2",
        "number of bead centres per area in the laboratory",
        ("column", "level"),
    ),
} | {
    name + AT_PHASE_0: (unit, f"{long_name} at the beginning of the cycle", ("height",))
    for name, (unit, long_name) in PROFILES.items()
    if name in PHASED
}
TABLES |= {name: (unit, long_name, ("height",)) for name, (unit, long_name) in ASKED_FOR.items()}
TABLES |= {
    name + HISTORY: (PROFILES[name][0], f"{PROFILES[name][1]}, by block", ("block", "height"))
    for name in FOLLOWED
} | {"block_end": ("s", "end of the block, since the start", ("block",))}


def described(name: str) -> tuple[str, str]:
    """Return unit and long name of a profile, of whichever part of the run it is the mean.

    >>> described("velocity_profile_at_phase_0")
    ('m s-1', 'mean velocity along x, beginning of the cycle')
    """
    when = {INSTANTANEOUS: "last sample", AT_PHASE_0: "beginning of the cycle"}
    ending = next(filter(name.endswith, when), "")
    unit, long_name = (PROFILES | ASKED_FOR)[name.removesuffix(ending)]
    return unit, f"{long_name}, {when.get(ending, 'average of the window')}"
