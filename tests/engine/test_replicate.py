"""Replicates: blow-ups that are retried, and flows that start from the end of another run."""

from pathlib import Path

import netCDF4
import numpy as np
import pytest
import xarray as xr

from sim.__main__ import main
from sim.base.errors import InputError
from sim.engine.dynamics.cells import BlowUp
from sim.engine.replicate import Replicate
from sim.engine.run import BLOW_UP_CODE, run_point
from sim.engine.states import States, pack, unpack
from sim.engine.systems import build
from sim.engine.systems.belt import Belt
from sim.engine.systems.chute import Chute
from sim.parameters import Parameters, load_point, parse_point, point_id
from sim.study.load import parse_study
from tests.engine_motion.points import belt_point, chute_point
from tests.golden import digest

CHUTE = chute_point(depth=1.24, cell=4, transient=2, average=4, replicates=2)
BELT = belt_point(beads=12, width=5, transient=1, average=2, replicates=2)
HOPELESS = chute_point(depth=1.24, cell=4, transient=2, average=4, replicates=2, overlap_limit=1e-9)


class NoKeeper:
    """Keeps no states."""

    def offer(self, replicate: Replicate) -> None:
        pass

    def check_signals(self) -> None:
        pass

    def keep(self, replicate: Replicate) -> None:
        pass


def run(replicate: Replicate):
    """Run a replicate to its end without anyone watching."""
    return replicate.run(lambda steps: None, NoKeeper())


def blow_up_of_whole_steps(monkeypatch, system: type, after: int = 3) -> None:
    """Make a system blow up at a sample unless its time step is divided."""
    sample = system.sample

    def failing(self, most, profiles):
        if self.sample_steps == self.parameters.sample_steps:
            self.taken = getattr(self, "taken", 0) + 1
            if self.taken > after:
                raise BlowUp("an overlap too large at step 7")
            most = 1
        return sample(self, most, profiles)

    monkeypatch.setattr(system, "sample", failing)


@pytest.mark.parametrize(("point", "system"), [(CHUTE, Chute), (BELT, Belt)])
def test_half_the_step_is_half_the_step_from_the_same_start(point, system, monkeypatch, tmp_path):
    blow_up_of_whole_steps(monkeypatch, system)
    assert run_point(point, tmp_path / "run.nc", quiet=True) == 0
    assert {path.name for path in tmp_path.iterdir()} == {"run.nc", ".run.nc.state"}
    with netCDF4.Dataset(tmp_path / "run.nc") as file:
        file.set_auto_mask(False)
        assert file.status == "completed" and list(file["reason"][:]) == ["", ""]
        assert (file["time_step_used"][:] == point.time_step / 2).all()
        assert (file["steps"][:] == 2 * point.steps).all()
        assert file["time"].size == point.transient_samples + point.average_samples
        assert float(file["time"][-1]) == pytest.approx(point.steps * point.time_step, rel=1e-12)
        assert np.isfinite(file["mean_velocity"][:]).all()


# Beds that settle with different steps come to rest in different places.
@pytest.mark.parametrize(("point", "tolerance"), [(CHUTE, 0.02), (BELT, 0.2)])
def test_a_divided_step_samples_the_same_motion(point, tolerance):
    whole, half = build(point, 0), build(point, 0, 2)
    for system in (whole, half):
        system.settle()
    assert half.time_step == whole.time_step / 2
    for _ in range(2):
        one, other = whole.advance(), half.advance()
        assert other["mean_velocity"] == pytest.approx(one["mean_velocity"], rel=tolerance)
        assert other["height_of_mass"] == pytest.approx(one["height_of_mass"], rel=tolerance)
    if point.system == "belt":
        assert other["belt_phase"] == pytest.approx(one["belt_phase"], abs=1e-12)


def test_progress_counts_no_sample_twice(monkeypatch):
    blow_up_of_whole_steps(monkeypatch, Chute)
    reported = []
    Replicate(CHUTE, 0).run(reported.append, NoKeeper())
    assert sum(reported) == CHUTE.steps


def test_a_second_blow_up_is_final_and_names_the_command_that_gives_its_point(
    tmp_path, caplog, capsys
):
    output = tmp_path / "run.nc"
    assert run_point(HOPELESS, output, quiet=True) == BLOW_UP_CODE
    assert sum("again with half the time step" in line for line in caplog.messages) == 2
    (hint,) = (line for line in caplog.messages if "to see the failure again" in line)
    assert main(hint.partition(": python -m sim ")[2].split()) == 0
    path = tmp_path / "point.yaml"
    path.write_text(capsys.readouterr().out)
    assert load_point(path) == HOPELESS
    assert main(["run", str(path), "-o", str(tmp_path / "again.nc"), "--quiet"]) == BLOW_UP_CODE
    with netCDF4.Dataset(output) as one, netCDF4.Dataset(tmp_path / "again.nc") as other:
        assert other["reason"][0] == one["reason"][0]
        first, second = one["reason"][0].split("; with half the time step: ")
        assert "overlap_limit at step" in first and "overlap_limit at step" in second
    names = {path.name for path in tmp_path.iterdir() if not path.name.startswith(".")}
    assert names == {"again.nc", "point.yaml", "run.nc"}


FLOW = chute_point(depth=2, cell=5, transient=2, average=4, replicates=2, stress_profiles=True)
FAILING = parse_point(FLOW.model_dump() | {"overlap_limit": 1e-6}, "point")
SMALL = chute_point(depth=1.24, cell=4, transient=2, average=4)
BED = belt_point(beads=20, width=5, transient=1, average=3, replicates=2)


def run_in(folder: Path, point: Parameters, **changes) -> Path:
    """Run a point with some changes into a folder, under its id."""
    changed = parse_point(point.model_dump() | changes, "point")
    folder.mkdir(exist_ok=True)
    path = folder / f"{point_id(changed)}.nc"
    assert run_point(changed, path, quiet=True) == 0
    return path


def with_start(folder: Path, point: Parameters, **changes) -> tuple[xr.Dataset, xr.Dataset]:
    """Return a run, and one that starts from its end with some changes."""
    first = run_in(folder, point)
    then = run_in(folder, point, start_from=first.stem, **changes)
    return xr.load_dataset(first), xr.load_dataset(then)


@pytest.mark.parametrize(("point", "exact"), [(FLOW, 0.0), (BED, 1e-6)])
def test_what_changes_nothing_goes_on_as_if_it_had_not_ended(point, exact, tmp_path):
    """The flow with the same bits; a belt's phase is rounded otherwise in its first cycle."""
    one, two = with_start(tmp_path, point)
    longer = 2 * point.average + point.transient
    whole = xr.load_dataset(run_in(tmp_path / "whole", point, average=longer))
    for name in ("mean_velocity", "kinetic_energy", "height_of_mass", "contact_number"):
        joined = np.concatenate([one[name], two[name]], axis=1)
        last = one.sizes["time"] + 5 if exact else None
        expected = whole[name].values[:, :last]
        assert joined[:, :last] == pytest.approx(expected, rel=exact, abs=0), name
    assert abs(two["energy_residual"]).max() < 0.01


def test_a_flow_goes_on_under_another_angle_and_friction_without_a_jump(tmp_path):
    one, two = with_start(tmp_path, FLOW, angle=24.0, friction=0.3)
    end, start = one["mean_velocity"].values[:, -1], two["mean_velocity"].values[:, 0]
    assert start == pytest.approx(end, rel=0.05)
    assert float(two["acceleration"].mean()) > float(one["acceleration"].mean())
    assert two.attrs["point_id"] != one.attrs["point_id"]


def test_a_bed_is_shaken_on_at_another_frequency(tmp_path):
    one, two = with_start(tmp_path, BED, frequency=40.0)
    for name in ("height_of_mass", "mean_velocity"):
        end, start = one[name].values[:, -1], two[name].values[:, 0]
        assert start == pytest.approx(end, rel=0.3), name
    assert float(abs(one["mean_velocity"][:, 0]).max()) < 0.5 * float(two["mean_velocity"][0, 0])


def test_what_starts_from_a_failure_has_failed(tmp_path):
    """So that the rest of a study goes on."""
    first = tmp_path / f"{point_id(FAILING)}.nc"
    assert run_point(FAILING, first, quiet=True, record_failure=True) == 0
    then = parse_point(FLOW.model_dump() | {"start_from": first.stem}, "point")
    path = tmp_path / f"{point_id(then)}.nc"
    assert run_point(then, path, quiet=True, record_failure=True) == 0
    with xr.open_dataset(path) as found:
        assert set(found["status"].values) == {"failed"}
        assert "from which it starts, has failed" in str(found["reason"].values[0])


@pytest.mark.parametrize(
    ("point", "before", "changes", "message"),
    [
        (FLOW, {}, {"stiffness": 200.0}, "start_from: got .*; allowed: a run with stiffness ="),
        (FLOW, {}, {"replicates": 3}, "start_from: got .*; allowed: a run of 3 replicates or"),
        (FLOW, {}, {"cell": 6.0}, "start_from: got .*; allowed: a run with cell = 6.0"),
        (BED, {"average": 2.5}, {"frequency": 40}, "shaken for no whole number of cycles"),
    ],
)
def test_what_a_flow_cannot_turn_into_is_refused(point, before, changes, message, tmp_path):
    first = run_in(tmp_path, point, **before)
    with pytest.raises(InputError, match=message):
        run_in(tmp_path, point, start_from=first.stem, **changes)


def test_a_run_whose_states_are_missing_or_of_another_kind_is_refused(tmp_path, caplog):
    """Such as those whose law kept seven numbers of each contact; they stay where they are."""
    first = run_in(tmp_path, SMALL)
    states = States(first, SMALL)
    state = unpack(states._archives[0])
    held = state["moving.memory"]
    state["moving.memory"] = np.pad(held, ((0, 0), (0, 9 - held.shape[1]), (0, 0)))
    states._archives[0] = pack(state)
    states.save()
    refusal = r"the state of its replicate 0 in .* beside it; remove"
    with pytest.raises(InputError, match=refusal):
        run_in(tmp_path, SMALL, start_from=first.stem, angle=20.0)
    assert "memory is not as in the system" in caplog.text
    states.path.write_bytes(b"none")
    with pytest.raises(InputError, match="damaged or no states of a run"):
        run_in(tmp_path, SMALL, start_from=first.stem)
    assert states.path.read_bytes() == b"none"
    states.path.unlink()
    with pytest.raises(InputError, match=refusal):
        run_in(tmp_path, SMALL, start_from=first.stem, angle=20.0)
    with pytest.raises(InputError, match="a run other than the output"):
        run_point(parse_point(SMALL.model_dump() | {"start_from": str(first)}, "point"), first)
    with pytest.raises(InputError, match=r"missing\.nc: no such run file"):
        run_in(tmp_path, SMALL, start_from=str(tmp_path / "missing.nc"))
    with pytest.raises(InputError, match=r"start_from: got 'there'; allowed: .*run file \(\*.nc\)"):
        parse_point({"system": "chute", "start_from": "there"}, "point.yaml")


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
    late = {"start_from": run_in(tmp_path / "late", FLOW, average=6).stem, "angle": 24.0}
    expected = run_in(tmp_path / "late", FLOW, **late)
    early = run_in(
        tmp_path / "early",
        FLOW,
        **late | {"start_from": run_in(tmp_path / "early", FLOW).stem},
    )
    before = digest(early)
    run_in(tmp_path / "early", FLOW, replicates=3)
    assert digest(run_in(tmp_path / "early", FLOW, **late)) == before
    run_in(tmp_path / "early", FLOW, average=6)
    assert digest(run_in(tmp_path / "early", FLOW, **late)) == digest(expected) != before
    inode = early.stat().st_ino
    assert run_in(tmp_path / "early", FLOW, **late).stat().st_ino == inode


@pytest.mark.long
def test_sweeps_up_and_down_find_a_flow_and_a_bed_at_rest_at_one_angle(tmp_path):
    base = {
        **{"depth": 3, "cell": 5, "bumps": 0.5, "friction": 0.5, "stiffness": 300},
        **{"steps_per_collision": 20, "transient": 60, "average": 30, "start_from": "previous"},
    }
    down = {"name": "down", "system": "chute", "base": base, "grid": {"angle": [24, 22]}}
    slow = {"base": base | {"initial_velocity": 0}, "grid": {"angle": [20, 22]}}
    study = parse_study({"study": "s", "series": [down, down | {"name": "up"} | slow]}, "s", None)
    found = {}
    for key, point in study.points.items():
        assert run_point(point.parameters, tmp_path / f"{key}.nc", quiet=True) == 0
        with netCDF4.Dataset(tmp_path / f"{key}.nc") as file:
            speed = file["velocity"][0] / point.parameters.velocity_unit
            found[point.series[0], point.parameters.angle] = speed, file["regime"][0]
    assert found["down", 24][0] > found["down", 22][0] > 0.2
    assert found["up", 20][1] == found["up", 22][1] == "arrested"
