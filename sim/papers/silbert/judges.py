"""How the claims of claims.yaml are judged. Lengths are in diameters, velocities in √(gd)."""

from uncertainties.umath import log

from sim.claims.checks import above, below, within
from sim.claims.inference import trend
from sim.claims.place import ANY, quotient
from sim.claims.verdict import Untestable

#: Spheres ten times as stiff as the paper's, of their restitution, and what has it by Hertz's law.
STIFF = {"stiffness": 2000000, "normal_damping": 158.114}
HERTZ = {"law": "hertz", "restitution": 0.883}


def constant_density(evidence, *, most, angles, depth):
    """Compare the packing fraction at the bottom and the top of the bulk."""
    flows = [evidence.at("chute", depth=depth, angle=one) for one in angles]
    return [
        within(
            f"relative change of φ over the bulk, {one['angle']:g}°",
            one.value("packing_change"),
            -most,
            most,
            [one],
        )
        for one in flows
    ]


def bagnold_profile(evidence, *, power, width, depths, angle):
    """Judge the power of the velocity profile."""
    return _power_checks("p", "profile_power", _flows(evidence, depths, angle), power, width)


def bagnold_rheology(evidence, *, power, width, depths, angle):
    """Judge the slope of ln γ̇ over ln σ_xz in the bulk."""
    flows = _flows(evidence, depths, angle)
    return _power_checks("d ln γ̇/d ln σ_xz", "rate_exponent", flows, power, width)


def _flows(evidence, depths, angle):
    return [evidence.at("chute", depth=depth, angle=angle) for depth in depths]


def _power_checks(quantity, observable, flows, power, width):
    low, high = power - width, power + width
    return [
        within(f"{quantity}, {one['depth']:g} layers", one.value(observable), low, high, [one])
        for one in flows
    ]


def height_scaling(evidence, *, power, width, depths, angle):
    """Judge the slope of ln V over ln h between two flows."""
    thin, thick = places = _flows(evidence, depths, angle)
    speeds = quotient(thick.velocity, thin.velocity)
    heights = quotient(thick.value("flow_height"), thin.value("flow_height"))
    quantity = "d ln V/d ln h, {} to {} layers".format(*depths)
    return [within(quantity, log(speeds) / log(heights), power - width, power + width, places)]


def linear_profile(evidence, *, most, depth):
    """Judge the power of the profile at the least angle at which all flow, and at a steep one."""
    line = evidence.line("chute", "angle", depth=depth)
    stop = ("arrested", "mixed", "failed")
    moving = [place for place in line.values() if place.regime not in stop]
    if len(moving) < 2:
        raise Untestable(f"fewer than two angles at which {depth} layers flow")
    slow, fast = moving[0], moving[-1]
    powers = [place.value("profile_power") for place in (slow, fast)]
    gained = f"p at {fast['angle']:g}° less that at {slow['angle']:g}°"
    return [
        below(f"p at {slow['angle']:g}°", powers[0], most, [slow]),
        above(gained, powers[1] - powers[0], 0, [slow, fast]),
    ]


def two_angles(evidence, *, moving, resting, depth):
    """Judge whether a flow goes on where a bed that is tilted from rest stays."""
    flows = evidence.line("chute", "angle", depth=depth, initial_velocity=2)
    beds = evidence.line("chute", "angle", depth=depth, initial_velocity=0, start_from=ANY)
    apart = [
        angle
        for angle in sorted(flows.keys() & beds.keys())
        if flows[angle].regime != "arrested" and beds[angle].regime == "arrested"
    ]
    if not apart:
        raise Untestable("no angle at which the one flows and the other rests")
    angle = apart[-1]
    slowed, bed = flows[angle], beds[angle]
    return [
        above(f"V of the flow, {angle:g}°", slowed.velocity, moving, [slowed], "√(gd)"),
        below(f"V of the bed, {angle:g}°", bed.velocity, resting, [bed], "√(gd)"),
    ]


def largest_angle(evidence, *, angle, usual, most, depth):
    """Judge what V gains over the window, relative to V, far above the largest angle and below."""
    places = [evidence.at("chute", depth=depth, angle=one) for one in (angle, usual)]
    gains = [quotient(place.velocity_change, place.velocity) for place in places]
    return [
        above(f"relative gain of V, {angle}°", gains[0], most, places[:1]),
        within(f"relative gain of V, {usual}°", gains[1], -most, most, places[1:]),
    ]


def force_law(evidence, *, most, depth, angle):
    """Compare Hertz's spheres with linear springs."""
    return [_ratio_check("V of Hertz's over that of springs", evidence, HERTZ, most, depth, angle)]


def stiffness(evidence, *, most, depth, angle):
    """Compare stiffer spheres with the paper's."""
    return [_ratio_check("V of stiffer over that of usual", evidence, STIFF, most, depth, angle)]


def _ratio_check(quantity, evidence, spheres, most, depth, angle):
    usual = evidence.at("chute", depth=depth, angle=angle)
    other = evidence.at("chute", depth=depth, angle=angle, **spheres)
    ratio = quotient(other.velocity, usual.velocity)
    return within(quantity, ratio, 1 - most, 1 + most, [other, usual])


def packing_falls(evidence, *, least, depth):
    """Judge the trend of the packing fraction over the angles of flows that do not accelerate."""
    line = evidence.line("chute", "angle", depth=depth, initial_velocity=2)
    flows = [place for place in line.values() if place.regime in ("steady", "undetermined")]
    if len(flows) < least:
        raise Untestable(f"fewer than {least} angles with a flow that may be steady")
    packing = [place.values("bulk_packing") for place in flows]
    return [trend("φ and θ", [packing], flows, rising=False)]
