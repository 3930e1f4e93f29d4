"""Order of the integrators of the beads on smooth problems, and changes of the time step."""

from math import factorial

import numpy as np
import pytest

from sim.engine.dynamics.disks import CORRECTORS, TERMS, Gear, Verlet, rescale_terms
from tests.engine.reference.integrators import GEAR_COEFFICIENTS
from tests.engine_motion.helpers import Oscillator, damped_oscillation, flushed, gear

RATE, END = 0.3, 10.0
OSCILLATOR = Oscillator(1.0, 2 * RATE)


def derivatives(time: float) -> np.ndarray:
    """Position of x'' = -x - 2 RATE x', x(0) = 1, x'(0) = 0, and its first five derivatives."""
    root = complex(-RATE, np.sqrt(1 - RATE**2))
    weight = -root.conjugate() / (root - root.conjugate())
    return np.array([2 * (weight * root**k * np.exp(root * time)).real for k in range(TERMS)])


def oscillate(integrator, steps: int, known_terms: int = TERMS, corrections: int = 1):
    """Taylor terms (6,) at END from an exact start that knows some derivatives."""
    step = END / steps
    scale = np.array([step**k / factorial(k) for k in range(TERMS)])
    taylor = np.zeros((TERMS, 2, 1))
    taylor[:known_terms, :, 0] = (derivatives(0.0) * scale)[:known_terms, None]
    damped_oscillation(integrator(step), taylor, OSCILLATOR, steps, corrections)
    return taylor[:, 0, 0] / scale


def orders(integrator, known_terms: int = TERMS, corrections: int = 1) -> np.ndarray:
    """Observed orders of position and velocity between 200, 400 and 800 steps."""
    exact = derivatives(END)[:2]
    errors = [
        oscillate(integrator, steps, known_terms, corrections)[:2] - exact
        for steps in (200, 400, 800)
    ]
    return np.log2(np.abs(np.array(errors[:-1]) / np.array(errors[1:])))


@pytest.mark.parametrize("corrections", [1, 2])
@pytest.mark.parametrize("order", CORRECTORS)
def test_gear_is_of_the_order_that_it_says(order, corrections):
    assert orders(gear(order), order + 1, corrections).min() == pytest.approx(order, abs=0.2)
    assert not oscillate(gear(order), 50, order + 1)[order + 1 :].any()


def test_gear_started_from_the_acceleration_alone_is_of_second_order_or_better():
    assert orders(Gear, known_terms=3).min() > 1.9


def test_verlet_is_of_second_order_without_damping_and_stays_so_with_it():
    """The damping sees a predicted velocity, with an error of second order in the acceleration."""
    assert orders(Verlet).min() > 1.8
    assert abs(oscillate(Verlet, 800)[0] - derivatives(END)[0]) < 1e-4


@pytest.mark.parametrize("order", GEAR_COEFFICIENTS)
def test_corrector_coefficients_are_those_for_forces_that_depend_on_the_velocity(order):
    padded_coefficients = (*GEAR_COEFFICIENTS[order], *[0.0] * (TERMS - order - 1))
    assert CORRECTORS[order] == pytest.approx(padded_coefficients, rel=1e-15)


@pytest.mark.parametrize("integrator", [Gear, Verlet])
def test_a_new_time_step_goes_on_along_the_same_motion(integrator):
    """Half the way with one step, half with another three times as long."""
    short, long = END / 6000, END / 2000
    scale = np.array([short**k / factorial(k) for k in range(TERMS)])
    taylor = np.zeros((TERMS, 2, 1))
    taylor[:, :, 0] = (derivatives(0.0) * scale)[:, None]
    damped_oscillation(integrator(short), taylor, OSCILLATOR, 3000)
    before = taylor[:3, 0, 0] / [1.0, short, short**2]
    rescale_terms(taylor, short, long)
    assert taylor[:3, 0, 0] / [1.0, long, long**2] == pytest.approx(before, rel=1e-12)
    damped_oscillation(integrator(long), taylor, OSCILLATOR, 1000)
    assert taylor[0, 0, 0] == pytest.approx(derivatives(END)[0], abs=2e-5)


def test_flush_takes_subnormal_terms_only():
    taylor = np.full((TERMS, 2, 3), 1e-150)
    taylor[:, :, 1] = 1e-310
    flushed(taylor)
    assert (taylor[2:, :, 1] == 0.0).all() and (taylor[:2, :, 1] > 0.0).all()
    assert (taylor[:, :, [0, 2]] == 1e-150).all()
