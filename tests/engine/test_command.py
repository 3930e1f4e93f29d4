"""The commands: batches, interrupts, one small point per set of kernels to warm."""

import io
import json
import os
import signal
import sys

import pytest

from sim.__main__ import main
from sim.engine import command
from sim.engine.command import save_and_end, variants, warm
from sim.engine.compile import compile_ahead
from sim.engine.contact import Partners, law_of
from sim.engine.progress import progress_file
from sim.engine.run import run_point
from sim.engine.systems import build
from sim.engine.systems.bed_samples import sample_bed
from sim.parameters import canonical_values, parse_point, point_id
from tests.engine_motion.points import belt_point
from tests.golden import digest
from tests.made.processes import program, start_run, wait_until

BELT = {"system": "belt", "beads": 10, "width": 5, "transient": 1, "average": 2}
POINTS = [BELT, BELT | {"seed": 2}, BELT | {"overlap_limit": 1e-6}]
IDS = [point_id(parse_point(point, "test")) for point in POINTS]


def batch(folder, points, **options):
    return program("batch", str(folder), input=json.dumps(points), **options)


def complete(points):
    return [canonical_values(parse_point(point, "test")) for point in points]


@pytest.fixture(scope="module")
def finished_batch(tmp_path_factory):
    folder = tmp_path_factory.mktemp("batch")
    return folder, batch(folder, complete(POINTS))


def test_each_point_has_its_run_file_and_log(finished_batch):
    folder, process = finished_batch
    assert (process.returncode, process.stdout, process.stderr) == (0, "", "")
    for name, ending in zip(IDS, ("undetermined", "undetermined", "failed"), strict=True):
        log = (folder / "logs" / "runs" / f"{name}.log").read_text()
        assert log.startswith(f"{name}: 10 particles") and ending in log
        assert log.endswith(f"runs/{name}.nc: written\n")
        assert not any(other in log for other in IDS if other != name)
    expected = {file for name in IDS for file in (f"{name}.nc", f".{name}.nc.state")}
    assert {path.name for path in (folder / "runs").iterdir()} == expected


def test_a_point_in_a_batch_has_the_bits_of_one_alone(finished_batch, tmp_path):
    folder, _ = finished_batch
    output = tmp_path / f"{IDS[1]}.nc"
    assert run_point(parse_point(POINTS[1], "test"), output, quiet=True) == 0
    assert digest(output) == digest(folder / "runs" / output.name)


@pytest.mark.parametrize("text", ["", "3", "{}", "\ufffd"])
def test_what_is_no_list_of_points_is_one_line(text, monkeypatch, tmp_path, capsys):
    monkeypatch.setattr(sys, "stdin", io.StringIO(text))
    assert main(["batch", str(tmp_path)]) == 2
    assert capsys.readouterr().err.startswith("error: <stdin>: not a list of points")


def test_what_is_current_is_left_and_the_rest_is_run(finished_batch):
    folder, _ = finished_batch
    files = [folder / "runs" / f"{name}.nc" for name in IDS]
    files[1].unlink()
    before = files[0].stat().st_mtime_ns
    assert batch(folder, complete(POINTS)).returncode == 0
    assert files[0].stat().st_mtime_ns == before
    assert files[1].exists()
    assert "already there" in (folder / "logs" / "runs" / f"{IDS[0]}.log").read_text()


def test_one_that_cannot_be_computed_keeps_no_other_from_it(tmp_path):
    """Nor does an error of the system: each is one line, in the log as well."""
    (tmp_path / "runs" / f"{IDS[1]}.nc").mkdir(parents=True)
    process = batch(tmp_path, complete([BELT | {"width": 1e13}, POINTS[1], BELT]))
    lines = process.stderr.splitlines(keepends=True)
    assert process.returncode == 1 and all(line.startswith("error: ") for line in lines)
    assert (tmp_path / "runs" / f"{IDS[0]}.nc").exists()
    large, other = lines
    assert "cannot be computed" in large and IDS[1] in other
    logs = {path.stem: path.read_text() for path in (tmp_path / "logs" / "runs").iterdir()}
    assert other in logs[IDS[1]] and "Traceback" not in logs[IDS[1]]
    assert any(large in text for text in logs.values())


def test_an_error_of_the_program_is_in_the_log(tmp_path, monkeypatch, capsys):
    def fail(*arguments, **options):
        raise RuntimeError

    monkeypatch.setattr("sim.engine.run.run_point", fail)
    monkeypatch.setattr(sys, "stdin", io.StringIO(json.dumps(complete([BELT]))))
    monkeypatch.setattr(signal, "signal", lambda number, handler: None)
    assert command.batch(tmp_path) == 1
    log = tmp_path / "logs" / "runs" / f"{IDS[0]}.log"
    assert "Traceback" in log.read_text()
    assert str(log) in capsys.readouterr().err


def point(**values):
    return parse_point(values, "test")


def test_points_share_a_variant_unless_a_reading_selects_other_code():
    points = [
        point(system="chute", depth=depth, stiffness=k, threads=threads)
        for depth, k, threads in ((1, 100, 1), (5, 100, 2), (1, 1000, 4), (5, 1000, 1))
    ]
    points += [
        point(system="chute", tangential_exponent=0),
        point(system="chute", overlap_memory="shrink"),
        point(system="belt"),
        point(system="belt", integrator="verlet"),
    ]
    usual, linear, shrink, belt, verlet = variants(points)
    assert (usual.system, belt.system) == ("chute", "belt")
    assert usual.tangential_exponent == points[0].tangential_exponent
    assert (linear.tangential_exponent, shrink.overlap_memory) == (0, "shrink")
    assert verlet.integrator == "verlet"
    dashpots = [{}, {"bumps": 1}, {"diameter_spread": 0.3}, {"tangential_damping": 9}]
    points = [point(system="chute", law="spring_dashpot", **one) for one in dashpots]
    laws = [type(law_of(one, Partners(0.4, one.mass, 1e-5))) for one in points]
    small = [type(law_of(one, Partners(0.4, one.mass, 1e-5))) for one in variants(points)]
    assert small == laws[:2] and set(laws[1:]) == {laws[1]}


def test_systems_may_be_warmed_side_by_side(monkeypatch):
    """And what goes wrong with one of them is not lost."""
    points = [point(system="belt", beads=5, width=6), point(system="chute", depth=1, cell=3)]
    warm(points, processes=3)

    def broken(*_):
        raise RuntimeError("broken")

    monkeypatch.setattr("sim.engine.systems.build", broken)
    # What has been compiled is not compiled again.
    warm(points, processes=2)
    monkeypatch.setattr("sim.engine.command.library_versions", dict)
    for _ in range(2):
        with pytest.raises(RuntimeError, match="broken"):
            warm(points, processes=2)


def test_what_compiles_ahead_calls_no_kernel(monkeypatch):
    monkeypatch.setattr("sim.engine.compile._ahead", False)
    system = build(point(system="belt", beads=5, width=6), 0)
    before = system.snapshot()
    compile_ahead(system.settle)
    compile_ahead(system.sample)
    assert sample_bed.signatures
    assert all((before[name] == value).all() for name, value in system.snapshot().items())


def test_an_interrupt_saves_the_state_of_a_run(tmp_path):
    """Also of one whose bed never comes to rest."""
    warm([belt_point()])
    often = os.environ | {"TALUS_CHECKPOINT_SECONDS": "0.01"}
    restless = belt_point(beads=400, settle_velocity_squared=1e-15)
    process = start_run(restless, tmp_path / "run.nc", env=often)
    try:
        wait_until((tmp_path / ".run.nc.state").exists, process)
        process.send_signal(signal.SIGINT)
        code = process.wait()
    finally:
        process.kill()
    last = process.stderr.read().splitlines()[-1].partition(": ")[2]
    assert (code, last) == (143, "terminated; the next start continues from here")
    assert not (tmp_path / "run.nc").exists()
    assert (tmp_path / ".run.nc.state").stat().st_size > 0
    # `status` takes it for interrupted by this file.
    assert progress_file(tmp_path / "run.nc").exists()


def test_an_interrupt_ends_at_once_without_anything_to_save_and_the_second_time():
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    calls = []
    try:
        signal.signal(signal.SIGTERM, signal.SIG_DFL)
        with pytest.raises(KeyboardInterrupt):
            save_and_end(signal.SIGINT, None)
        signal.signal(signal.SIGTERM, lambda *_: calls.append("save"))
        signal.signal(signal.SIGINT, save_and_end)
        signal.raise_signal(signal.SIGINT)
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(signal.SIGINT)
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
    assert calls == ["save"]
