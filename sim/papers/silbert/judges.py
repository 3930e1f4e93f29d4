"""How the claims of claims.yaml are judged. Lengths are in diameters, velocities in √(gd)."""

import numpy as np
from uncertainties.umath import log

from talus.claims import Untestable, above, below, quotient, trend, within

#: Spheres ten times as stiff as the paper's, of their restitution, and what has it by Hertz's law.
STIFF = {"stiffness": 2000000, "normal_damping": 158.114}
HERTZ = {"law": "hertz", "restitution": 0.883}

#: Shares of the height between which a flow has neither base nor surface.
BULK = (0.2, 0.8)

#: Angle far above that of repose, at which most of the claims are judged.
STEEP = 26


def flow(evidence, depth, angle=STEEP):
    """Return the flow of the paper's spheres."""
    return evidence.at("chute", depth=depth, angle=angle)


def constant_density(evidence, *, most, angles, depth):
    """Compare the packing fraction at the bottom and the top of the bulk."""
    return [_packing_check(flow(evidence, depth, angle), most) for angle in angles]


def _packing_check(place, most):
    low, high = (share * place.value("flow_height").nominal_value for share in BULK)

    def change(height, packing):
        inside = (height > low) & (height < high)
        slope = np.polyfit(height[inside], packing[inside], 1)[0]
        return slope * (high - low) / packing[inside].mean()

    measured = place.measure(change, "packing_profile")
    quantity = f"relative change of φ over the bulk, {place['angle']:g}°"
    return within(quantity, measured, -most, most, [place])


def bagnold_profile(evidence, *, power, width, depths):
    """Judge the power of the velocity profile."""
    return _power_checks(evidence, "p", "profile_power", power, width, depths)


def bagnold_rheology(evidence, *, power, width, depths):
    """Judge the slope of ln γ̇ over ln σ_xz in the bulk."""
    return _power_checks(evidence, "d ln γ̇/d ln σ_xz", "rate_exponent", power, width, depths)


def _power_checks(evidence, quantity, observable, power, width, depths):
    low, high = power - width, power + width
    places = {f"{quantity}, {depth} layers": flow(evidence, depth) for depth in depths}
    return [within(one, at.value(observable), low, high, [at]) for one, at in places.items()]


def height_scaling(evidence, *, power, width, depths):
    """Judge the slope of ln V over ln h between two flows."""
    thin, thick = places = [flow(evidence, depth) for depth in depths]
    speeds = quotient(thick.velocity, thin.velocity)
    heights = quotient(thick.value("flow_height"), thin.value("flow_height"))
    quantity = "d ln V/d ln h, {} to {} layers".format(*depths)
    return [within(quantity, log(speeds) / log(heights), power - width, power + width, places)]


def linear_profile(evidence, *, most, depth):
    """Judge the power of the profile at the least angle of a flow, and that of a steep one."""
    line = evidence.line("chute", "angle", depth=depth)
    moving = [place for place in line.values() if place.regime not in ("arrested", "failed")]
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
    beds = evidence.line("chute", "angle", depth=depth, initial_velocity=0)
    apart = [
        angle
        for angle in sorted(flows.keys() & beds.keys())
        if flows[angle].regime != "arrested" and beds[angle].regime == "arrested"
    ]
    if not apart:
        raise Untestable("no angle at which the one flows and the other rests")
    angle = apart[0]
    slowed, bed = flows[angle], beds[angle]
    return [
        above(f"V of the flow, {angle:g}°", slowed.velocity, moving, [slowed], "√(gd)"),
        below(f"V of the bed, {angle:g}°", bed.velocity, resting, [bed], "√(gd)"),
    ]


def largest_angle(evidence, *, angle, most, depth):
    """Judge what V gains over the window, relative to V, far above the largest angle and below."""
    places = [flow(evidence, depth, one) for one in (angle, STEEP)]
    gains = [quotient(place.velocity_change, place.velocity) for place in places]
    return [
        above(f"relative gain of V, {angle}°", gains[0], most, places[:1]),
        within(f"relative gain of V, {STEEP}°", gains[1], -most, most, places[1:]),
    ]


def force_law(evidence, *, most, depth):
    """Compare Hertz's spheres with linear springs."""
    hertz = evidence.at("chute", depth=depth, angle=STEEP, **HERTZ)
    return [_ratio_check("V of Hertz's over that of springs", hertz, flow(evidence, depth), most)]


def stiffness(evidence, *, most, depth):
    """Compare stiffer spheres with the paper's."""
    stiff = evidence.at("chute", depth=depth, angle=STEEP, **STIFF)
    return [
        _ratio_check("V of stiffer over that of the paper's", stiff, flow(evidence, depth), most)
    ]


def _ratio_check(quantity, one, other, most):
    ratio = quotient(one.velocity, other.velocity)
    return within(quantity, ratio, 1 - most, 1 + most, [one, other])


def packing_falls(evidence, *, least, depth):
    """Judge the trend of the packing fraction over the angles of flows that do not accelerate."""
    line = evidence.line("chute", "angle", depth=depth, initial_velocity=2)
    flows = [place for place in line.values() if place.regime in ("steady", "undetermined")]
    if len(flows) < least:
        raise Untestable(f"fewer than {least} angles with a flow that may be steady")
    packing = [place.values("bulk_packing") for place in flows]
    return [trend("φ and θ", [packing], flows, rising=False)]
