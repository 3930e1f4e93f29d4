"""Hertz's law: exact results, its differential equations; the belt's drags."""

from math import sqrt

import numpy as np
import pytest

from sim.claims.experiments import contact_path
from sim.engine.contact import Partners, law_of
from sim.engine.contact.functions import PartnerLaw
from sim.engines.lammps.deck import contact_commands
from sim.laws.hertz import effective_modulus, force
from sim.parameters import ChuteParameters
from sim.verify.exact import pull_of_dashpot
from tests.engine.reference.hertz_impact import Friction, rebound
from tests.engine_motion.motion import Impacts

#: Of spheres with Poisson's ratio 0.3.
SHARE = 2 * (1 - 0.3) / (2 - 0.3)

SLOPES = np.tan(np.radians(np.arange(5.0, 90.0, 5.0)))

#: Radii (m) of both spheres, or of the one that meets the plane.
PARTNERS = {"plane": (0.4e-3,), "equal": (0.5e-3, 0.5e-3), "unlike": (0.3e-3, 0.8e-3)}

#: Duration of an elastic impact in the units of the reference.
LASTING = 2.94327 * (15 / 16) ** 0.4


class HertzImpacts(Impacts):
    """One impact for each slope; lengths of the reference are ``unit``.

    The centres are 1/``bend`` units apart.
    """

    def __init__(self, law: Friction, radii, slopes, steps: int, unit=1e-5):
        point = ChuteParameters(
            law="hertz",
            restitution=law.restitution,
            tangential_ratio=law.share,
            attraction="clipped" if law.clipped else "kept",
            tangential_unloading="rescaled" if law.rescaled else "kept",
        )
        mass = point.mass * (2 * np.array(radii) / point.diameter) ** 3
        reduced = 1 / sum(1 / mass)
        stiffness = effective_modulus(point) * sqrt(1 / sum(1 / np.array(radii)))
        self.bend = unit / sum(radii) if len(radii) == 2 else 0.0
        self.speed = speed = sqrt(unit**2.5 * stiffness / reduced)
        self.steps, self.slopes = steps, np.array(slopes, float)
        time_step = LASTING * unit / speed / steps
        made = law_of(point, Partners(law.friction, reduced, time_step))
        speeds = np.full(len(slopes), speed)
        super().__init__(made, radii, mass, time_step, speeds, speed * self.slopes)

    def run(self, durations: float = 1.25) -> "HertzImpacts":
        """Run for so many durations of an elastic impact, until all have parted."""
        return super().run(round(durations * self.steps))

    def velocities(self) -> np.ndarray:
        """Return the velocities over the speed."""
        return super().velocities() / self.speed

    def expected(self, law: Friction) -> np.ndarray:
        """Return the velocities that the reference gives, as `velocities` does."""
        shared = 1 / self.mass / sum(1 / self.mass)
        rows = []
        for slope in self.slopes:
            parting, across, rims, turn = rebound(law, slope, self.bend)
            c, s = np.cos(turn), np.sin(turn)
            rows.append([parting * c - across * s, across * c + parting * s, *(rims * shared)])
        return np.array(rows)


def impacts(law: Friction, partners="plane", slopes=SLOPES, steps=400, **options) -> HertzImpacts:
    return HertzImpacts(law, PARTNERS[partners], slopes, steps, **options).run()


@pytest.mark.parametrize("partners", PARTNERS)
@pytest.mark.parametrize("options", [(0.8,), (1.0, False, True), (0.6, True, True)])
def test_rebounds_approach_those_of_the_differential_equations(partners, options):
    """From sticking to sliding throughout: an error of first order, without which none is left."""
    law = Friction(SHARE, 0.3, *options)
    coarse, fine = (impacts(law, partners, steps=steps) for steps in (400, 800))
    expected = fine.expected(law)
    assert np.abs(coarse.velocities() - expected).max() < 2e-3
    assert np.abs(2 * fine.velocities() - coarse.velocities() - expected).max() < 3e-4


@pytest.mark.parametrize("share", [2 / 7, SHARE])
def test_sliding_lasts_from_the_angle_of_maw_barber_and_fawcett_on(share):
    """From ψ₁ = 4χ - 1 on, where ψ₁ is share · slope/μ and χ is 7/4 of the share of a sphere."""
    friction, critical = 0.3, 7 * share - 1
    angles = critical * np.array([0.95, 1.01, 1.1])
    slopes = angles * friction / share
    parting, across, _ = impacts(Friction(share, friction), slopes=slopes).velocities().T
    friction_share = (slopes - across) / (friction * (1 + parting))
    assert friction_share[0] < 0.997
    np.testing.assert_allclose(friction_share[1:], 1.0, rtol=1e-9)


def held_shear(law, overlaps, slips) -> tuple[np.ndarray, float]:
    """Return tangential forces (n,), and the work against them, along overlaps and slips (n,)."""
    overlap = np.array(overlaps)
    slip = np.zeros((overlap.size, 3))
    slip[:, 0] = slips
    tangential = contact_path(law, overlap, np.tile([0.0, 0, 1], (overlap.size, 1)), slip)[1][:, 0]
    mean = 0.5 * (tangential + np.concatenate([[0.0], tangential[:-1]]))
    return tangential, float(mean @ slip[:, 0])


@pytest.mark.parametrize("unloading", ["kept", "rescaled"])
@pytest.mark.parametrize("sheared_at", ["deep", "shallow"])
def test_a_closed_cycle_of_shear_and_load_has_its_exact_work(sheared_at, unloading):
    """Shear by s at one overlap, back at another: ± ½ (k - k') s² with the stiffnesses there."""
    point = ChuteParameters(law="hertz", restitution=1, tangential_unloading=unloading)
    made = law_of(point, Partners(50.0, 0.5 * point.mass, point.time_step))
    law = PartnerLaw(made, 0.25 * point.diameter, 0.5 * point.mass)
    deep, shallow, steps, s = 1e-5, 0.36e-5, 1000, 1e-7
    first, second = (deep, shallow) if sheared_at == "deep" else (shallow, deep)
    change, still = np.linspace(first, second, steps), np.zeros(steps)
    shear, ones = np.full(steps, s / steps), np.ones(steps)
    overlaps = np.concatenate([[first], first * ones, change, second * ones])
    tangential, work = held_shear(law, overlaps, np.concatenate([[0.0], shear, still, -shear]))
    k, other = (
        made.tangential * 2 * made.modulus * sqrt(0.25 * point.diameter * overlap)
        for overlap in (first, second)
    )
    held = k * min(1.0, other / k) if unloading == "rescaled" else k
    assert tangential[[steps, 2 * steps, -1]] == pytest.approx(
        [k * s, held * s, (held - other) * s], rel=1e-9, abs=1e-9 * k * s
    )
    assert work == pytest.approx(0.5 * (k - 2 * held + other) * s**2, rel=1e-9)
    assert (work > 0) == (sheared_at == "shallow" or unloading == "rescaled")


def test_hertz_at_a_hundredth_of_a_diameter_is_the_spring():
    point = ChuteParameters(law="hertz")
    law = law_of(point, Partners(0.4, 0.5 * point.mass, point.time_step))
    overlap, radius, zero = point.diameter / 100, point.diameter / 4, (0.0, 0.0, 0.0)
    normal = force(law, overlap, 0.0, zero, zero, (0.0,) * 4, radius, point.mass)[0]
    assert normal == pytest.approx(point.stiffness * overlap)
    assert law.modulus == effective_modulus(point)


def test_hertz_of_a_material_is_that_of_the_stiffness_that_it_has():
    """E* = E/(2 (1 - ν²)), and Mindlin's 2 (1 - ν)/(2 - ν) along the surfaces; LAMMPS is told E."""
    young, nu = 2e6, 0.2
    of_material = ChuteParameters(law="hertz", youngs_modulus=young, poisson_ratio=nu)
    modulus, share = young / (2 * (1 - nu**2)), 2 * (1 - nu) / (2 - nu)
    stiffness = 4 / 3 * modulus * (of_material.diameter / 4 * of_material.diameter / 100) ** 0.5
    given = ChuteParameters(law="hertz", stiffness=stiffness, tangential_ratio=share)
    partners = Partners(0.4, 0.5 * given.mass, 1e-6)
    made = [law_of(point, partners) for point in (of_material, given)]
    assert made[0] == pytest.approx(made[1], rel=1e-11) and made[0].modulus == pytest.approx(
        modulus
    )
    assert of_material.time_step == pytest.approx(given.time_step, rel=1e-11)
    told = contact_commands(of_material)[1].split()
    assert [float(told[k]) for k in (2, 4)] == pytest.approx([young, nu])


@pytest.mark.parametrize(
    ("law", "attraction"),
    [
        *(("hertz", "kept"), ("hertz", "clipped"), ("spring_dashpot", "kept")),
        pytest.param("spring_dashpot", "clipped", marks=pytest.mark.long),
    ],
)
def test_a_dashpot_that_pulls_rubs_as_much_as_its_closed_form_says(law, attraction):
    """Share by which an impact that slides gives more than μ (1 + e): 2 (e_c - e)/(1 + e).

    e_c is the restitution where the force of this damping is clipped.
    """
    for restitution in (0.9, 0.2):
        point = ChuteParameters(
            law=law, restitution=restitution, attraction=attraction, steps_per_collision=400
        )
        radius, mass = 0.5 * point.diameter, point.mass
        made = law_of(point, Partners(0.05, mass, point.time_step))
        speeds = np.array([0.01, 0.02])
        slides = 20 * speeds
        one = Impacts(made, [radius], [mass], point.time_step, speeds, slides=slides)
        parting, across, _ = one.run_until_parted().velocities().T
        excess = (slides - across) / (0.05 * (speeds + parting)) - 1
        expected = pull_of_dashpot(restitution) if attraction == "kept" else 0
        np.testing.assert_allclose(excess, expected, atol=4e-3)


def test_the_shear_drag_stops_a_slip_exponentially():
    """Two equal solid spheres lose their slip at the rate (7/2) γ_s while they touch."""
    point = ChuteParameters(law="drag", restitution=0.9, steps_per_collision=400, shear_damping=20)
    law = law_of(point, Partners(0.4, 0.5 * point.mass, point.time_step))
    radii, mass = [0.5 * point.diameter] * 2, [point.mass] * 2
    made, steps = Impacts(law, radii, mass, point.time_step, 0.002, 0.001), 0
    made.motion.run(1)
    while not steps or made.touching:
        made.motion.run(1)
        steps += 1
    slowing = np.exp(-3.5 * 20 * point.gravity * (steps - 1) * point.time_step)
    assert made.slips() == pytest.approx(0.001 * slowing, rel=0.01)
