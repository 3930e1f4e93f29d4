"""The commands: batches, interrupts, one small point per set of kernels to warm."""

import io
import json
import os
import signal
import subprocess
import sys

import pytest

from sim.__main__ import main
from sim.engine import command
from sim.engine.command import save_and_end, variants, warm
from sim.engine.compile import compile_ahead
from sim.engine.progress import progress_file
from sim.engine.systems import build
from sim.engine.systems.bed_samples import sample_bed
from sim.parameters import canonical_values, parse_point, point_id
from tests.engine_motion.points import belt_point
from tests.golden import digest
from tests.made.processes import ROOT, program, run_command, start_run, wait_until

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
    alone = program(*run_command(output)[3:], input=json.dumps(complete(POINTS)[1]))
    assert alone.returncode == 0, alone.stderr
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


def test_one_that_no_machine_can_compute_keeps_no_other_from_it(tmp_path):
    points = complete([BELT | {"width": 1e13}, BELT])
    process = batch(tmp_path, points)
    assert process.returncode == 1
    assert (tmp_path / "runs" / f"{IDS[0]}.nc").exists()
    (log,) = (path for path in (tmp_path / "logs" / "runs").iterdir() if path.stem != IDS[0])
    assert "cannot be computed" in log.read_text()
    assert process.stderr.startswith("error: ") and "cannot be computed" in process.stderr


def test_an_error_of_the_system_is_one_line_in_the_log_as_well(tmp_path):
    (tmp_path / "runs" / f"{IDS[0]}.nc").mkdir(parents=True)
    process = batch(tmp_path, complete([BELT]))
    assert (process.returncode, process.stderr.count("\n")) == (1, 1)
    log = (tmp_path / "logs" / "runs" / f"{IDS[0]}.log").read_text()
    assert process.stderr in log and "Traceback" not in log


def test_an_error_of_the_program_is_in_the_log(tmp_path, monkeypatch, capsys):
    def fail(*arguments, **options):
        raise ZeroDivisionError

    monkeypatch.setattr(command, "_run_one", fail)
    monkeypatch.setattr(sys, "stdin", io.StringIO(json.dumps(complete([BELT]))))
    monkeypatch.setattr(signal, "signal", lambda number, handler: None)
    assert command.batch(tmp_path) == 1
    log = tmp_path / "logs" / "runs" / f"{IDS[0]}.log"
    assert "Traceback" in log.read_text()
    assert str(log) in capsys.readouterr().err


def point(**values):
    return parse_point(values, "test")


def test_points_that_differ_in_numbers_alone_share_one_variant():
    points = [
        point(system="chute", depth=depth, stiffness=k, threads=threads)
        for depth, k, threads in ((1, 100, 1), (5, 100, 2), (1, 1000, 4), (5, 1000, 1))
    ]
    assert len(variants(points)) == 1


def test_every_reading_that_selects_code_is_a_variant_of_its_own():
    points = [
        point(system="chute"),
        point(system="chute", tangential_exponent=0),
        point(system="chute", overlap_memory="shrink"),
        point(system="belt"),
        point(system="belt", integrator="verlet"),
    ]
    small = variants(points)
    assert [p.system for p in small] == ["chute", "chute", "chute", "belt", "belt"]
    assert [p.tangential_exponent for p in small[:2]] == [points[0].tangential_exponent, 0]
    assert small[2].overlap_memory == "shrink"
    assert small[4].integrator == "verlet"


def test_warming_runs_every_kernel_of_a_run():
    warm([point(system="belt", beads=5, width=6)])


def test_the_command_says_what_it_compiles():
    lines = (
        "import logging, sys, sim.engine.command\n"
        "def log_compiling(*_):\n"
        "    logging.getLogger('talus').info('compiling')\n"
        "sim.engine.command.warm = log_compiling\n"
        "from sim.__main__ import main\n"
        "sys.exit(main(['warm']))\n"
    )
    command = [sys.executable, "-c", lines]
    process = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    assert (process.returncode, process.stderr) == (0, "compiling\n")


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


#: Runs that last: one of a long average, one whose bed never comes to rest, one that is shaken
#: before for long.
LONG_RUNS = {
    "flow": belt_point(frequency=20, average=1e5),
    "fall": belt_point(beads=400, settle_velocity_squared=1e-15),
    "prior shaking": belt_point(prior_frequency=20, prior_cycles=10**5),
}


@pytest.fixture(params=LONG_RUNS)
def process(request, tmp_path):
    """A long run that has kept a state."""
    point = LONG_RUNS[request.param]
    warm([LONG_RUNS["flow"]])
    often = os.environ | {"TALUS_CHECKPOINT_SECONDS": "0.01"}
    process = start_run(point, tmp_path / "run.nc", env=often)
    wait_until((tmp_path / ".run.nc.state").exists, process)
    yield process
    process.kill()
    process.wait()


def test_an_interrupt_saves_the_state_of_a_run(process, tmp_path):
    process.send_signal(signal.SIGINT)
    code = process.wait()
    last = process.stderr.read().splitlines()[-1]
    assert (code, last.partition(": ")[2]) == (
        143,
        "terminated; the next start continues from here",
    )
    assert not (tmp_path / "run.nc").exists()
    assert (tmp_path / ".run.nc.state").stat().st_size > 0
    # `status` takes it for interrupted by this file.
    assert progress_file(tmp_path / "run.nc").exists()


@pytest.fixture
def signals():
    """What the two signals do, put back afterwards."""
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    yield
    for number, handler in before.items():
        signal.signal(number, handler)


def test_without_anything_to_save_an_interrupt_ends_at_once(signals):
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    with pytest.raises(KeyboardInterrupt):
        save_and_end(signal.SIGINT, None)


def test_the_second_interrupt_ends_at_once(signals):
    calls = []
    signal.signal(signal.SIGTERM, lambda *_: calls.append("save"))
    signal.signal(signal.SIGINT, save_and_end)
    signal.raise_signal(signal.SIGINT)
    assert calls == ["save"]
    with pytest.raises(KeyboardInterrupt):
        signal.raise_signal(signal.SIGINT)
    assert calls == ["save"]
