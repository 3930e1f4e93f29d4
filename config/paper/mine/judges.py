"""How the claims of claims.yaml are judged, from the runs of a study."""

from talus.claims import Untestable, trend


def steeper(evidence, *, least):
    """Judge whether the mean velocity of steady flows rises with the angle."""
    line = evidence.line("chute", "angle")  # all else at the paper's values
    flows = {angle: flow for angle, flow in line.items() if flow.regime == "steady"}
    if len(flows) < least:
        raise Untestable(f"fewer than {least} angles with a steady flow")
    velocities = [flow.values("velocity") for flow in flows.values()]
    return [trend("V and θ", [velocities], flows.values())]
