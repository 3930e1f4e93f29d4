"""Particles in other formats, read again by programs that know nothing of this one."""

import json
import re
from base64 import b64decode
from io import BytesIO
from pathlib import Path
from types import SimpleNamespace
from xml.etree import ElementTree

import chemfiles
import meshio
import netCDF4
import numpy as np
import pytest
from PIL import Image

from sim.__main__ import main
from sim.engine import run_file
from sim.engine.systems.recorder import Record
from sim.figures.animation import ParticleFrames
from sim.parameters import Parameters, point_id
from sim.parameters.variables import variables_of
from sim.report.export import FORMATS
from tests.engine_motion.points import belt_point, chute_point
from tests.made.processes import refusal

CHUTE = chute_point(depth=0.75, cell=[4, 3], bumps=1, replicates=2)
BELT = belt_point(beads=3, width=5, replicates=2)
POINTS = {"chute": CHUTE, "belt": BELT}
COLUMNS = {"chute": [0, 1, 2], "belt": [0, 2]}

#: Name of each format in chemfiles, and its units of length (m) and velocity (m/s) there.
READERS = {
    "amber": ("Amber NetCDF", 1e-10, 1e2),
    "extxyz": ("XYZ", 1.0, 1.0),
    "lammps-dump": ("LAMMPS", 1.0, 1.0),
}


def record(point: Parameters, seed: int, samples: int) -> Record:
    """Return a made-up record of a replicate with frames at every other sample."""
    rng = np.random.default_rng(seed)
    number, axes = point.particles + point.glued_particles, 3 if point.system == "chute" else 2
    # Particles leave the cell now and then, and overlap with the base.
    place = 4e-3 * rng.uniform(-1, 2, (2 + samples // 2, number, axes))
    place[..., -1] = np.abs(place[..., -1])
    velocity = rng.normal(size=place.shape)
    names = ["position", "particle_velocity"] + ["particle_spin"] * (axes == 3)
    states = dict(zip(names, (place, velocity, 100 * velocity), strict=False))
    snapshots = {name: [state[0], state[1]] for name, state in states.items()}
    snapshots["radius"] = [rng.uniform(4e-4, 6e-4, number)] * 2
    if axes == 3:
        snapshots["fixed"] = [np.arange(number) >= point.particles] * 2
    frames = {
        name: states[row.of][2:].astype(np.float32)
        for name, row in variables_of("trajectory").items()
        if row.of in states
    }
    series = {"mean_velocity": np.pad(np.ones(samples), (0, 6 - samples), constant_values=np.nan)}
    return Record(series, frames=frames if samples > 1 else {}, snapshots=snapshots)


def write(path: Path, point: Parameters) -> Path:
    """Write a run file of two replicates, the second of which ended after four of six samples."""
    records = [record(point, seed, samples) for seed, samples in ((1, 6), (2, 4))]
    replica = SimpleNamespace(
        profile_height=np.arange(2.0),
        series={"mean_velocity": variables_of("series")["mean_velocity"]},
        axes=("x", "y", "z") if point.system == "chute" else ("x", "z"),
        coordinates={},
    )
    attributes = {"system": point.system, "point_id": point_id(point), "status": "completed"}
    run_file.write(path, run_file.StoredRun(point, records), replica, attributes)
    return path


def with_trajectory(point: Parameters) -> Parameters:
    """Return the point with a frame at every other sample."""
    samples = 2 * point.sample_steps * point.time_step / point.time_unit
    return point.model_copy(update={"trajectory": samples})


@pytest.fixture(params=POINTS)
def system(request) -> str:
    return request.param


@pytest.fixture
def run(system, tmp_path) -> Path:
    return write(tmp_path / "a.run.nc", with_trajectory(POINTS[system]))


class StoredReplicate:
    """Trajectory and radii of a replicate, read from a run file."""

    def __init__(self, path: Path, system: str, replicate: int = 0):
        with netCDF4.Dataset(path) as file:
            file.set_auto_mask(False)
            self.time, self.radius = file["trajectory_time"][:], file["radius"][replicate]
            self.position = file["trajectory_position"][replicate]
            self.velocity = file["trajectory_velocity"][replicate]
            self.spin = file["trajectory_spin"][replicate] if system == "chute" else None
        self.length = np.array({"chute": [4e-3, 3e-3, np.inf], "belt": [5e-3, np.inf]}[system])
        self.columns = COLUMNS[system]

    def compare(self, place: np.ndarray, frame: int) -> None:
        """Compare places (N, 3), in the cell, with those of a frame."""
        found, expected = np.asarray(place)[:, self.columns], self.position[frame]
        periodic = np.isfinite(self.length)
        assert (found[:, periodic] >= 0).all()
        assert (found[:, periodic] <= 1.000001 * self.length[periodic]).all()
        turns = np.where(periodic, (expected - found) / np.where(periodic, self.length, 1), 0)
        back = found + np.where(periodic, self.length, 0) * np.round(turns)
        np.testing.assert_allclose(back, expected, atol=3e-9)


def exported(run: Path, to: str, *words: str) -> Path:
    output = run.parent / "out" / f"run{FORMATS[to][0][0]}"
    assert main(["export", str(run), "--to", to, "-o", str(output), *words]) == 0
    return output


def test_a_trajectory_plays(system, run, tmp_path):
    stored = StoredReplicate(run, system)
    for to in ("webp", "gif"):
        assert Image.open(exported(run, to)).n_frames == len(stored.time)
    page = exported(run, "html").read_text()
    assert page.count("data:image/webp;base64,") == 2 and "http" not in page
    frames = json.loads(re.search(r"const sources = (\[.*?\])", page)[1])
    assert [Image.open(BytesIO(b64decode(one))).format for one in frames] == ["WEBP"] * len(
        stored.time
    )


def test_a_lone_particle_does_not_make_a_picture_of_the_others_small():
    heights = np.tile(np.linspace(0.5, 9.5, 60), (3, 1))
    bed = ParticleFrames(heights[..., None], 0 * heights, np.ones(60), 10.0)
    assert bed.height_of_most > bed.ends[1]
    heights[1, -1] = 55.0
    lone = ParticleFrames(heights[..., None], 0 * heights, np.ones(60), 10.0)
    assert 10 < lone.height_of_most < 20 < lone.ends[1]


@pytest.mark.parametrize("to", READERS)
def test_another_program_reads_places_velocities_and_cell(to, run, system):
    held = StoredReplicate(run, system)
    kind, length, velocity = READERS[to]
    with chemfiles.Trajectory(str(exported(run, to)), "r", kind) as trajectory:
        assert trajectory.nsteps == 3
        for number in range(3):
            frame = trajectory.read_step(number)
            held.compare(frame.positions * length, number)
            if to == "extxyz":
                found = np.array([atom["velo"] for atom in frame.atoms])
            else:
                found = frame.velocities * velocity
            expected = held.velocity[number]
            np.testing.assert_allclose(found[:, held.columns], expected, rtol=1e-6)
            cell = np.array(frame.cell.lengths)[held.columns] * length
            periodic = np.isfinite(held.length)
            np.testing.assert_allclose(cell[periodic], held.length[periodic], rtol=1e-6)
            top = (held.position[:, :, -1] + held.radius).max()
            assert cell[-1] >= 0.999999 * top
            if to != "amber":
                compare_text(frame, to, held, number)


def compare_text(frame, to: str, held: StoredReplicate, number: int) -> None:
    """Compare radii, spins, times and what is glued in a frame of text with those of a run."""
    is_xyz, is_flat = to == "extxyz", held.spin is None
    radius = [atom["radius"] for atom in frame.atoms]
    np.testing.assert_allclose(radius, held.radius, rtol=1e-7)
    assert float(frame["Time" if is_xyz else "time"]) == pytest.approx(float(held.time[number]))
    kinds = [atom["kind"] if is_xyz else float(atom.type) for atom in frame.atoms]
    assert kinds.count(2) == (0 if is_flat else CHUTE.glued_particles)
    assert kinds.count(1) == (BELT if is_flat else CHUTE).particles
    if is_flat:
        assert "omega" not in str(frame.atoms[0].list_properties())
        return
    spin = [
        atom["angular_velocity"] if is_xyz else [atom[f"omega{axis}"] for axis in "xyz"]
        for atom in frame.atoms
    ]
    np.testing.assert_allclose(np.array(spin), held.spin[number], rtol=1e-6)


def test_the_amber_file_follows_the_convention(run, system):
    held = StoredReplicate(run, system)
    with netCDF4.Dataset(exported(run, "amber")) as file:
        assert (file.Conventions, file.ConventionVersion) == ("AMBER", "1.0")
        assert file.data_model == "NETCDF3_64BIT_OFFSET" and file.dimensions["frame"].isunlimited()
        assert b"".join(file["spatial"][:]) == b"xyz" and file["time"].units == "picosecond"
        assert b"".join(file["cell_angular"][:].ravel()) == b"alphabeta gamma"
        np.testing.assert_allclose(file["time"][:] * 1e-12, held.time, rtol=1e-6)
        np.testing.assert_allclose(file["radius"][2] * 1e-10, held.radius, rtol=1e-6)
        assert (file["cell_angles"][:] == 90).all()
        if system == "chute":
            np.testing.assert_allclose(file["spin"][2] * 1e12, held.spin[2], rtol=1e-6)


def test_vtk_is_a_series_with_its_times(run, system):
    held, output = StoredReplicate(run, system), exported(run, "vtk")
    entries = list(ElementTree.parse(output).iter("DataSet"))
    assert [float(one.get("timestep")) for one in entries] == pytest.approx(held.time)
    for number, one in enumerate(entries):
        mesh = meshio.read(output.parent / one.get("file"))
        held.compare(mesh.points, number)
        found = mesh.point_data["velocity"][:, held.columns]
        np.testing.assert_array_equal(found, held.velocity[number])
        np.testing.assert_array_equal(mesh.point_data["radius"], held.radius)
        assert ("spin" in mesh.point_data) == (system == "chute")
    cell = meshio.read(output.with_suffix("") / "cell.vtu")
    assert cell.cells[0].type == "hexahedron" and np.ptp(cell.points[:, 0]) == held.length[0]
    assert sorted(path.name for path in output.parent.iterdir()) == ["run", "run.pvd"]


def test_frames_that_a_replicate_lacks_are_left_out(run, system, capsys):
    number = POINTS[system].particles + POINTS[system].glued_particles
    for to in FORMATS:
        exported(run, to, "--replicate", "1")
        assert f"2 frames of {number} particles" in capsys.readouterr().out


def test_without_a_trajectory_there_are_the_first_and_the_last_state(system, tmp_path):
    run = write(tmp_path / "run.nc", POINTS[system])
    output = exported(run, "extxyz", "--replicate", "1")
    with netCDF4.Dataset(run) as file, chemfiles.Trajectory(str(output)) as trajectory:
        assert trajectory.nsteps == 2
        times = [float(trajectory.read_step(number)["Time"]) for number in range(2)]
        assert times == pytest.approx([0, float(file["time"][3])])
        last = np.array([atom["velo"] for atom in trajectory.read_step(1).atoms])
        expected = file["particle_velocity"][1, 1]
        np.testing.assert_allclose(last[:, COLUMNS[system]], expected, rtol=1e-6)


def test_a_study_becomes_a_folder_of_short_names(system, tmp_path, monkeypatch, capsys):
    to = {"chute": "vtk", "belt": "amber"}[system]
    monkeypatch.chdir(tmp_path)
    points = [POINTS[system].model_copy(update={"gravity": g}) for g in (1.0, 2.0)]
    runs = tmp_path / "results" / "mine" / "runs"
    runs.mkdir(parents=True)
    ids = [point_id(point) for point in points]
    for point, name in zip(points, ids, strict=True):
        write(runs / f"{name}.nc", point)
    Path("mine.yaml").write_text(
        f"study: mine\nseries: [{{name: a, system: {system}, grid: {{gravity: [1, 2]}}}}]\n"
    )
    assert main(["export", "results/mine", "--to", to, "-o", "out"]) == 0
    ending = FORMATS[to][0][0]
    expected = {f"gravity{g}-{name[-8:]}{ending}" for g, name in zip((1, 2), ids, strict=True)}
    assert {path.name for path in Path("out").glob(f"*{ending}")} == expected
    assert "out: 2 runs" in capsys.readouterr().out
    assert main(["export", "mine.yaml", "--to", to]) == 0
    assert {path.name for path in Path(f"mine-{to}").glob(f"*{ending}")} == expected
    assert "a folder that is not there" in refusal(capsys, "export", "mine.yaml", "--to", to)
    assert not list(Path().glob(".*.part"))
    # The default output of a run is named like it and lies here.
    assert main(["export", f"results/mine/runs/{ids[0]}.nc", "--to", to]) == 0
    assert Path(f"{ids[0]}{ending}").is_file()


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ([".", "--to", "vtk"], "results with runs"),
        (["a.run.nc"], "--to: got nothing; allowed: one of amber"),
        (["a.run.nc", "-o", "a.pdb"], "--to: got '.pdb'; allowed: one of amber"),
        (["text.nc", "--to", "amber"], "damaged or not a run file"),
        (["none.nc", "--to", "amber"], "no such run file"),
        (["--replicate", "2"], "--replicate: got 2; allowed: a replicate of the run, 0 to 1"),
        (["-o", "there.xyz"], "there.xyz: is there already, and stays as it is; -o names another"),
        (["-o", "a_folder"], "--output: got 'a_folder'; allowed: the name of a file; a_folder is"),
        (["-o", "new/", "--to", "vtk"], "--output: got 'new'; allowed: a name that ends in .pvd"),
        (["-o", "new", "--to", "amber"], "allowed: a name that ends in .ncdf or .nc, as amber"),
        (["-o", "there.pvd", "--to", "vtk"], "there: is there already, and stays as it is"),
        (["-o", "there/x.xyz"], "--output: got 'there'; allowed: a folder that can be written"),
    ],
)
def test_mistakes_are_one_line_and_leave_nothing(words, message, run, monkeypatch, capsys):
    monkeypatch.chdir(run.parent)
    Path("there").touch()
    Path("text.nc").write_text("no run")
    Path("there.xyz").touch()
    Path("a_folder").mkdir()
    before = sorted(Path().rglob("*"))
    if words[0].startswith("-"):
        words = [run.name, "--to", "extxyz", *words]
    assert message in refusal(capsys, "export", *words)
    assert sorted(Path().rglob("*")) == before


def test_a_write_that_fails_leaves_nothing(run, monkeypatch):
    def full(*arguments, **options):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(meshio.Mesh, "write", full)
    output = run.parent / "out" / "run.pvd"
    assert main(["export", str(run), "--to", "vtk", "-o", str(output)]) == 1
    assert list(output.parent.iterdir()) == []


@pytest.mark.long
@pytest.mark.parametrize("to", ["amber", "extxyz", "lammps-dump"])
def test_ovito_reads_it(to, run, system, monkeypatch):
    monkeypatch.setenv("QT_QPA_PLATFORM", "offscreen")
    ovito = pytest.importorskip("ovito.io")
    held, length = StoredReplicate(run, system), READERS[to][1]
    pipeline = ovito.import_file(str(exported(run, to)))
    assert pipeline.num_frames == 3
    for number in range(3):
        data = pipeline.compute(number)
        held.compare(np.array(data.particles.positions) * length, number)
        radius = np.array(data.particles["Radius"]) * length
        np.testing.assert_allclose(radius, held.radius, rtol=1e-6)
        cell = np.array(data.cell)[0, 0] * length
        assert cell == pytest.approx(held.length[0])
        velocity = np.array(data.particles["Velocity"])[:, held.columns] * READERS[to][2]
        np.testing.assert_allclose(velocity, held.velocity[number], rtol=1e-6)
