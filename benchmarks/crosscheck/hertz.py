"""First stage, for ``law: hertz``: oblique impacts from head-on to grazing, in both engines.

LAMMPS has the same forces in ``pair_style granular``, with a damping of the same restitution and a
friction that adds up increments of force; its pairs differ by the arms of their torques alone.
"""

from math import radians, tan

from benchmarks.crosscheck.contacts import ROUNDING, Check, Edit, rebound, rebound_checks
from benchmarks.peers.chute_input import hertz_model
from benchmarks.peers.client import Client
from sim.laws.hertz import effective_modulus
from sim.parameters import ChuteParameters

#: Stiffness at σ/100 (N/m) and tangential stiffness, of spheres with Poisson's ratio 0.3.
LAW = {"law": "hertz", "tangential_ratio": 14 / 17}
SOFT = 117.0

SLOPES = [tan(radians(angle)) for angle in range(0, 90, 5)]

IMPACTS = [(e, slope) for e in (0.5, 0.8, 1.0) for slope in SLOPES]

#: Largest difference that the arms of torques make with the softest spheres; it goes with the
#: overlap, hence with the stiffness to the power -2/5.
ARMS = 0.05

#: How much stiffer, and in how many steps per collision, pairs are looked at once more.
AGAIN = [(1.0, 160), (1e2, 40), (1e4, 40)]


def _classic(p: ChuteParameters, commands: str) -> str:
    ours = f"pair_style granular\npair_coeff * * {hertz_model(p, p.friction)}"
    modulus = effective_modulus(p)
    theirs = (
        f"pair_style gran/hertz/history {4 / 3 * modulus:.17g} "
        f"{2 * p.tangential_ratio * modulus:.17g} 0 0 {p.friction:.17g} 0\npair_coeff * *"
    )
    return commands.replace(ours, theirs)


def _instead(ours: str, theirs: str) -> Edit:
    return lambda _, commands: commands.replace(ours, theirs)


#: Other models of LAMMPS, and whom they are looked at with.
OTHERS: dict[str, tuple[str, Edit]] = {
    "tangential mindlin": ("plane", _instead("mindlin/force", "mindlin")),
    "tangential mindlin_rescale": ("plane", _instead("mindlin/force", "mindlin_rescale")),
    "tangential mindlin_rescale/force": (
        "plane",
        _instead("mindlin/force", "mindlin_rescale/force"),
    ),
    "gran/hertz/history": ("pair", _classic),
}

#: Damping by a polynomial of the restitution, and restitutions asked for.
POLYNOMIAL = _instead("coeff_restitution", "tsuji")
ASKED = (0.5, 0.8, 0.98)


def largest(client: Client, partner: str, edit: Edit | None = None, **values) -> float:
    """Return the largest difference between the engines in elastic impacts at all angles."""
    values = {**LAW, "stiffness": SOFT, "restitution": 1.0, **values}
    return max(rebound(client, partner, slope, edit, **values).engines for slope in SLOPES)


def hertz_checks(client: Client) -> list[Check]:
    """Return what impacts with ``hertz`` give."""
    found = rebound_checks(client, "plane", ROUNDING, IMPACTS, **LAW)
    for partner in ("pair", "unlike pair"):
        found += rebound_checks(client, partner, ARMS, IMPACTS, **LAW)
        for stiffer, steps in AGAIN:
            values = {"stiffness": stiffer * SOFT, "steps_per_collision": steps}
            name = f"hertz, {partner}: {stiffer:g} times the stiffness, t_c/{steps}"
            allowed = ARMS * stiffer**-0.4
            found.append(Check(name, largest(client, partner, **values), allowed))
    return found


def other_models(client: Client) -> dict[str, float]:
    """Return how far LAMMPS is from Talus with models that are not the same, over the speed."""
    found = {
        f"{name}, {partner}": largest(client, partner, edit)
        for name, (partner, edit) in OTHERS.items()
    }
    for e in ASKED:
        values = {**LAW, "stiffness": SOFT, "restitution": e}
        apart = rebound(client, "plane", 0.0, POLYNOMIAL, **values).engines
        found[f"damping tsuji, head-on at restitution {e:g}"] = apart
    return found
