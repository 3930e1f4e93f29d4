"""The animations: one flow of each kind, for those who would rather look."""

from typing import Any

from sim.study.catalogue.spec import FigureSpec
from sim.study.catalogue.walton import PAPER_FLOW

_BELT = {"amplitude": 1, "vibration_angle": 45, "damping": 50, "shear_damping": 50}

#: Friction coefficients above twice tan 17°.
_ROUGH = (0.65, 0.8, 1, 1.2)


def _chute(kind: str, title: str, place: str, **where: Any) -> FigureSpec:
    return FigureSpec(
        name=f"animation_{kind}",
        paper=f"Walton (1993), {place}",
        system="chute",
        axes=(),
        curves=(),
        title=title,
        where={**PAPER_FLOW, **where},
        particles=True,
        animated=True,
    )


def _belt(kind: str, title: str, place: str, frequency: float, obstacle: float = 0) -> FigureSpec:
    return FigureSpec(
        name=f"animation_{kind}",
        paper=f"Gallas et al. (1992), {place}",
        system="belt",
        axes=(),
        curves=(),
        title=title,
        where={**_BELT, "frequency": frequency, "obstacle": obstacle},
        particles=True,
        animated=True,
    )


ANIMATED = (
    _chute("accelerating", "A flow that accelerates", "Sec. 3", depth=5, friction=0.2),
    _chute("rolling", "A thin rolling layer", "Fig. 1.1", depth=1.24),
    _chute("sheared", "A flow that shears throughout", "Fig. 1.3", depth=5),
    _chute("plug", "A plug over a layer that shears", "Fig. 1.4", depth=10),
    _chute("arrested", "Friction beyond twice the slope", "Sec. 3", depth=5, friction=_ROUGH),
    _belt("block", "Beads that move as a block", "Fig. 4a", frequency=10),
    _belt("onset", "Beads at the onset of the flow", "Fig. 4c", frequency=20),
    _belt("stream", "Beads in a stream", "Fig. 4d", frequency=80),
    _belt("obstacle", "Beads around an obstacle", "Fig. 7", frequency=80, obstacle=1.5),
)
