"""Judges of claims about the shear friction coefficient."""

import pytest

from sim.claims.verdict import (
    INCONCLUSIVE,
    NOT_REPRODUCED,
    PROTOCOL_DEPENDENT,
    REPRODUCED,
    Untestable,
)
from sim.papers.gallas.judges.friction import g9, g10, g11, g12, g36
from tests.made.judging import checks_of, judgement_of, verdict_of
from tests.made.paper_belt import paper_point

SHEAR = (0, 10, 20, 50, 100)


#: Velocities (m/s) that rise fast up to 10g, and gently from there on.
GENTLE = (0.0, 0.1, 0.102, 0.105, 0.108)


def line(velocities=None, values=SHEAR, frequencies=(20, 50), **rest):
    """Return points along the shear friction coefficient, with velocities (m/s) if given."""
    scalars_by_value = (
        [None] * len(values) if velocities is None else [{"velocity": v} for v in velocities]
    )
    return [
        paper_point(scalars, frequency=frequency, shear_damping=shear, **rest)
        for frequency in frequencies
        for shear, scalars in zip(values, scalars_by_value, strict=True)
    ]


def test_fast_rise_then_gentle():
    assert verdict_of(g9, line()) == REPRODUCED
    slow = [0, 0.05, 0.06, 0.08, 0.1]
    assert verdict_of(g9, line(slow)) == NOT_REPRODUCED
    falling = [0, 0.1, 0.1, 0.095, 0.09]
    assert verdict_of(g9, line(falling)) == NOT_REPRODUCED
    assert verdict_of(g9, line(scatter=0.4)) == INCONCLUSIVE
    with pytest.raises(Untestable, match="shear_damping 20"):
        checks_of(g9, line(values=(0, 10, 50, 100)))


def drifting(protocol):
    """Return points that drift: by 12 % in 100 cycles at 20 Hz, by 5 % at 50 Hz, by 3 % at 80."""
    drift = {"acceleration": 0.0025, "acceleration_half_width": 1e-5}
    return [
        paper_point(
            {"velocity": 0.1 + shear / 1e4} | drift,
            frequency=frequency,
            shear_damping=shear,
            protocol=protocol,
        )
        for frequency in (20, 50, 80)
        for shear in SHEAR
    ]


@pytest.mark.parametrize("judge", [g9, g36])
def test_converged_velocities_that_drift_decide_nothing(judge):
    checks = checks_of(judge, drifting("converged"), protocol="converged")
    assert {check.verdict for check in checks if check.has_vote} == {INCONCLUSIVE}
    assert all("longer runs" in check.withheld for check in checks)


@pytest.mark.parametrize("judge", [g9, g36])
def test_runs_of_the_papers_length_are_judged_as_they_are(judge):
    """These drift, and show what the paper could see: the same rise at all frequencies."""
    checks = checks_of(judge, drifting("published"))
    assert not any(check.withheld for check in checks)
    assert verdict_of(judge, drifting("published")) == NOT_REPRODUCED


@pytest.mark.parametrize(("half_width", "verdict"), [(1e-6, REPRODUCED), (2e-3, INCONCLUSIVE)])
def test_converged_velocities_must_be_known_not_to_drift(half_width, verdict):
    steady = {"acceleration": 0.0, "acceleration_half_width": half_width}
    points = [
        paper_point(
            {"velocity": velocity} | steady, frequency=f, shear_damping=shear, protocol=protocol
        )
        for protocol in ("converged", "published")
        for f in (20, 50)
        for shear, velocity in zip(SHEAR, GENTLE, strict=True)
    ]
    assert verdict_of(g9, points, protocol="converged") == verdict
    assert verdict_of(g9, points) == REPRODUCED


@pytest.mark.parametrize(
    ("converged", "verdict"),
    [
        ([0, 0.1, 0.1, 0.095, 0.09], PROTOCOL_DEPENDENT),
        ([0, 0.1, 0.102, 0.105, 0.108], REPRODUCED),
    ],
)
def test_a_rise_of_short_runs_alone_depends_on_the_protocol(converged, verdict):
    """What runs of the paper's length show, converged ones contradict."""
    points = [*line(GENTLE), *line(converged, protocol="converged")]
    judgement = judgement_of("G9", points)
    assert (judgement.verdict, judgement.decided_by) == (verdict, "converged")
    assert judgement_of("G9", line(GENTLE)).verdict == REPRODUCED


def test_beads_that_do_not_move_have_no_slope():
    assert verdict_of(g9, line([0, 0.1, -0.1, 0.1, 0.1])) == INCONCLUSIVE


def still(velocities, frequencies=(20, 50)):
    """Return points without shear friction, velocities (m/s) per bed, and the usual points."""
    free = [
        paper_point({"velocity": velocities}, frequency=frequency, shear_damping=0)
        for frequency in frequencies
    ]
    return [*free, *(paper_point(frequency=frequency) for frequency in (20, 50))]


@pytest.mark.parametrize(
    ("velocities", "verdict"),
    [
        ([0.001, -0.001, 0.002, -0.002, 0.0005], REPRODUCED),
        # More beds make a small velocity no larger.
        ([0.001, 0.0011, 0.0009, 0.001, 0.001], REPRODUCED),
        ([0.05, 0.051, 0.049, 0.05, 0.05], NOT_REPRODUCED),
        ([0.05, -0.05, 0.04, -0.06, 0.02], INCONCLUSIVE),
    ],
)
def test_no_shear_friction_no_transport(velocities, verdict):
    assert verdict_of(g10, still(velocities)) == verdict


def test_no_transport_needs_runs_without_shear_friction():
    with pytest.raises(Untestable, match="frequency 50, shear_damping 0"):
        checks_of(g10, still([0.0, 0.001], frequencies=(20,)))


def scattered(ratio, **rest):
    """Return points whose relative scatter below g is ``ratio`` times that at 50g."""
    usual = line(values=(50,), scatter=0.01, **rest)
    return usual + line(values=(0.2, 0.5), scatter=0.01 * ratio, **rest)


@pytest.mark.parametrize(
    ("ratio", "verdict"), [(20, REPRODUCED), (0.8, NOT_REPRODUCED), (2, INCONCLUSIVE)]
)
def test_poor_statistics_at_small_shear_friction(ratio, verdict):
    assert verdict_of(g11, scattered(ratio)) == verdict


def test_the_scatter_of_runs_of_the_papers_length_decides():
    """A converged bed goes on until its mean is known, which makes its scatter."""
    converged = scattered(2, protocol="converged")
    judgement = judgement_of("G11", [*scattered(20), *converged])
    assert (judgement.verdict, judgement.decided_by) == (REPRODUCED, "published")
    assert judgement_of("G11", converged).decided_by == "converged"


def test_scatter_needs_several_beds():
    with pytest.raises(Untestable, match="scatter over several beds"):
        checks_of(g11, scattered(5, replicates=1))
    with pytest.raises(Untestable, match="γ_s < g"):
        checks_of(g11, line())


@pytest.mark.parametrize(
    ("velocity", "scatter", "verdict"),
    [
        (0.25, 0.001, REPRODUCED),
        (0.4, 0.001, NOT_REPRODUCED),
        (0.25, 0.2, INCONCLUSIVE),
    ],
)
def test_strong_shear_friction_hardly_matters(velocity, scatter, verdict):
    usual = paper_point({"velocity": 0.25}, frequency=80, scatter=scatter)
    strong = paper_point({"velocity": velocity}, frequency=80, shear_damping=100, scatter=scatter)
    assert verdict_of(g12, [usual, strong]) == verdict
    with pytest.raises(Untestable, match="shear_damping 100"):
        checks_of(g12, [usual])


def test_shear_friction_matters_at_small_velocities():
    values = (20, 50, 100)
    assert verdict_of(g36, line(values=values, frequencies=(20, 80))) == REPRODUCED
    slow = line([0.1, 0.1, 0.1], values, frequencies=(20,))
    fast = line([0.2, 0.25, 0.3], values, frequencies=(80,))
    assert verdict_of(g36, slow + fast) == NOT_REPRODUCED
    # A fast flow that γ_s slows is changed as well.
    falling = line([0.3, 0.25, 0.2], values, frequencies=(80,))
    assert verdict_of(g36, slow + falling) == NOT_REPRODUCED
    assert verdict_of(g36, line(values=values, frequencies=(20, 80), scatter=0.1)) == INCONCLUSIVE
    with pytest.raises(Untestable, match="frequency 80"):
        checks_of(g36, line(values=values, frequencies=(20,)))
