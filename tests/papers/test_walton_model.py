"""Experiments on the model: they pass on the engine and fail on wrong laws and systems."""

from functools import partial

import numpy as np
import pytest

from sim.claims.evidence import readings_of
from sim.claims.experiments import contact_path
from sim.claims.verdict import NOT_REPRODUCED, REPRODUCED, combined_verdict
from sim.engine.boundary.drive import Gravity
from sim.engine.contact.walton_braun import walton_braun
from sim.engine.systems.chute import Chute
from sim.papers.walton.judges import model
from tests.engine_motion.helpers import LAWS
from tests.made.results import failed_quantities, headline_bounds

#: Judges with their bounds.
w1, w2, w3, w4 = (
    partial(judge, **headline_bounds(judge)) for judge in (model.w1, model.w2, model.w3, model.w4)
)


@pytest.mark.parametrize("judge", [w1, w2, w3, w4])
def test_the_engine_is_as_the_paper_says(judge):
    checks = judge()
    assert combined_verdict(checks) == REPRODUCED, failed_quantities(checks)


@pytest.mark.long
@pytest.mark.parametrize("reading", readings_of("chute").model[1:])
def test_under_other_readings_the_model_is_judged_as_published(reading):
    judges = {"w1": w1, "w2": w2, "w3": w3, "w4": w4}
    verdicts = {name: combined_verdict(judge(reading)) for name, judge in judges.items()}
    reset = reading.get("overlap_memory") == "reset"
    expected = dict.fromkeys(verdicts, REPRODUCED) | ({"w1": NOT_REPRODUCED} if reset else {})
    assert verdicts == expected


def test_a_reading_reaches_the_engine():
    """The reading `reset` returns more energy than the paper's law."""
    assert combined_verdict(w1(LAWS[2])) == NOT_REPRODUCED
    assert combined_verdict(w1(LAWS[1])) == combined_verdict(w4(LAWS[1])) == REPRODUCED


def test_a_restitution_off_by_little_more_than_a_thousandth_is_found_whatever_the_partner():
    def elastic(chute):
        p = chute.parameters
        chute.laws = (walton_braun(p.stiffness, 1.002 * p.restitution, p.friction),) * 2

    assert [quantity.split(", ")[-1] for quantity in failed_quantities(w1(change=elastic))] == [
        "pairs",
        "plane",
    ]


def test_a_restitution_that_depends_on_the_speed_is_found():
    """Weight speeds slow spheres up on their way to the plane, and leaves pairs alone."""

    def heavy(chute):
        chute.drive = Gravity((0.0, 0.0, -0.1))

    quantities = failed_quantities(w1(change=heavy))
    assert "change of e over three decades of speed, plane" in quantities
    assert not any("pairs" in quantity for quantity in quantities)


def linear(law, *contact):
    """Return the contact with a stiffness that does not fall."""
    exponent = law.stiffening.exponent and 0.0
    law = walton_braun(law.loading, 0.85, law.limit.friction, tangential_exponent=exponent)
    return contact_path(law, *contact)


def kinked(law, overlap, normal, slip):
    """Return friction that is a tenth softer where it has reversed: a corner at zero."""
    force, friction, memory = contact_path(law, overlap, normal, slip)
    return force, np.where(friction < 0, 0.9 * friction, friction), memory


def drifting(law, overlap, normal, slip):
    """Return friction that decays a little with every step."""
    force, friction, memory = contact_path(law, overlap, normal, slip)
    return force, friction * (1 - 5e-7 * np.arange(len(friction)))[:, None], memory


def test_a_stiffness_that_does_not_fall_is_found():
    assert any("(1 - T/μF_N)^γ" in quantity for quantity in failed_quantities(w2(path=linear)))


def test_a_loop_with_a_corner_is_found():
    assert any("jump" in quantity for quantity in failed_quantities(w2(path=kinked)))


def test_a_loop_that_does_not_close_is_found():
    assert any("opening" in quantity for quantity in failed_quantities(w2(path=drifting)))


@pytest.mark.parametrize("path", [kinked, drifting])
def test_a_friction_that_is_not_the_linear_spring_is_found(path):
    assert len(failed_quantities(w3(path=path))) >= 1


def test_a_flow_that_feels_its_orientations_is_found():
    class Turned(Chute):
        def __init__(self, parameters, replicate):
            super().__init__(parameters, replicate)
            if parameters.orientations:
                self.spheres.velocity[0, 0] *= 1 + 1e-14

    assert failed_quantities(w4(chute=Turned)) == ["numbers of the last state that differ"]
