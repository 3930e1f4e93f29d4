"""What the time series of both systems are, and which of them add up to the energy."""

from typing import Any

import numpy as np

from sim.engine.observe.ledger import Ledger

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

CHUTE_LEDGER = Ledger(
    terms=dict.fromkeys(
        (
            "kinetic_energy",
            "rotational_energy",
            "potential_energy",
            "stored_energy",
            "normal_loss",
            "frictional_loss",
        ),
        1,
    ),
    turnover=("normal_loss", "frictional_loss"),
    powers={"normal_loss": "normal_power", "frictional_loss": "frictional_power"},
)

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

BELT_LEDGER = Ledger(
    terms={
        "kinetic_energy": 1,
        "potential_energy": 1,
        "stored_energy": 1,
        "normal_loss": 1,
        "shear_loss": 1,
        "belt_work": -1,
    },
    turnover=("belt_work",),
    powers={
        "normal_loss": "normal_power",
        "shear_loss": "shear_power",
        "belt_work": "belt_power",
    },
)


def since_start(system: Any, name: str, gained: np.ndarray) -> np.ndarray:
    """Return a sum since the start at each of some samples, and keep the last in the system."""
    total = np.cumsum([getattr(system, name), *gained])
    setattr(system, name, float(total[-1]))
    return total[1:]
