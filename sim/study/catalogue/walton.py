"""The figures of the inclined chute, with the parameters that the paper gives."""

from typing import Any

from sim.study.catalogue.spec import FigureSpec

#: The flows of Figs. 1.1 to 1.6; the paper leaves the stiffness open, these are the softest.
PAPER_FLOW = {"angle": 17, "friction": 0.4, "restitution": 0.85, "stiffness": 100}

_DEPTHS = (1.24, 2.5, 5, 10, 20, 40)


def _row(number: int, depth: float) -> FigureSpec:
    return _figure(
        f"walton_1_{number}",
        f"Fig. 1.{number}",
        f"Profiles and configuration of a flow of depth {depth:g}",
        where={**PAPER_FLOW, "depth": depth},
        particles=True,
    )


def _figure(
    name: str, place: str, title: str, axes: str = "", curves: str = "", **rest: Any
) -> FigureSpec:
    return FigureSpec(
        name=name,
        paper=f"Walton (1993), {place}",
        system="chute",
        axes=tuple(axes.split()),
        curves=tuple(curves.split()),
        title=title,
        **rest,
    )


CHUTE = (
    *(_row(number, depth) for number, depth in enumerate(_DEPTHS, 1)),
    _figure(
        "walton_2",
        "Fig. 2",
        "Mean velocity against depth of the flow",
        "depth",
        "restitution friction",
    ),
    _figure(
        "shear_depth",
        "shearing layer",
        "Height of the shearing layer against depth of the flow",
        "depth",
        "restitution stiffness",
        where={"angle": 17, "friction": 0.4},
    ),
    _figure(
        "overlaps",
        "overlap of spheres",
        "Overlap of touching spheres against depth of the flow",
        "depth",
        "stiffness",
        where={"angle": 17, "friction": 0.4, "restitution": 0.85},
    ),
    _figure(
        "regimes_friction",
        "flow regimes",
        "Regimes over depth and friction",
        "depth friction",
        regimes=True,
    ),
    _figure(
        "regimes_angle",
        "range of angles of steady flow",
        "Regimes over depth and inclination",
        "depth angle",
        regimes=True,
    ),
)
