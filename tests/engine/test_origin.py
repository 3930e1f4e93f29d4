"""Runs that start from the final states of another."""

from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from sim.base.errors import InputError
from sim.engine.run import run_point
from sim.engine.states import States, pack, unpack
from sim.parameters import Parameters, parse_point, point_id
from sim.study.load import parse_study
from tests.engine_motion.points import belt_point, chute_point
from tests.golden import digest

CHUTE = chute_point(depth=2, cell=5, transient=2, average=4, replicates=2, stress_profiles=True)
FAILING = parse_point(CHUTE.model_dump() | {"overlap_limit": 1e-6}, "point")
BELT = belt_point(beads=20, width=5, transient=1, average=3, replicates=2)


def run(folder: Path, point: Parameters, **changes) -> Path:
    """Run a point with some changes into a folder, under its id."""
    changed = parse_point(point.model_dump() | changes, "point")
    folder.mkdir(exist_ok=True)
    path = folder / f"{point_id(changed)}.nc"
    assert run_point(changed, path, quiet=True) == 0
    return path


def with_start(folder: Path, point: Parameters, **changes) -> tuple[xr.Dataset, xr.Dataset]:
    """Return a run, and one that starts from its end with some changes."""
    first = run(folder, point)
    then = run(folder, point, start_from=first.stem, **changes)
    return xr.load_dataset(first), xr.load_dataset(then)


@pytest.mark.parametrize(("point", "exact"), [(CHUTE, 0.0), (BELT, 1e-6)])
def test_what_changes_nothing_goes_on_as_if_it_had_not_ended(point, exact, tmp_path):
    """The flow with the same bits; a belt's phase is rounded otherwise in its first cycle."""
    one, two = with_start(tmp_path, point)
    longer = 2 * point.average + point.transient
    whole = xr.load_dataset(run(tmp_path / "whole", point, average=longer))
    for name in ("mean_velocity", "kinetic_energy", "height_of_mass", "contact_number"):
        joined = np.concatenate([one[name], two[name]], axis=1)
        last = one.sizes["time"] + 5 if exact else None
        expected = whole[name].values[:, :last]
        assert joined[:, :last] == pytest.approx(expected, rel=exact, abs=0), name
    assert abs(two["energy_residual"]).max() < 0.01


def test_a_flow_goes_on_under_another_angle_and_friction_without_a_jump(tmp_path):
    one, two = with_start(tmp_path, CHUTE, angle=24.0, friction=0.3)
    end, start = one["mean_velocity"].values[:, -1], two["mean_velocity"].values[:, 0]
    assert start == pytest.approx(end, rel=0.05)
    assert float(two["acceleration"].mean()) > float(one["acceleration"].mean())
    assert two.attrs["point_id"] != one.attrs["point_id"]


def test_a_bed_is_shaken_on_at_another_frequency(tmp_path):
    one, two = with_start(tmp_path, BELT, frequency=40.0)
    for name in ("height_of_mass", "mean_velocity"):
        end, start = one[name].values[:, -1], two[name].values[:, 0]
        assert start == pytest.approx(end, rel=0.3), name
    assert float(abs(one["mean_velocity"][:, 0]).max()) < 0.5 * float(two["mean_velocity"][0, 0])


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"stiffness": 200.0}, "a run with stiffness = 200.0"),
        ({"replicates": 3}, "a run of 3 replicates or more"),
        ({"cell": 6.0}, "a run with cell = 6.0"),
    ],
)
def test_what_a_flow_cannot_turn_into_is_refused(changes, message, tmp_path):
    first = run(tmp_path, CHUTE)
    with pytest.raises(InputError, match=f"start_from: got .*; allowed: {message}"):
        run(tmp_path, CHUTE, start_from=first.stem, **changes)


def test_a_run_without_its_states_is_refused(tmp_path):
    first = run(tmp_path, CHUTE)
    first.with_name(f".{first.name}.state").unlink()
    with pytest.raises(InputError, match=r"the state of its replicate 0 in .* beside it"):
        run(tmp_path, CHUTE, start_from=first.stem, angle=20.0)


def test_contacts_that_remember_other_numbers_are_refused(tmp_path, caplog):
    """A state that a program has written whose law kept seven numbers of each contact."""
    point = parse_point(CHUTE.model_dump() | {"law": "hertz"}, "point")
    first = run(tmp_path, point)
    states = States(first, point)
    for number in range(point.replicates):
        state = unpack(states._archives[number])
        held = state["moving.memory"]
        state["moving.memory"] = np.pad(held, ((0, 0), (0, 7 - held.shape[1]), (0, 0)))
        states._archives[number] = pack(state)
    states.save()
    with pytest.raises(InputError, match=r"the state of its replicate 0 in .* beside it; remove"):
        run(tmp_path, point, start_from=first.stem, angle=20.0)
    assert "memory has the lengths (2, 7, " in caplog.text


def test_what_starts_from_a_failure_has_failed(tmp_path):
    """So that the rest of a study goes on."""
    first = tmp_path / f"{point_id(FAILING)}.nc"
    assert run_point(FAILING, first, quiet=True, record_failure=True) == 0
    then = parse_point(CHUTE.model_dump() | {"start_from": first.stem}, "point")
    path = tmp_path / f"{point_id(then)}.nc"
    assert run_point(then, path, quiet=True, record_failure=True) == 0
    with xr.open_dataset(path) as found:
        assert set(found["status"].values) == {"failed"}
        assert "from which it starts, has failed" in str(found["reason"].values[0])


def test_the_states_of_another_run_are_left_where_they_are(tmp_path):
    first = run(tmp_path, CHUTE)
    states = first.with_name(f".{first.name}.state")
    states.write_bytes(b"none")
    with pytest.raises(InputError, match="damaged or no states of a run"):
        run(tmp_path, CHUTE, start_from=first.stem)
    assert states.read_bytes() == b"none"
    with pytest.raises(InputError, match="another run than that to be made"):
        run_point(parse_point(CHUTE.model_dump() | {"start_from": str(first)}, "point"), first)


def test_a_run_that_is_not_there_is_named(tmp_path):
    missing = tmp_path / "missing.nc"
    with pytest.raises(InputError, match=r"missing\.nc: no such run file"):
        run(tmp_path, CHUTE, start_from=str(missing))


def test_a_bed_that_stopped_within_a_cycle_is_refused(tmp_path):
    first = run(tmp_path, BELT, average=2.5)
    with pytest.raises(InputError, match="shaken for no whole number of cycles"):
        run(tmp_path, BELT, start_from=first.stem, frequency=40)


def study(*cases: dict, **base):
    series = {"name": "a", "system": "chute", "base": base, "cases": list(cases)}
    return parse_study({"study": "s", "series": [series]}, "study.yaml", None)


def test_a_study_names_points_of_its_own_or_files_that_are_there(tmp_path):
    (first,) = study({"depth": 2}).points
    points = study({"depth": 2}, {"depth": 2, "start_from": first, "angle": 20}).points
    assert len(points) == 2
    other = "chute-depth9-friction0.4-restitution0.85-stiffness100-00000000"
    for start in (other, str(tmp_path / "missing.nc")):
        with pytest.raises(InputError, match=r"study\.yaml: start_from: .*; allowed: the id of"):
            study({"depth": 2, "start_from": start})
    with pytest.raises(InputError, match=r"a run with depth = 3\.0"):
        study({"depth": 2}, {"depth": 3, "start_from": first})


def test_a_start_that_has_gone_on_is_another_start(tmp_path):
    """Bits of what then starts from it are those of a run that always had."""
    late = {"start_from": run(tmp_path / "late", CHUTE, average=6).stem, "angle": 24.0}
    expected = run(tmp_path / "late", CHUTE, **late)
    early = run(
        tmp_path / "early", CHUTE, **late | {"start_from": run(tmp_path / "early", CHUTE).stem}
    )
    before = digest(early)
    run(tmp_path / "early", CHUTE, replicates=3)
    assert digest(run(tmp_path / "early", CHUTE, **late)) == before
    run(tmp_path / "early", CHUTE, average=6)
    assert digest(run(tmp_path / "early", CHUTE, **late)) == digest(expected) != before
    inode = early.stat().st_ino
    assert run(tmp_path / "early", CHUTE, **late).stat().st_ino == inode


def test_what_is_neither_an_id_nor_a_run_file_is_refused():
    with pytest.raises(InputError, match=r"start_from: got 'there'; allowed: .*run file \(\*.nc\)"):
        parse_point({"system": "chute", "start_from": "there"}, "point.yaml")
