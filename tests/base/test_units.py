"""Units as people write them, and how many of one another makes."""

from math import pi

import pytest

from sim.base.messages import conversion


@pytest.mark.parametrize(
    ("unit", "to", "factor"),
    [
        ("mm/s", "m s-1", 1e-3),
        ("cm s^-1", "m s-1", 1e-2),
        ("m·s⁻¹", "m s-1", 1),
        ("g/cm³", "kg m-3", 1e3),
        ("kg/(m s)", "Pa s", 1),
        ("kPa", "Pa", 1e3),
        ("1/s", "Hz", 1),
        ("min", "s", 60),
        ("°", "degree", 1),
        ("rad", "degree", 180 / pi),
        ("%", "1", 0.01),
        ("µm", "m", 1e-6),
        ("N/m", "N m-1", 1),
        ("W m-3", "kg m-1 s-3", 1),
    ],
)
def test_a_unit_makes_so_many_of_another(unit, to, factor):
    assert conversion(unit, to) == pytest.approx(factor, rel=1e-12)


@pytest.mark.parametrize("unit", ["furlong", "m/", "", "kg", "m s", "m^x", "mmin", "/s"])
def test_an_unknown_unit_or_one_of_another_kind_makes_none(unit):
    assert conversion(unit, "m s-1") is None
