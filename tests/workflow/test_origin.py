"""A point that starts from another of its study is run after that, in a process of its own."""

from sim.study.load import load_study
from tests.made.project import planned_points, points, snakemake

STUDY = """\
study: origin
series:
  - name: beds
    system: belt
    base: {{beads: 5, width: 5, transient: 1, average: 1}}
    cases: [{{frequency: 20}}{case}]
"""


def test_the_other_runs_first(tmp_path):
    file = tmp_path / "origin.yaml"
    file.write_text(STUDY.format(case=""))
    (first,) = load_study(file, tmp_path).points
    file.write_text(STUDY.format(case=f", {{frequency: 40, start_from: {first}}}"))
    _, then = load_study(file, tmp_path).points
    assert planned_points(tmp_path, "runs", study="origin.yaml") == {first, then}
    done = snakemake(tmp_path, "runs", study="origin.yaml")
    assert done.returncode == 0, done.stderr
    assert points(done.stdout + done.stderr) == [first, then]
    runs = tmp_path / "results" / "origin" / "runs"
    assert all((runs / f"{point}.nc").exists() for point in (first, then))
