"""Judges of flows down a rough incline: verdicts on correct, wrong and scattered flows."""

from math import sqrt

import pytest

from sim.papers.silbert import judges
from sim.papers.silbert.judges import HERTZ, STIFF
from sim.study.papers import papers
from tests.made.results import letters, made_point, spread

PAPER = papers()["silbert"].values["chute"]

#: Scatter of replicates at which nothing can be told.
WIDE = 1.0

#: What a bed at rest says of itself.
RESTS = {"regime": "arrested"}

#: What the beds of a point say of which one rests.
SOME_REST = [*4 * ["steady"], "arrested"]

#: A bed that starts from another one.
BED = {"initial_velocity": 0, "start_from": "bed.nc"}


def flow(velocity=1.0, *, depth=12, angle=26, scatter=1e-3, spheres=(), **rest):
    """Return a flow of the paper; what are no parameters are numbers of it."""
    named = {name: rest.pop(name) for name in BED if name in rest}
    own = {**PAPER, "initial_velocity": 2, "depth": depth, "angle": angle, **dict(spheres), **named}
    own = {name: value for name, value in own.items() if spheres is not HERTZ or name in KEPT}
    numbers = {"velocity": velocity} | rest
    return made_point("chute", numbers, scatter=scatter, **own)


#: Values that flows with Hertz's law have.
KEPT = {*PAPER, *HERTZ, *BED} - {"normal_damping"}


def dense(change, scatter=1e-3):
    """Return flows whose changes scatter by a tenth of ``scatter``, whatever they are."""
    changes = change + 0.1 * scatter * spread(5)
    return [flow(depth=20, angle=angle, packing_change=changes) for angle in (22, 26)]


def deep(first, second, **options):
    """Return flows of 20 and 40 layers with numbers each."""
    return [flow(depth=20, **first, **options), flow(depth=40, **second, **options)]


def powers(name, value, **options):
    return deep({name: value}, {name: value}, **options)


def scaled(power, **options):
    return deep({"flow_height": 18.0}, {"flow_height": 36.0, "velocity": 2**power}, **options)


def sloped(slow, fast, **options):
    return [
        flow(0.0, depth=20, angle=20, **RESTS),
        flow(depth=20, angle=21, profile_power=1.3, regime=SOME_REST, **options),
        flow(depth=20, angle=22, profile_power=slow, **options),
        flow(depth=20, profile_power=fast, **options),
    ]


def tilted(slowed, bed, **options):
    """Return flows and beds, each from the one before, at three angles; at the last both flow."""
    beds = [flow(bed, angle=angle, **BED, **RESTS) for angle in (21, 22)]
    flows = [flow(0.05, angle=21), flow(slowed, angle=22, **options), flow(2.0, angle=24)]
    return [*flows, *beds, flow(2.0, angle=24, **BED)]


def gaining(gain, **options):
    """Return flows of which the steeper gains a share of its velocity over the window."""
    window = flow().parameters.average * flow().parameters.time_unit
    return [flow(angle=32, acceleration=gain / window, **options), flow(**options)]


def pair(ratio, spheres, **options):
    return [flow(ratio, spheres=spheres, **options), flow(**options)]


def packed(*packing, **options):
    return [flow(angle=20 + 2 * n, bulk_packing=one, **options) for n, one in enumerate(packing)]


#: By judge: what makes a world, and arguments for one that is right, and for one that is wrong.
WORLDS = {
    judges.constant_density: (dense, (0.01,), (0.05,)),
    judges.bagnold_profile: (lambda p, **o: powers("profile_power", p, **o), (1.55,), (1.0,)),
    judges.height_scaling: (scaled, (1.5,), (1.0,)),
    judges.bagnold_rheology: (lambda p, **o: powers("rate_exponent", p, **o), (0.52,), (1.0,)),
    judges.linear_profile: (sloped, (1.0, 1.5), (1.5, 1.6)),
    judges.two_angles: (tilted, (0.5, 0.0), (0.05, 0.0)),
    judges.largest_angle: (gaining, (0.3,), (0.0,)),
    judges.force_law: (pair, (1.03, HERTZ), (1.3, HERTZ)),
    judges.stiffness: (pair, (0.98, STIFF), (0.7, STIFF)),
    judges.packing_falls: (packed, (0.59, 0.58, 0.57), (0.57, 0.58, 0.59)),
}


@pytest.mark.parametrize("judge", WORLDS, ids=lambda judge: judge.__name__)
def test_a_claim_follows_the_flows(judge):
    make, right, wrong = WORLDS[judge]
    assert letters(judge, make(*right)) == "R"
    assert letters(judge, make(*wrong)) == "N"
    assert letters(judge, make(*right, scatter=WIDE)) == "I"
    assert letters(judge, [flow(depth=3, angle=10)]) == "-"


def test_spheres_ten_times_as_stiff_have_the_same_restitution():
    """Their damping rises with the root of the stiffness; 0.883 is told for Hertz's law."""
    ratio = STIFF["normal_damping"] / PAPER["normal_damping"]
    assert ratio == pytest.approx(sqrt(STIFF["stiffness"] / PAPER["stiffness"]), rel=1e-4)
    assert HERTZ["restitution"] == pytest.approx(0.883, abs=5e-4)
