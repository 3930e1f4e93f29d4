"""Run files that points start from are checked before any job runs."""

from pathlib import Path

import pytest

from sim.__main__ import main
from sim.dataset.build import build
from tests.made.folder import Folder
from tests.made.project import snakemake

STUDY = """\
study: made
series: [{name: a, system: chute, base: {depth: 2, replicates: 2}, cases: %s}]
"""


@pytest.fixture
def source(tmp_path) -> Folder:
    """A study with a run of two replicates and its dataset."""
    (tmp_path / "source").mkdir()
    made = Folder(tmp_path / "source", STUDY % "[{}]")
    made.finish(made.ids[0])
    build(made.file, made.results)
    return made


def study(folder: Path, start: Path, more: str = "") -> Path:
    path = folder / "s.yaml"
    path.write_text(STUDY % f"[{{start_from: {start}, angle: 20{more}}}]")
    return path


def test_a_start_file_that_fits_is_accepted(source, tmp_path, capsys):
    (start,) = source.runs.glob("*.nc")
    assert main(["points", str(study(tmp_path, start))]) == 0


@pytest.mark.parametrize(
    ("more", "said"),
    [
        (", depth: 3", "allowed: a run with depth = 3.0"),
        (", replicates: 3", "allowed: a run of 3 replicates or more"),
        ("dataset.nc", "the dataset of study made, not a run file"),
        ("noise.nc", "noise.nc: damaged or not a run file"),
    ],
)
def test_one_that_does_not_fit_is_refused_at_once(source, tmp_path, more, said, capsys):
    (start,) = source.runs.glob("*.nc")
    if more == "dataset.nc":
        start, more = source.results / "made" / more, ""
    elif more == "noise.nc":
        start, more = tmp_path / more, ""
        start.write_bytes(bytes(range(256)) * 10)
    path = study(tmp_path, start, more)
    assert main(["points", str(path)]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith(f"error: {path}: start_from: ") and said in line
    assert start.exists()


def test_the_workflow_refuses_it_before_any_job(source, tmp_path):
    path = study(tmp_path, source.results / "made" / "dataset.nc")
    done = snakemake(tmp_path, "runs", study=path.name)
    assert done.returncode == 2
    assert "error: s.yaml: start_from: " in done.stderr and "Job stats" not in done.stderr
