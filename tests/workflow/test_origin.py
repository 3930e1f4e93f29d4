"""A point that starts from another of its study is run after that, in a process of its own."""

import netCDF4

from sim.study.load import load_study
from tests.made.project import planned_jobs, planned_points, points, snakemake

STUDY = """\
study: origin
series:
  - name: beds
    system: belt
    base: {{beads: 5, width: 5, transient: 1, average: 1}}
    cases: [{{frequency: 20}}{case}]
"""


BRACES = """\
study: braces
readings: {belt: {damping_mass: [own, reduced]}}
series: [{name: a, system: belt, grid: {frequency: [20, 50]}, figures: [readings_1a]}]
"""


def test_the_other_runs_first(tmp_path):
    file = tmp_path / "origin.yaml"
    file.write_text(STUDY.format(case=""))
    (first,) = load_study(file, tmp_path).points
    file.write_text(STUDY.format(case=f", {{frequency: 40, start_from: {first}}}"))
    _, then = load_study(file, tmp_path).points
    assert planned_points(tmp_path, "runs", study="origin.yaml") == {first, then}
    process = snakemake(tmp_path, "runs", study="origin.yaml")
    assert process.returncode == 0, process.stderr
    assert points(process.stdout + process.stderr) == [first, then]
    runs = tmp_path / "results" / "origin" / "runs"
    assert all((runs / f"{point}.nc").exists() for point in (first, then))
    # Longer, the first one ends elsewhere, and so does what starts from it.
    text = file.read_text()
    file.write_text(text.replace("{frequency: 20}", "{frequency: 20, average: 3}"))
    process = snakemake(tmp_path, "runs", study="origin.yaml")
    assert process.returncode == 0, process.stderr
    with (
        netCDF4.Dataset(runs / f"{first}.nc") as source,
        netCDF4.Dataset(runs / f"{then}.nc") as run,
    ):
        assert run.origin == str(source.dimensions["time"].size)
    assert planned_points(tmp_path, "runs", study="origin.yaml") == set()


def test_braces_in_an_entry_of_the_catalogue_are_no_wildcards(tmp_path):
    (tmp_path / "braces.yaml").write_text(BRACES)
    assert planned_jobs(tmp_path, study="braces.yaml")["figures"] == 1
