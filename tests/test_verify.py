"""The field's own tests as Talus ships them, and `talus.impact`, by which most of them are made."""

import numpy as np
import pytest
import xarray as xr

import sim
from sim.__main__ import main
from sim.verify import command
from sim.verify.exact import hertz_impact
from tests.made.processes import ROOT, refusal

#: Rows of seconds.
CHEAP = ("chung_ooi_2", "chung_ooi_4", "mfix_dem04", "lammps_formulas")

#: Where the site has the page and the picture from.
PUBLISHED = ROOT / "benchmarks" / "verify"


@pytest.mark.parametrize("name", CHEAP)
def test_cheap_rows_hold(name):
    checks = command.checks_of(name)
    assert all(check.holds for check in checks), [check.cells for check in checks]


@pytest.mark.long
def test_all_rows_hold_and_are_the_published_page(tmp_path, capsys):
    assert main(["verify", "-o", str(tmp_path)]) == 0
    assert capsys.readouterr().out.splitlines()[-1].endswith("checks of 10 tests hold")
    for suffix in (".svg", ".png"):
        assert (tmp_path / f"{command.PICTURE}{suffix}").stat().st_size > 10_000
    rows = [
        [
            line
            for line in (folder / command.PAGE).read_text("utf-8").splitlines()
            if line[:3] == "##"
        ]
        for folder in (tmp_path, PUBLISHED)
    ]
    assert rows[0] == rows[1]


def test_each_row_has_its_source_and_each_tolerance_a_reason():
    told = command.references()
    assert list(told) == list(command.ROWS) and len(told) == 10
    for row in told.values():
        assert all(row[key] for key in ("test", "source", "exact", "command", "why"))
        assert all(0 < check["within"] < 100 and check["is"] for check in row["checks"].values())
    page = (PUBLISHED / command.PAGE).read_text("utf-8")
    assert all(f"## {row['test']}\n" in page for row in told.values()) and "✗" not in page


@pytest.mark.parametrize(("talus", "code"), [(2 / 7, 0), (2 / 7 * (1 + 2e-8), 1), (np.nan, 1)])
def test_a_wrong_number_fails(talus, code, monkeypatch, capsys):
    found = {"end": (talus, 2 / 7), "rolling": (5 / 7, 5 / 7)}
    monkeypatch.setitem(command.ROWS, "mfix_dem04", lambda **_: found)
    assert main(["verify", "mfix_dem04"]) == code
    out = capsys.readouterr().out
    assert ("✗" in out) == bool(code) and "MFiX 0.285933" in out
    assert out.splitlines()[-1] == f"{2 - code} of 2 checks of 1 tests hold"


def test_without_lammps_its_stored_digits_stand_in():
    given = command.references()["lammps_impacts"]["given"]
    assert given["stored"].keys() == given["oblique"].keys()


def test_a_row_that_is_not_there_is_refused(capsys):
    assert "verify: ROW: got 'mfix_dem2'; did you mean mfix_dem02?" in refusal(
        capsys, "verify", "mfix_dem2"
    )


def test_an_impact_has_dimensions_units_and_the_impulse_of_its_forces():
    speed = xr.DataArray([0.1, 0.4], dims="case")
    angle, spin = speed * 0 + [0.0, 40.0], [0.0, 50.0]
    mass, law = 2e-6, "spring_dashpot"
    met = sim.impact(law, speed=speed, angle=angle, spin=spin, mass=mass, restitution=0.7)
    assert met.normal_restitution.dims == ("case", "spin") and met.overlap.dims[2] == "step"
    assert all({"units", "long_name"} <= {*one.attrs} for one in met.variables.values())
    assert np.isnan(met.tangential_restitution[0]).all() and "partner_spin" not in met
    step = met.time.diff("step").median()
    speeds = speed * np.cos(np.radians(angle)), speed * np.sin(np.radians(angle))
    pushed = (met.normal_force.sum("step") * step / mass).transpose("case", "spin")
    rubbed = (met.tangential_force.sum("step") * step / mass).transpose("case", "spin")
    np.testing.assert_allclose(pushed, speeds[0] + met.normal_velocity, rtol=1e-9)
    np.testing.assert_allclose(rubbed, met.tangential_velocity - speeds[1], atol=1e-9)
    turned = (met.rebound_spin - met.spin) * 0.4 * 0.5e-3
    np.testing.assert_allclose(turned, -rubbed, atol=1e-9)
    np.testing.assert_allclose(
        met.surface_velocity, met.tangential_velocity - 0.5e-3 * met.rebound_spin, atol=1e-12
    )


def test_spheres_share_what_an_impact_gives():
    hard = {"restitution": 1, "stiffness": 1e6}  # so short that the contact hardly turns
    met = sim.impact("hertz", speed=0.2, angle=50, spin=20, partner="sphere", **hard)
    assert met.rebound_spin - 20 == pytest.approx(float(met.partner_spin))
    point = sim.Flow("chute", law="hertz", **hard).parameters
    modulus, radius = 15 * point.stiffness / point.diameter, point.diameter / 4
    exact = hertz_impact(point.mass / 2, modulus, radius, 0.2 * np.cos(np.radians(50)))
    for name, value in exact.items():
        found = met[name if name == "duration" else f"largest_{name}"]
        assert float(found) == pytest.approx(value, rel=5e-3)


def test_partners_that_do_not_part_have_no_duration():
    met = sim.impact("walton_braun", speed=[1e-9, 0.1], restitution=0.001, steps_per_collision=10)
    assert np.isfinite(met.normal_velocity).all() and np.isfinite(met.duration[1])


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"speed": 0}, "impact: speed: got 0; allowed: a number or an array of them, > 0"),
        ({"speed": "fast"}, "impact: speed: got 'fast'; allowed: a number or an array"),
        ({"speed": 1, "angle": [0, 90]}, "impact: angle: got [0, 90]; allowed: "),
        ({"speed": 1, "spin": np.inf}, "impact: spin: got inf; allowed: "),
        ({"speed": 1, "partner": "wall"}, "impact: partner: got 'wall'; allowed: plane or sphere"),
        ({"speed": 1, "restitution": 3}, "impact: restitution: got 3; allowed: a number in "),
    ],
)
def test_impacts_that_cannot_be_are_one_line(given, message):
    with pytest.raises(sim.InputError) as raised:
        sim.impact("hertz", **given)
    assert str(raised.value).startswith(message)
