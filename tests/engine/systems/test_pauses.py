"""Whatever takes long has pauses, in which a process can be told to end."""

import pytest

from sim.engine.systems import build, replica
from tests.engine_motion.points import belt_point, chute_point

POINTS = [
    belt_point(beads=20, width=5, prior_frequency=30, prior_cycles=2),
    chute_point(depth=2, cell=4),
]


@pytest.mark.parametrize("point", POINTS, ids=lambda point: point.system)
def test_no_more_than_some_steps_lie_between_two_pauses(point, monkeypatch):
    most = point.particles * point.sample_steps // 3
    monkeypatch.setattr(replica, "MOST_WORK", most)
    system, runs = build(point, 0), []
    advance = system._advance

    def advanced(steps):
        runs.append(steps)
        return advance(steps)

    monkeypatch.setattr(system, "_advance", advanced)
    system.pause = lambda: runs.append(None)
    for act in (system.settle, system.advance, system.trace):
        runs.clear()
        act()
        stretches = [steps for steps in runs if steps is not None]
        assert all(0 < steps * point.particles <= most for steps in stretches)
        assert act == system.settle or None in runs
