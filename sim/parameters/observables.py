"""What is observed of runs: names, units and meanings, the one list that all others use."""

#: Unit and long name of the scalars per replicate.
SCALARS = {
    "velocity": ("m s-1", "mean velocity over the averaging window"),
    "velocity_error": ("m s-1", "standard error of the mean velocity"),
    "velocity_half_width": ("m s-1", "half width of the 95 % interval of the mean velocity"),
    "acceleration": ("m s-2", "trend of the mean velocity over the averaging window"),
    "acceleration_error": ("m s-2", "standard error of the trend"),
    "acceleration_half_width": ("m s-2", "half width of the 95 % interval of the trend"),
    "regime": ("", "steady, accelerating, arrested or undetermined"),
    "quality": ("", "what the mean is worth: reliable, short, drifting, jammed or failed"),
    "independent_samples": ("1", "independent samples behind the mean velocity"),
    "average_start": ("s", "time at which the averaging window begins"),
    "transient_end": ("s", "time at which the transient has ended, as detected"),
    "stopped": ("", "why the run ended: length, target, arrested, accelerating, limit or failure"),
    "energy_residual": ("1", "what the energy ledger lacks, relative to the energy turned over"),
    "normal_power": ("W", "mean power dissipated by normal forces over the averaging window"),
    "frictional_power": ("W", "mean power dissipated by friction over the averaging window"),
    "shear_power": ("W", "mean power dissipated by shear friction over the averaging window"),
    "belt_power": ("W", "mean power of the belt over the averaging window"),
    "plane_power": ("W", "mean power of the vibrating plane over the averaging window"),
    "max_overlap": ("1", "largest overlap of the whole run, as in largest_overlap"),
    "base_normal": ("N", "mean normal force on the plane over the averaging window"),
    "base_shear": ("N", "mean shear force on the plane over the averaging window"),
    "normal_balance": ("1", "base_normal over N m g cos θ; 1 in a steady flow"),
    "shear_balance": ("1", "base_shear over N m g sin θ; 1 in a steady flow"),
    "base_normal_error": ("N", "standard error of base_normal"),
    "base_shear_error": ("N", "standard error of base_shear"),
    "momentum_budget": ("N", "mean base shear plus rate of change of momentum along x"),
    "momentum_budget_error": ("N", "standard error of momentum_budget"),
    "status": ("", "completed or failed"),
    "reason": ("", "why the replicate failed"),
    "steps": ("1", "time steps computed"),
    "time_step_used": ("s", "time step: that of the point, or half of it after a blow-up"),
    "wall_time": ("s", "wall time"),
    "loop_time": ("s", "processor time in the compiled loop over time steps"),
    "replicate_seed": ("1", "index that, with the seed, starts the random generator"),
}

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
    "normal_dissipation_profile": ("W m-3", "power dissipated by normal forces per volume"),
    "frictional_dissipation_profile": (
        "W m-3",
        "work against friction per time and volume, what its springs store included",
    ),
    "stress_ratio_profile": ("1", "stress xz over stress zz, of contacts and motion"),
    "inertial_number_profile": ("1", "inertial number, shear rate times σ over √(P/ρ)"),
    "fluctuation_temperature_profile": (
        "m2 s-2",
        "granular temperature about the mean velocity at each phase of the cycle",
    ),
}

#: Name of a time series -> (unit, long name).
CHUTE_SERIES = {
    "mean_velocity": ("m s-1", "mean velocity down the slope, weighted by mass"),
    "mass_flux": ("kg m-1 s-1", "mass flux per unit width of the chute"),
    "kinetic_energy": ("J", "kinetic energy of translation"),
    "rotational_energy": ("J", "kinetic energy of rotation"),
    "potential_energy": ("J", "potential energy, of the way down the slope too"),
    "stored_energy": ("J", "energy in the springs of the contacts"),
    "normal_loss": ("J", "energy dissipated by normal forces since the start"),
    "frictional_loss": ("J", "energy dissipated by friction since the start"),
    "height_of_mass": ("m", "height of the centre of mass above the plane"),
    "contact_number": ("1", "contacts per particle, those with the plane included"),
    "largest_overlap": ("1", "largest overlap since the last sample, in diameters"),
    "base_normal_force": ("N", "mean force of the flow on the plane, normal to it"),
    "base_shear_force": ("N", "mean force of the flow on the plane, down the slope"),
}

#: Name of a time series -> (unit, long name).
BELT_SERIES = {
    "mean_velocity": ("m s-1", "mean velocity of the beads along the belt"),
    "mass_flux": ("kg s-1", "mass flux along the belt"),
    "kinetic_energy": ("J", "kinetic energy of the beads"),
    "potential_energy": ("J", "potential energy above the mean belt position"),
    "stored_energy": ("J", "energy in the springs of the contacts"),
    "normal_loss": ("J", "energy dissipated by the normal damping since the start"),
    "shear_loss": ("J", "energy dissipated by the shear friction since the start"),
    "belt_work": ("J", "work of the belt on the beads since the start"),
    "height_of_mass": ("m", "height of the centre of mass above the mean belt position"),
    "contact_number": ("1", "contacts per bead, those with belt and obstacle included"),
    "largest_overlap": (
        "1",
        "largest overlap since the last sample, per sum of radii (belt: per diameter)",
    ),
    "belt_phase": ("rad", "phase of the belt's vibration"),
    "base_occupancy": ("1", "share of beads with centres within A_z of the mean belt position"),
    "wave_power": (
        "1",
        "power of the five longest waves of the density along the belt, relative to beads at "
        "random",
    ),
}

#: Time series of the belt that are kept where they are asked for; means over the sample interval.
BELT_FORCES = {
    "belt_normal_force": ("N", "mean force of the beads on the belt, downwards"),
    "belt_shear_force": ("N", "mean force of the beads on the belt, along it"),
    "belt_contacts": ("1", "mean number of beads that touch the belt"),
    "belt_contact_time": ("1", "share of the time in which any bead touches the belt"),
}

#: Those of the conveyor: of the chute, in the laboratory, and what the plane does.
CONVEYOR_SERIES = CHUTE_SERIES | {
    "mean_velocity": ("m s-1", "mean velocity along the plane in the laboratory, by mass"),
    "height_of_mass": ("m", "height of the centre of mass above the mean position of the plane"),
    "plane_work": ("J", "work of the plane on the particles since the start"),
    "plane_phase": ("rad", "phase of the plane's vibration"),
}

#: The time series of each system, with those that are kept where they are asked for.
SERIES = {
    "chute": CHUTE_SERIES,
    "belt": BELT_SERIES | BELT_FORCES,
    "conveyor": CONVEYOR_SERIES,
}

#: States of a deep flow in words.
PLUG_STATES = {
    "deep_shear": "without a plug",
    "agitated": "with an agitated plug",
    "locked": "with a locked plug",
}

#: Unit and long name of the measures that a dataset adds to the scalars, of all systems.
ENERGY_MEASURES = {
    "missing_energy": ("1", "share of the energy turned over, gains included, that is not found")
}

#: Those of the chute and of the belt.
CHUTE_MEASURES = {
    "shear_depth": ("m", "height at which the velocity is 90 % of the surface's"),
    "crystalline_share": ("1", "share of spheres above the shear depth with 8 coherent q6 bonds"),
    "layer_order": ("1", "amplitude of layers in the density above the shear depth"),
    "median_overlap": ("1", "median overlap of the contacts, in diameters"),
    "overlap_999": ("1", "99.9th percentile of the overlaps of the contacts, in diameters"),
    "base_overlap": (
        "1",
        "mean overlap of contacts with the plane in the last state, in diameters",
    ),
    "base_rolling": (
        "1",
        "spin times radius over velocity of the spheres at the plane, 1 where they roll",
    ),
    "base_slip_ratio": (
        "1",
        "slip velocity of the spheres at the plane over the root of their vertical temperature",
    ),
    "base_stress_ratio": ("1", "mean shear over mean normal force on the plane"),
} | {
    f"{state}_{what}": (unit, text.format(words))
    for what, unit, text in (
        ("share", "1", "share of the window {}"),
        ("time", "s", "time of the window {}"),
        ("endings", "1", "how often the flow was seen to stop being {}"),
    )
    for state, words in PLUG_STATES.items()
}
BELT_MEASURES = {
    "base_occupancy": ("1", "share of beads with centres within A_z of the mean belt position"),
    "base_occupancy_at_phase_0": ("1", "the same at the beginning of the cycle alone"),
    "wave_power": ("1", "power of the five longest density waves, relative to beads at random"),
    "wave_power_at_phase_0": ("1", "the same at the beginning of the cycle alone"),
    "early_wave_power": ("1", "the same at all times of the first 10 cycles"),
    "belt_contact_time": ("1", "share of the time in which any bead touches the belt"),
    "belt_force_phase": ("rad", "phase of the belt about which the force on it lies, 0 to 2π"),
    "path_drift": ("m", "mean displacement of the beads along the belt in a cycle"),
    "path_vertical": ("m", "rms vertical distance of the beads from their mean places in a cycle"),
    "path_vertical_far": (
        "m",
        "the same of beads more than 5 ⟨d⟩ along the belt from its middle, where obstacles stand",
    ),
    "path_major": ("m", "rms extent of the mean path, less its drift, along its long axis"),
    "path_minor": ("m", "rms extent of the mean path, less its drift, along its short axis"),
    "path_tilt": ("rad", "angle of the long axis of the mean path with the horizontal, 0 to π"),
    "backflow": (
        "1",
        "share of beads in squares of the laboratory whose mean velocity is negative",
    ),
}

#: Those of the conveyor, some of which the chute has too.
CONVEYOR_MEASURES = {
    "shaking_strength": ("1", "peak acceleration of the plane along z over gravity, A_z ω²/g"),
    "transport_efficiency": ("1", "mean velocity over that of the plane along x, V/(A_x ω)"),
} | {name: CHUTE_MEASURES[name] for name in ("median_overlap", "overlap_999", "base_overlap")}

#: Those of each system besides.
MEASURES_OF = {
    "chute": CHUTE_MEASURES,
    "belt": BELT_MEASURES,
    "conveyor": CONVEYOR_MEASURES,
}

#: All of them.
MEASURES: dict[str, tuple[str, str]] = (
    ENERGY_MEASURES | CHUTE_MEASURES | BELT_MEASURES | CONVEYOR_MEASURES
)

_OF_SPHERES = {
    "frictional_power",
    "base_normal",
    "base_shear",
    "normal_balance",
    "shear_balance",
    "base_normal_error",
    "base_shear_error",
    "momentum_budget",
    "momentum_budget_error",
    *(name for name in ASKED_FOR if name != "fluctuation_temperature_profile"),
}
_OF_BELTS = {"shear_power", "belt_power", "number_density", "fluctuation_temperature_profile"}

#: Scalars, profiles and measures that a system never has.
LACKING = {
    system: lacking | (MEASURES.keys() - ENERGY_MEASURES.keys() - MEASURES_OF[system].keys())
    for system, lacking in {
        "chute": _OF_BELTS | {"plane_power"},
        "belt": _OF_SPHERES | {"plane_power"},
        "conveyor": _OF_BELTS,
    }.items()
}

#: By system, what run files have and datasets do without, since no figure and no claim looks at it.
LEFT_OUT = {
    "chute": frozenset[str](),
    "belt": frozenset({"vertical_temperature_profile"}),
    "conveyor": frozenset[str](),
}

#: Unit and long name of what a dataset has along the belt and over its cycle, and of where profiles
#: lie.
ALONG = {
    "height": ("m", "height of the slice above the base"),
    "column": ("m", "place of the square along the belt"),
    "column_velocity": ("m s-1", "mean velocity along x, of all heights"),
    "column_density": ("m-1", "number of bead centres per length of the belt"),
    "cycle_phase": ("rad", "phase of the belt's vibration"),
    "cycle_normal_force": ("N", "mean force of the beads on the belt, downwards"),
    "cycle_shear_force": ("N", "mean force of the beads on the belt, along it"),
    "cycle_contact_time": ("1", "share of the time in which any bead touches the belt"),
}

#: Unit and long name of what a dataset says of each point, besides its parameters.
OF_POINTS = {
    "point": ("", "id of the point"),
    "series": ("", "series of the study that have the point"),
    "figures": ("", "figures that the point feeds"),
    "caveat": ("", "what to know before trusting the point"),
    "run_source_hash": ("", "hash of the sources that ran the point"),
    "particles": ("1", "number of particles"),
    "point_velocity": ("m s-1", "mean velocity, all replicates together"),
    "point_half_width": (
        "m s-1",
        "half width of the 95 % interval of the mean velocity, all replicates together",
    ),
    "point_regime": ("", "steady, accelerating, arrested or undetermined, all replicates together"),
    "point_quality": ("", "what the mean of all replicates together is worth"),
    "point_stopped": ("", "why the runs ended"),
}
