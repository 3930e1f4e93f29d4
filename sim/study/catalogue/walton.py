"""The figures of the inclined chute, with the parameters that the paper gives."""

from typing import Any

from sim.study.catalogue.limits import CREEP, LARGEST_PORTION, SHARE, WIDEST_INTERVAL
from sim.study.catalogue.spec import FigureSpec

#: The flows of Figs. 1.1 to 1.6; the paper leaves the stiffness open, these are the softest.
PAPER_FLOW = {"angle": 17, "friction": 0.4, "restitution": 0.85, "stiffness": 100}

#: Soft flows of forty layers leave the range of the contact law: there stiffer ones may stand.
_ANY_STIFFNESS = {name: value for name, value in PAPER_FLOW.items() if name != "stiffness"}

_MATERIAL = ("angle", "restitution", "friction", "stiffness")
_CONTACT = ("tangential_ratio", "tangential_exponent", "cell")
_WINDOW = ("transient", "average")
_OVER_DEPTH = (*_MATERIAL, *_CONTACT, "initial_velocity", *_WINDOW)

_JOINED = (
    "Lines join flows that do not accelerate and whose replicates agree on the mean within "
    f"{100 * WIDEST_INTERVAL:g} %. Error bars that end in a caret go on beyond the axes."
)
_APART = "Curves are drawn a little aside of each other, about the depth that the axis names."
_CREEPING = (
    f"Flows that move, but slower than {CREEP:g} √(gσ), have a marker of their own, whatever their "
    "regime."
)


def _figure(
    name: str, kind: str, place: str, title: str, axes: str = "", curves: str = "", **rest: Any
) -> FigureSpec:
    return FigureSpec(
        name=name,
        kind=kind,
        paper=f"Walton (1993), {place}",
        system="chute",
        title=title,
        axes=tuple(axes.split()),
        curves=tuple(curves.split()),
        **rest,
    )


def _row(number: int, depth: float, says: str) -> FigureSpec:
    part = (
        "the half of the periodic cell near the viewer"
        if depth <= LARGEST_PORTION
        else "the whole periodic cell"
    )
    return _figure(
        f"walton_1_{number}",
        "chute_row",
        f"Fig. 1.{number}",
        f"Profiles and configuration of a flow of depth {depth:g}",
        where={**(PAPER_FLOW if depth < 40 else _ANY_STIFFNESS), "depth": depth},
        lead=(
            f"Flow of depth n = N/σ² = {depth:g} down a frictional plane: (a) velocity u down the "
            "slope (top: in units of √(gσ)) and (b) packing fraction against the height z above "
            "the plane in sphere diameters σ: solid, instantaneous at the end of the first "
            "replicate; pale, time average of the averaging window of each replicate; dotted, mean "
            f"of these; up to the height below which {100 * SHARE:g} % of the solid volume lies. "
            f"(c) Configuration at the end of the first replicate, {part}, coloured by the "
            "velocity of each sphere."
        ),
        named=("depth", *_MATERIAL, *_CONTACT, "slice_height", "initial_velocity", *_WINDOW),
        says=f"The paper: {says}",
    )


_ROWS = (
    _row(
        1,
        1.24,
        "with between one and two particles per σ² the flow is steady and slower than at "
        "all other depths; its velocity rises monotonically, and its density falls monotonically, "
        "with height.",
    ),
    _row(
        2,
        2.5,
        "the velocity of flows this shallow rises monotonically with height; below this depth the "
        "density falls monotonically with height, above it has a maximum inside the flow.",
    ),
    _row(
        3,
        5,
        "up to about this depth the velocity usually rises monotonically with height, and flows of "
        "intermediate depth have their largest density inside.",
    ),
    _row(
        4,
        10,
        "a region without shear, crystalline, rides over a relatively thin layer that shears and "
        "is less dense.",
    ),
    _row(
        5,
        20,
        "an almost uniformly dense, crystalline region without shear rides over a thin layer that "
        "shears and is less dense; the layer tends to be thinner the deeper the flow.",
    ),
    _row(
        6,
        40,
        "an almost uniformly dense, crystalline region without shear rides over a layer that "
        "shears and is less dense. Layers tend to be thinner, and flows faster, the deeper they "
        "are; flows deeper than 10 depend much on the stiffness of the spheres.",
    ),
)

_OVER_THE_DEPTH = (
    _figure(
        "walton_2",
        "chute_curves",
        "Fig. 2",
        "Mean velocity against depth of the flow",
        "depth",
        "restitution friction",
        lead=(
            "Mean velocity V of monodisperse spheres on a frictional inclined plane against the "
            "depth n = N/σ² of the flow, for several coefficients of restitution e and of friction "
            "μ (right: in units of √(gσ)). Flows beyond the scale are markers at its top, with an "
            f"arrow and their velocities in m/s above them. {_JOINED} {_APART}"
        ),
        named=_OVER_DEPTH,
        says=(
            "The paper: the mean velocity tends to increase with depth; flows of one to two "
            "particles per σ² are the slowest, and those of half a particle per σ² accelerate "
            "without bound; the more elastic spheres flow slower and have a deeper shearing layer "
            "at the bottom."
        ),
    ),
    _figure(
        "shear_depth",
        "chute_measures",
        "shearing layer",
        "Height of the shearing layer against depth of the flow",
        "depth",
        "restitution stiffness",
        where={"angle": 17, "friction": 0.4},
        lead=(
            "Height δ_s of the shearing layer, in diameters σ, against the depth n = N/σ² of the "
            "flow for several coefficients of restitution e and stiffnesses K1. δ_s is where the "
            "time-averaged velocity reaches 90 % of that at the surface. "
            f"{_JOINED} {_APART}"
        ),
        named=_OVER_DEPTH,
        says=(
            "The paper: more elastic spheres have a deeper shearing layer (Fig. 2); the thickness "
            "of the layer tends to decrease as the flows get deeper; spheres stiffer by one or two "
            "orders of magnitude have a significantly deeper one in flows deeper than 10 per σ², "
            "while flows of less than 5 per σ² hardly depend on the stiffness."
        ),
        options={
            "axis": "height of the shearing layer $δ_s$ (σ)",
            "quantities": (
                {
                    "name": "shear_depth",
                    "over": "diameter",
                    "label": "height of the shearing layer [σ]",
                },
            ),
        },
    ),
    _figure(
        "overlaps",
        "chute_measures",
        "overlap of spheres",
        "Overlap of touching spheres against depth of the flow",
        "depth",
        "stiffness",
        where={"angle": 17, "friction": 0.4, "restitution": 0.85},
        lead=(
            "Overlap of touching spheres, in diameters σ, against the depth n = N/σ² of the flow "
            "for several stiffnesses K1: median of all contacts at the samples of the averaging "
            "window (dashed) and the overlap that one of a thousand exceeds (lines). Dotted: 0.5 % "
            f"and 5 %. {_JOINED}"
        ),
        named=_OVER_DEPTH,
        says=(
            "The paper: the softest spheres overlap by the order of half a percent at rest and by "
            "up to five percent in the shearing layer of the deepest flow; in flows of less than 5 "
            "per σ² by half a percent in motion."
        ),
        options={
            "axis": "overlap (σ)",
            "scale": "log",
            "levels": (0.005, 0.05),
            "quantities": (
                {
                    "name": "overlap_999",
                    "label": "overlap that one of a thousand exceeds [σ]",
                    "dashes": "solid",
                    "entry": "one of a thousand",
                },
                {
                    "name": "median_overlap",
                    "label": "median overlap [σ]",
                    "dashes": "long_dash",
                    "entry": "median",
                },
            ),
        },
    ),
)

_REGIMES = (
    _figure(
        "regimes_friction",
        "regimes",
        "flow regimes",
        "Regimes over depth and friction",
        "depth friction",
        lead=(
            "Regimes of monodisperse spheres on a frictional inclined plane over the friction "
            "coefficient μ and the depth n = N/σ² of the flow: one marker per point, boundaries "
            "between regimes as bars beside the points, and μ = tan θ, below which friction cannot "
            f"hold the weight (dotted). {_CREEPING}"
        ),
        named=("angle", "restitution", "stiffness", "cell", *_WINDOW),
        says=(
            "The paper: flows accelerate without bound wherever μ < tan θ, and at half a sphere "
            "per σ² too, as spheres then roll alone; flows with μ somewhat greater than tan θ are "
            "steady at a variety of depths; those with μ more than twice tan θ come to rest."
        ),
    ),
    _figure(
        "regimes_angle",
        "regimes",
        "range of angles of steady flow",
        "Regimes over depth and inclination",
        "depth angle",
        lead=(
            "Regimes of monodisperse spheres on a frictional inclined plane over the inclination θ "
            "and the depth n = N/σ² of the flow: one marker per point, boundaries between regimes "
            "as bars beside the points, and tan θ = μ, above which friction cannot hold the weight "
            f"(dotted). {_CREEPING}"
        ),
        named=("friction", "restitution", "stiffness", "cell", *_WINDOW),
        says=(
            "The paper expects a significant range of inclinations with steady flows for a given "
            "set of properties, and leaves it to further work."
        ),
    ),
)

WALTON = (*_ROWS, *_OVER_THE_DEPTH, *_REGIMES)
