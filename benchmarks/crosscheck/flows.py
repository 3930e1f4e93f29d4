"""The flows that both engines run."""

from dataclasses import dataclass, replace

from sim.parameters import ChuteParameters, parse_point

#: Blocks that the averaging of each replicate is cut into.
BLOCKS = 6

#: What `quick` divides the averaging by, and how many replicates it leaves.
QUICK_SHARE, QUICK_REPLICATES = 4, 2


@dataclass(frozen=True)
class Flow:
    """One flow: its point, the times (√(σ/g)) discarded and averaged, and its replicates."""

    name: str
    point: dict
    transient: float
    average: float
    replicates: int

    def parameters(self) -> ChuteParameters:
        """Return the validated point."""
        shared = {"system": "chute", "law": "spring_dashpot", "tangential_ratio": 2 / 7}
        lengths = {"transient": self.transient, "average": self.average}
        return parse_point(shared | lengths | {"orientations": False} | self.point, self.name)

    def quick(self) -> "Flow":
        """Return the flow with less averaging and fewer replicates."""
        return replace(self, average=self.average / QUICK_SHARE, replicates=QUICK_REPLICATES)


def _flow(name, depth, transient, average, replicates, **point) -> Flow:
    """Return a flow of softness K* = Kσ/mg = 8·10³ (117 N/m) unless it says otherwise."""
    return Flow(name, {"depth": depth, "stiffness": 117} | point, transient, average, replicates)


#: Depths at e = 0.85 and μ = 0.4, then variations of the middle one.
FLOWS = [
    _flow("n = 2.5", 2.5, 100, 300, 4),
    _flow("n = 5", 5, 150, 250, 4),
    _flow("n = 10", 10, 400, 600, 4),
    _flow("e = 0.7", 5, 150, 250, 4, restitution=0.7),
    _flow("e = 0.95", 5, 150, 250, 4, restitution=0.95),
    _flow("μ = 0.35", 5, 150, 250, 4, friction=0.35),
    _flow("μ = 0.5", 5, 150, 250, 4, friction=0.5),
    _flow("K* = 8·10⁴", 5, 150, 150, 4, stiffness=1170),
]

#: The flows whose profiles are drawn.
DEPTHS = FLOWS[:3]
