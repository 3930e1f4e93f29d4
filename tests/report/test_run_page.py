"""The page of a run: what came out of it, its pictures, how to run it alone."""

import base64
import re
import shutil
from html import unescape
from io import BytesIO
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from PIL import Image

from sim.__main__ import main
from sim.parameters import BeltParameters, ChuteParameters, Parameters, load_point
from sim.report.run_page import unusual_parameters
from tests.made.processes import refusal
from tests.made.runs import FAILURE, HEIGHTS, write_run

CHUTE = ChuteParameters(depth=1, cell=4, friction=0.3, replicates=3, orientations=False)
BELT = BeltParameters(beads=5, width=6, frequency=62.5)


def particles(point: Parameters) -> dict:
    """First and last state of some particles, one of them far outside the cell."""
    axes = ["x", "y", "z"] if point.system == "chute" else ["x", "z"]
    rng = np.random.default_rng(3)
    shape = (point.replicates, 2, point.particles, len(axes))
    place = point.diameter * rng.uniform(0.5, 4, shape)
    place[..., 0, 0] += 7 * point.period
    over = ("replicate", "frame", "particle", "axis")
    return {
        "axis": ("axis", axes),
        "position": (over, place),
        "particle_velocity": (over, rng.normal(size=shape)),
        "packing_profile": (("replicate", "height"), rng.uniform(size=(shape[0], HEIGHTS))),
        "radius": (over[::2], np.full(shape[::2], point.diameter / 2)),
    }


def page_of(path: Path, folder: Path) -> str:
    assert main(["page", str(path), "--output", str(folder)]) == 0
    return (folder / f"{path.stem}.html").read_text(encoding="utf-8")


@pytest.mark.parametrize("point", [CHUTE, BELT], ids=lambda point: point.system)
def test_a_page_tells_a_run_and_shows_it(point, tmp_path):
    path = write_run(tmp_path / "runs", point, arrays=particles(point))
    (tmp_path / "logs" / "runs").mkdir(parents=True)
    (tmp_path / "logs" / "runs" / f"{path.stem}.log").write_text("first <b>line</b>\nlast line\n")
    text = page_of(path, tmp_path / "pages")
    assert text.count('<tr><th scope="row" class="number">') == point.replicates
    pictures = re.findall(r'src="data:image/svg\+xml;base64,([^"]+)"', text)
    assert len(pictures) == 3
    for picture in pictures:
        assert ElementTree.fromstring(base64.b64decode(picture)).tag.endswith("svg")
    assert "first &lt;b&gt;line" in text
    code = unescape(re.search(r'aria-label="Point file"><code>(.*?)</code>', text, re.S)[1])
    (tmp_path / "again.yaml").write_text(code)
    assert load_point(tmp_path / "again.yaml") == point


@pytest.mark.parametrize("lost", [0, 2])
def test_a_trajectory_plays_up_to_where_it_is_known(lost, tmp_path):
    held = particles(BELT)
    frames = np.random.default_rng(4).uniform(1e-3, 4e-3, (1, 5, BELT.particles, 2))
    frames[:, 5 - lost :] = np.nan
    over = ("replicate", "trajectory_time", "particle", "axis")
    held |= {"trajectory_time": ("trajectory_time", np.arange(5.0))}
    held |= {f"trajectory_{name}": (over, frames) for name in ("position", "velocity")}
    text = page_of(write_run(tmp_path / "runs", BELT, arrays=held), tmp_path)
    (found,) = re.findall(r'src="data:image/webp;base64,([^"]+)"', text)
    assert Image.open(BytesIO(base64.b64decode(found))).n_frames == 5 - lost


def test_a_page_says_what_differs_from_the_paper():
    assert unusual_parameters(BELT) == "f = 62.5 Hz, N = 5, L = 6 ⟨d⟩"
    assert unusual_parameters(BeltParameters()) == "all as in the paper"
    assert unusual_parameters(CHUTE) == "replicates = 3, n = 1, μ = 0.3, L = 4 σ, no orientations"


def test_a_run_of_which_nothing_completed_has_a_page_without_pictures(tmp_path):
    path = write_run(tmp_path / "runs", BELT, failed=[0])
    text = page_of(path, tmp_path)
    assert FAILURE in text and "No replicate completed" in text


def test_a_page_is_made_again_where_the_run_or_the_code_has_changed(tmp_path):
    one, other = (write_run(tmp_path / "runs", point) for point in (CHUTE, BELT))
    command = ["page", str(one), str(other), "--output", str(tmp_path), "--code"]

    def made(code: str) -> list[int]:
        assert main([*command, code]) == 0
        return [(tmp_path / f"{path.stem}.html").stat().st_mtime_ns for path in (one, other)]

    first = made("a")
    assert made("a") == first
    write_run(tmp_path / "runs", CHUTE, 0.7)
    second = made("a")
    assert second[0] != first[0] and second[1] == first[1]
    assert not set(made("b")) & set(second)


def test_what_is_no_run_is_refused_in_one_line(tmp_path, capsys):
    (tmp_path / "odd.nc").write_bytes(b"no netCDF")
    line = refusal(capsys, "page", tmp_path / "odd.nc", "-o", tmp_path)
    assert "odd.nc: damaged or not a run file" in line
    assert not list(tmp_path.glob("*.html"))


def test_what_is_no_page_is_not_overwritten(tmp_path, capsys):
    path = write_run(tmp_path / "runs", BELT)
    for name in ("run.html", "run.nc"):
        shutil.copy(path, tmp_path / name)
    before = (tmp_path / "run.html").read_bytes()
    for run in ("run.html", "run.nc"):
        line = refusal(capsys, "page", tmp_path / run, "-o", tmp_path)
        assert "run.html: is there already, and is no page" in line
    assert (tmp_path / "run.html").read_bytes() == before


def test_two_runs_of_one_name_are_refused(tmp_path, capsys):
    runs = [tmp_path / folder / "run.nc" for folder in "ab"]
    assert "runs of different names" in refusal(capsys, "page", *runs, "-o", tmp_path)
