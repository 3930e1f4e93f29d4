"""The animations: one flow of each kind, for those who would rather look."""

from typing import Any

from sim.study.catalogue.gallas import BED, SHAKING, WINDOW
from sim.study.catalogue.limits import LARGEST_PORTION, TALLEST
from sim.study.catalogue.spec import FigureSpec
from sim.study.catalogue.walton import PAPER_FLOW

_BELT = {"amplitude": 1, "vibration_angle": 45, "damping": 50, "shear_damping": 50}

#: Friction coefficients above twice tan 17°.
_ROUGH = (0.65, 0.8, 1, 1.2)


def _chute(
    name: str,
    title: str,
    place: str,
    what: str,
    says: str,
    options: dict[str, Any] | None = None,
    **where: Any,
) -> FigureSpec:
    return FigureSpec(
        name=f"animation_{name}",
        kind="chute_animation",
        paper=f"Walton (1993), {place}",
        system="chute",
        title=title,
        where={**PAPER_FLOW, **where},
        lead=(
            f"{what}: spheres of the first replicate on the inclined plane, coloured by their "
            f"velocity down the slope (up to depth {LARGEST_PORTION} the half of the periodic cell "
            "near the viewer), and the velocity of every sphere against its height. The plane is "
            "at rest and the cell periodic: what leaves it on the right comes back on the left."
        ),
        named=(
            "depth",
            "angle",
            "friction",
            "restitution",
            "stiffness",
            "cell",
            "initial_velocity",
            "transient",
            "average",
        ),
        says=f"The paper: {says}",
        options=options or {},
    )


def _belt(
    name: str,
    title: str,
    place: str,
    what: str,
    says: str,
    *,
    frequency: float,
    obstacle: float = 0,
) -> FigureSpec:
    return FigureSpec(
        name=f"animation_{name}",
        kind="belt_animation",
        paper=f"Gallas et al. (1992), {place}",
        system="belt",
        title=title,
        where={**_BELT, "frequency": frequency, "obstacle": obstacle},
        lead=(
            f"{what}: beads of the first replicate over one cycle in the steady state, in the "
            "laboratory, coloured by their horizontal velocity, with the paths of a few (a point "
            "every 50 of 2000 steps). The belt and marks on it move with its phase between the "
            f"dashed lines at ± A_z; beads above {TALLEST:g} ⟨d⟩ are left out. The loop repeats "
            "the one cycle: the belt returns, and the beads jump back by as far as they have gone."
        ),
        named=("frequency", *SHAKING, "stiffness", *BED, "obstacle", *WINDOW),
        says=f"The paper: {says}",
    )


ANIMATED = (
    _chute(
        "accelerating",
        "A flow that accelerates",
        "Sec. 3",
        "Spheres whose friction coefficient is less than tan θ",
        "a flow accelerates without bound wherever the friction coefficient is less than the "
        "tangent of the inclination.",
        depth=5,
        friction=0.2,
    ),
    _chute(
        "rolling",
        "A thin rolling layer",
        "Fig. 1.1",
        "A flow of little more than one sphere per σ²",
        "with between one and two particles per σ² the flow is steady and slower than at other "
        "depths, and its density falls with height.",
        depth=1.24,
    ),
    _chute(
        "sheared",
        "A flow that shears throughout",
        "Fig. 1.3",
        "A flow of medium depth",
        "shallow flows usually have a velocity that rises monotonically up to the surface.",
        depth=5,
    ),
    _chute(
        "plug",
        "A plug over a layer that shears",
        "Fig. 1.4",
        "A deep flow",
        "deeper flows often have a region without shear, here crystalline, that rides over a "
        "relatively thin layer that shears.",
        depth=10,
    ),
    _chute(
        "arrested",
        "Friction beyond twice the slope",
        "Sec. 3",
        "The slowest flow of spheres whose friction coefficient is more than twice tan θ",
        "friction coefficients that greatly exceed tan θ, by more than a factor of two, arrest the "
        "flow.",
        options={"point": "slowest"},
        depth=5,
        friction=_ROUGH,
    ),
    _belt(
        "block",
        "Beads that move as a block",
        "Fig. 4a",
        "Shaking below the onset",
        "the beads move together as a block, their paths being ellipses, and nothing is "
        "transported.",
        frequency=10,
    ),
    _belt(
        "onset",
        "Beads at the onset of the flow",
        "Fig. 4c",
        "Shaking just above the onset",
        "the paths are almost sinusoidal and the beads drift along the belt.",
        frequency=20,
    ),
    _belt(
        "stream",
        "Beads in a stream",
        "Fig. 4d",
        "Shaking far above the onset",
        "the beads move like a stream, with little vertical motion, over a belt that almost none "
        "of them touches.",
        frequency=80,
    ),
    _belt(
        "obstacle",
        "Beads around an obstacle",
        "Fig. 7",
        "Shaking far above the onset with a fixed obstacle on the belt",
        "the obstacle slows the whole flow without any turbulence, and the paths look rather like "
        "those at much lower frequencies without it.",
        frequency=80,
        obstacle=1.5,
    ),
)
