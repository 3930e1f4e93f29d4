"""How the claims of claims.yaml are judged."""

from sim.claims.inference import trend
from sim.claims.verdict import Untestable


def steeper(evidence, *, least):
    """Judge whether the mean velocity rises with the angle."""
    flows = evidence.line("chute", "angle", bumps=1, depth=4, friction=0.5, restitution=0.88)
    if len(flows) < least:
        raise Untestable(f"fewer than {least} angles on bumps")
    velocities = [place.values("velocity") for place in flows.values()]
    return [trend("V and θ", [velocities], flows.values())]
