"""The arrays that a run file holds besides time series and scalars."""

#: Unit and long name of the profiles over height, each the average of the window.
PROFILES = {
    "velocity_profile": ("m s-1", "mean velocity along x"),
    "packing_profile": ("1", "packing fraction"),
    "number_density": ("m-2", "number of bead centres per area"),
    "granular_temperature_profile": ("m2 s-2", "granular temperature, mean of the directions"),
    "vertical_temperature_profile": ("m2 s-2", "granular temperature of the vertical direction"),
}

#: Unit and long name of the profiles that are kept where they are asked for, each the average of
#: the window. Stresses are those of what is above on what is below, x pointing down the slope.
ASKED_FOR = {
    "contact_longitudinal_stress_profile": ("Pa", "stress xx that contacts carry"),
    "contact_transverse_stress_profile": ("Pa", "stress yy that contacts carry"),
    "contact_normal_stress_profile": ("Pa", "stress zz that contacts carry"),
    "contact_shear_stress_profile": ("Pa", "stress xz that contacts carry"),
    "kinetic_longitudinal_stress_profile": ("Pa", "stress xx that motion carries"),
    "kinetic_transverse_stress_profile": ("Pa", "stress yy that motion carries"),
    "kinetic_normal_stress_profile": ("Pa", "stress zz that motion carries"),
    "kinetic_shear_stress_profile": ("Pa", "stress xz that motion carries"),
    "overburden_profile": ("Pa", "weight of what is above, normal to the plane, per area"),
    "spin_profile": ("s-1", "mean angular velocity about y"),
    "sliding_share_profile": ("1", "share of the contacts with a force that slide"),
    "slip_velocity_profile": ("m s-1", "mean slip velocity at the contacts that slide"),
    "fluctuation_temperature_profile": (
        "m2 s-2",
        "granular temperature about the mean velocity at each phase of the cycle",
    ),
}

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
