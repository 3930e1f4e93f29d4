"""Observables of the bulk, of made profiles whose numbers are exact."""

import numpy as np
import pytest

from sim.measures.bulk import bulk_of, mean_mass_flux
from tests.made.results import measured

SIZE, MASS, GRAVITY = 1e-3, 1.3e-6, 9.8
DENSITY = MASS / (np.pi / 6 * SIZE**3)
SLICE = 0.25 * SIZE
HEIGHT = (np.arange(120) + 0.5) * SLICE


def bagnold(layers: float, base: float = 0.0, **changes: float) -> dict:
    """Profiles of a flow with the law γ̇ = c σ_xz^n above ``base`` diameters, and its constants."""
    known = {"slope": 0.4, "rate": 0.03, "exponent": 0.5, "xx": 1.05, "yy": 0.8} | changes
    depth = (base + layers) * SIZE - HEIGHT
    is_flow = (depth > 0) & (base * SIZE < HEIGHT)
    normal = np.where(is_flow, 0.6 * DENSITY * GRAVITY * depth, np.nan)
    shear, power = known["slope"] * normal, 1 + known["exponent"]
    rate = known["rate"] * np.where(is_flow, shear, 0.0) ** known["exponent"]
    velocity = 0.02 + known["rate"] / power / (known["slope"] * 0.6 * DENSITY * GRAVITY) * (
        (known["slope"] * 0.6 * DENSITY * GRAVITY * layers * SIZE) ** power
        - np.where(is_flow, shear, 0.0) ** power
    )
    stresses = {"longitudinal": known["xx"], "transverse": known["yy"], "normal": 1.0}
    parts = {name: ratio * normal for name, ratio in stresses.items()} | {"shear": shear}
    run = {}
    # What moves carries another share of each stress.
    for share, (name, values) in zip((0.1, 0.2, 0.3, 0.05), parts.items(), strict=True):
        run[f"contact_{name}_stress_profile"] = (1 - share) * values
        run[f"kinetic_{name}_stress_profile"] = share * values
    return run | {
        "height": HEIGHT,
        "packing_profile": np.where(is_flow, 0.6, 0.0),
        "velocity_profile": np.where(is_flow, velocity, np.nan),
        "inertial_number_profile": rate * SIZE * np.sqrt(DENSITY / normal),
        "diameter": SIZE,
        "mass": MASS,
    }


@pytest.mark.parametrize("exponent", [0.4, 0.5, 1.0])
@pytest.mark.parametrize(("layers", "base"), [(10, 0), (24, 0), (16, 1.5)])
def test_numbers_of_a_flow_whose_law_is_known(layers, base, exponent):
    values = measured(bagnold(layers, base, exponent=exponent), "chute")
    assert values["flow_height"] == pytest.approx(layers * SIZE, rel=1e-9)
    assert values["bulk_packing"] == pytest.approx(0.6)
    assert values["packing_change"] == pytest.approx(0.0, abs=1e-12)
    assert values["profile_power"] == pytest.approx(1 + exponent, rel=1e-3)
    assert values["rate_exponent"] == pytest.approx(exponent)
    assert values["bulk_friction"] == pytest.approx(0.4)
    assert values["longitudinal_stress_ratio"] == pytest.approx(1.05)
    assert values["transverse_stress_ratio"] == pytest.approx(0.8)
    if exponent == 0.5:
        number = 0.03 * np.sqrt(0.4 * DENSITY) * SIZE
        assert values["bulk_inertial_number"] == pytest.approx(number)


def test_base_and_surface_do_not_bias_the_bulk():
    run = bagnold(20)
    inside = bulk_of(run).inside
    assert HEIGHT[inside][0] > 4 * SIZE and HEIGHT[inside][-1] < 16 * SIZE
    plain = {name: one for name, one in measured(run, "chute").items() if name != "shear_depth"}
    for name in [one for one in run if one.endswith("_profile") and one != "packing_profile"]:
        run[name] = np.where(inside, run[name], 7 * run[name])
    assert plain.items() <= measured(run, "chute").items()


def test_the_packing_changes_over_the_bulk_alone():
    """A fall of 0.06 from base to surface is one of six percent over three fifths of the height."""
    run = bagnold(20, 1.5)
    share = (HEIGHT / SIZE - 1.5) / 20
    inside = (share > 0.2) & (share < 0.8)
    run["packing_profile"] = np.where(inside, 0.63 - 0.06 * share, run["packing_profile"])
    assert measured(run, "chute")["packing_change"] == pytest.approx(-0.06, rel=1e-3)


def test_what_no_profile_tells_has_no_value():
    thin, plain = measured(bagnold(1.5), "chute"), bagnold(10)
    assert set(thin) == {"flow_height", "shear_depth"}
    without = {name: one for name, one in plain.items() if "stress" not in name}
    assert "bulk_friction" not in measured(without, "chute")
    at_rest = plain | {"velocity_profile": 0 * HEIGHT, "inertial_number_profile": 0 * HEIGHT}
    assert not {"profile_power", "rate_exponent"} & measured(at_rest, "chute").keys()
    plug = plain | {"velocity_profile": np.where(HEIGHT < 2.3 * SIZE, 0.0, 1.0)}
    assert "profile_power" not in measured(plug, "chute")


def test_the_flux_is_that_of_the_window():
    run = {"time": np.arange(1.0, 9.0), "average_start": 4.0}
    run["mass_flux"] = np.array([9.0, 9, 9, 9, 1, 2, 3, np.nan])
    assert mean_mass_flux(run) == 2.0
