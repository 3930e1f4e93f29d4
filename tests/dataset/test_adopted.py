"""A study goes on from datasets: their points are not run, and the result is the same."""

import hashlib
import shutil
from pathlib import Path

import netCDF4
import numpy as np
import pytest
import xarray as xr

from sim.base.errors import InputError
from sim.dataset import adopted, rows, sources
from sim.dataset.adopted import adopt
from sim.dataset.build import build
from sim.dataset.results import load_results
from sim.engine.identity import NUMERICS
from sim.engine.run_file import read_stored_run
from sim.engine.stored_run import current_status, has_enough, is_reduced
from sim.figures.render import draw_figures
from sim.report.export import export
from sim.report.points import show
from sim.report.status import survey
from sim.study.load import load_study
from sim.surrogates.inquiries import write_round
from tests.made.folder import Folder
from tests.made.mixed import PATHS, SHOWN, Mixed, ids
from tests.made.netcdf import edit_file, store
from tests.made.processes import refusal, restore_plugins
from tests.made.runs import make_regimes, write_run

HALF, REST = (0, 1, 4), (2, 3, 5)


def read_groups(path: Path) -> dict[str, xr.Dataset]:
    """Return the groups of a dataset, without the column ``adopted``."""
    with xr.open_datatree(path) as tree:
        found = {node.path: node.to_dataset(inherit=False).load() for node in tree.subtree}
    found["/runs"] = found["/runs"].drop_vars("adopted")
    return found


def assert_same(one: Path, other: Path) -> None:
    first, second = read_groups(one), read_groups(other)
    assert list(first) == list(second)
    for name in first:
        xr.testing.assert_identical(first[name], second[name])


@pytest.fixture(scope="module")
def complete_study(tmp_path_factory) -> Mixed:
    """A study of all points with its dataset, made from run files."""
    study = Mixed(tmp_path_factory.mktemp("whole"))
    for number in range(6):
        study.write(number)
    study.build(*range(6), shown=PATHS)
    return study


@pytest.fixture(scope="module")
def half_dataset(tmp_path_factory) -> Path:
    """The dataset of an unfinished study that has half of its runs."""
    study = Mixed(tmp_path_factory.mktemp("half"))
    for number in HALF:
        study.write(number)
    study.save(*range(6), shown=PATHS)
    return build(study.path, study.results, finished=study.path.with_name("half.nc"))


@pytest.fixture
def study(tmp_path) -> Mixed:
    """The study in another folder, without any results."""
    study = Mixed(tmp_path)
    study.save(*range(6), shown=PATHS)
    return study


def adopted_ids(study: Mixed) -> set[str]:
    """Return the points whose run file is a row of a dataset that has what is wanted of them."""
    held = load_study(study.path, study.results)
    return {
        key
        for key, point in held.points.items()
        for path in [study.runs / f"{key}.nc"]
        if is_reduced(path, point.parameters) and has_enough(path, point.parameters, held.need(key))
    }


def test_a_study_goes_on_from_half_of_its_runs(study, half_dataset, complete_study):
    said = adopt(study.path, half_dataset, study.results)
    name = hashlib.sha256(half_dataset.read_bytes()).hexdigest()[:16]
    assert said == f"made: {half_dataset} covers 3 of 6 points; in {study.runs}, from {name}"
    assert adopt(study.path, half_dataset, study.results) == said
    assert adopted_ids(study) == set(ids(study, *HALF))
    status = survey(load_study(study.path, study.results), study.results)
    assert [status.counts[state] for state in ("done", "failed", "waiting")] == [2, 1, 3]
    shown = show(study.path, "table", results=study.results)
    assert "6 points, " in shown and "of which 3 have been run in" in shown
    assert status.totals["core_seconds"] == pytest.approx(1.5 * (1 + 3 + 2))
    for number in REST:
        study.write(number)
    build(study.path, study.results)
    assert_same(study.output, complete_study.output)
    # And again, from the earlier dataset where that has rows of run files.
    again = study.output.read_bytes()
    assert build(study.path, study.results).read_bytes() == again
    with netCDF4.Dataset(study.output) as file:
        names = file["runs"]["adopted"][:].tolist()
        adopted = {key for key, text in zip(file["point"][:], names, strict=True) if text == name}
    assert adopted == adopted_ids(study)


def test_a_dataset_of_adopted_points_alone_can_be_adopted(
    study, complete_study, tmp_path, monkeypatch
):
    """Several processes may read their rows, with what the figures show of particles."""
    adopt(study.path, complete_study.output, study.results)
    monkeypatch.setattr(sources, "MIN_FILES", 2)
    output = build(study.path, study.results, processes=2)
    assert_same(output, complete_study.output)
    other = Mixed(tmp_path / "other")
    other.path.parent.mkdir()
    other.save(*range(6), shown=PATHS)
    adopt(other.path, output, other.results)
    assert len(adopted_ids(other)) == 6


def test_a_run_file_gives_way_to_a_row_unless_it_holds_enough_or_something_else(
    study, complete_study
):
    adopt(study.path, complete_study.output, study.results)
    study.write(3, velocity=0.7)
    fewer, longer = study.points[5], study.points[4]
    write_run(study.runs, fewer.model_copy(update={"replicates": 1}))
    changed = {"replicates": longer.replicates - 1, "average": 2 * longer.average}
    write_run(study.runs, longer.model_copy(update=changed))
    adopt(study.path, complete_study.output, study.results)
    assert adopted_ids(study) == set(ids(study, 0, 1, 2, 5))


def test_a_point_of_which_more_is_wanted_is_run(study, complete_study):
    text = study.path.read_text()
    study.path.write_text(text.replace("'replicates': 4", "'replicates': 5"))
    assert "covers 5 of 6 points" in adopt(study.path, complete_study.output, study.results)
    point = ids(study, 5)[0]
    assert point not in adopted_ids(study)
    status = survey(load_study(study.path, study.results), study.results)
    assert status.points[point].state == "waiting"
    with pytest.raises(InputError, match=f"{point}.nc: no such run file"):
        build(study.path, study.results)
    # Another dataset may have it.
    study.path.write_text(text)
    assert "covers 6 of 6" in adopt(study.path, complete_study.output, study.results)


@pytest.mark.parametrize(
    ("made", "taken"),
    [({}, {*range(6)} - {SHOWN}), ({"shown": PATHS, "bare": HALF}, REST)],
    ids=["without particles", "without profiles"],
)
def test_a_point_of_which_more_is_shown_is_not_taken(made, taken, study, complete_study, tmp_path):
    other = Mixed(tmp_path / "other")
    shutil.copytree(complete_study.results, other.results)
    other.build_afresh(*range(6), **made)
    assert f"covers {len(taken)} of 6" in adopt(study.path, other.output, study.results)
    assert adopted_ids(study) == set(ids(study, *taken))


TIME_SERIES = "plots: [{name: p, kind: time_series, y: velocity, series: [s0]}]\n"


def test_what_reads_series_or_states_says_that_there_are_none(study, complete_study, tmp_path):
    adopt(study.path, complete_study.output, study.results)
    study.path.write_text(study.path.read_text().replace("series:", f"{TIME_SERIES}series:", 1))
    assert adopted_ids(study) == set(ids(study, 1, 2, 3, 4, 5))
    assert "covers 5 of 6" in adopt(study.path, complete_study.output, study.results)
    results, folder = study.output.parent, tmp_path / "figures"
    path = study.runs / f"{ids(study, 0)[0]}.nc"
    said = f"^{path}: only a row of a dataset that was adopted, without the series"
    build(study.path, study.results)
    with pytest.raises(InputError, match=said):
        draw_figures(["p"], study.output, folder, code="x", study_path=study.path)
    with pytest.raises(InputError, match=said):
        export(path, None, tmp_path / "x.xyz", 0)
    assert "only its row of dataset" in show(path, "table", results=results)
    assert read_stored_run(path, study.points[0]) is None
    assert not current_status(path, study.points[0])


def test_what_other_code_has_read_is_taken_if_it_knew_all_names(study, complete_study, monkeypatch):
    adopt(study.path, complete_study.output, study.results)
    monkeypatch.setattr(rows, "_package_hash", lambda: "other")
    assert len(adopted_ids(study)) == 6
    build(study.path, study.results)
    xr.testing.assert_identical(
        xr.load_dataset(study.output), xr.load_dataset(complete_study.output)
    )
    monkeypatch.setattr(adopted, "unknown_observables", lambda made, system: ["new_measure"])
    with pytest.raises(InputError, match="got 'a dataset that cannot have new_measure'; allowed"):
        adopt(study.path, complete_study.output, study.results)


def test_observables_that_the_writer_did_not_know_are_measured_from_the_rows(
    study, complete_study, tmp_path
):
    """What takes the velocity has its value; what takes paths of particles has none."""
    older, gone = tmp_path / "older.nc", {"transport_efficiency", "path_drift"}
    with xr.open_datatree(complete_study.output) as tree:
        groups = tree.load()
    groups.dataset = groups.to_dataset().drop_vars(gone)
    runs = groups["/runs"].to_dataset()
    of_rows = [" ".join({*row.split()} - gone) for row in runs["variables"].values]
    runs["variables"] = ("point", np.array(of_rows, object))
    runs.attrs["reads"] = " ".join({*runs.attrs["reads"].split()} - gone)
    groups["/runs"].dataset = runs
    store(groups, older)
    adopt(study.path, older, study.results)
    assert len(adopted_ids(study)) == 6
    build(study.path, study.results)
    new, whole = (load_results(one.output).dataset for one in (study, complete_study))
    assert all(np.isfinite(whole[name]).any() for name in gone)
    np.testing.assert_allclose(new["transport_efficiency"], whole["transport_efficiency"])
    assert np.isnan(new["path_drift"]).all()


def test_an_observable_of_one_system_keeps_no_other_from_being_adopted(
    study, complete_study, tmp_path
):
    (tmp_path / "mine.py").write_text(
        "import sim\n@sim.observable('answer', system='chute', unit='1', meaning='m')\n"
        "def answer(run):\n    return 42\n"
    )
    adopt(study.path, complete_study.output, study.results)
    assert len(adopted_ids(study)) == 6
    study.path.write_text(study.path.read_text() + "plugins: [mine.py]\n")
    with restore_plugins():
        assert adopted_ids(study) == set(ids(study, 3, 4, 5))
        with pytest.raises(InputError, match="without the series, particles or observables"):
            build(study.path, study.results)
        assert "covers 3 of 6 points" in adopt(study.path, complete_study.output, study.results)
        assert adopted_ids(study) == set(ids(study, 3, 4, 5))


def test_what_a_point_starts_from_is_run_with_it(tmp_path):
    text = "study: made\nseries: [{name: beds, system: belt, cases: [{frequency: 20}%s]}]\n"
    folder = Folder(tmp_path, text % "")
    (first,) = folder.ids
    case = f", {{frequency: 40, start_from: {first}}}"
    both = Folder(tmp_path, text % case)
    _, then = both.ids
    for key in both.ids:
        both.finish(key)
    dataset = build(both.file, both.results, finished=tmp_path / "both.nc")
    alone = Folder(tmp_path, text % "")
    one = build(alone.file, alone.results, finished=tmp_path / "one.nc")
    for name, path, expected in (("a", one, set()), ("b", dataset, {first, then})):
        other = tmp_path / name
        other.mkdir()
        fresh = Folder(other, text % case)
        adopt(fresh.file, path, fresh.results)
        found = {key for key, at in fresh.survey().points.items() if at.state == "done"}
        assert found == expected


def test_what_cannot_be_used_is_refused(study, complete_study, tmp_path, monkeypatch, capsys):
    def assert_refused(study: Mixed, dataset: Path, *words: str) -> None:
        monkeypatch.chdir(study.results.parent)
        line = refusal(capsys, "adopt", study.path, dataset)
        assert all(word in line for word in (str(dataset), *words)), line
        assert not study.results.exists()

    content = complete_study.output.read_bytes()
    path = tmp_path / "bad.nc"
    assert_refused(study, path, "no such dataset")
    for bad in (b"", content[: len(content) // 2], content[:-1], content + b"x"):
        path.write_bytes(bad)
        assert_refused(study, path, "checksum")
    store(xr.Dataset({"depth": 1.0}), path)
    assert_refused(study, path, "not a dataset (no study in it)")
    run = next(complete_study.runs.glob("*.nc"))
    assert_refused(study, run, "not a dataset (no study in it)")
    path.write_bytes(content)
    with edit_file(path) as file:
        file["runs"].renameVariable("wanted", "unknown")
    assert_refused(study, path, "how much of each point")
    path.write_bytes(content)
    with edit_file(path) as file:
        file.numerics = str(NUMERICS + 1)
    assert_refused(study, path, f"numerics: got '{NUMERICS + 1}'; allowed: {NUMERICS}")
    study.path.write_text("study: made\nseries: [{name: a, system: chute, cases: [{depth: 7}]}]\n")
    assert_refused(study, complete_study.output, "covers no point of", "of 1 point it has 0")
    text = "study: made\nseries: [{name: a, system: chute, cases: [{depth: 2, replicates: 9}]}]\n"
    study.path.write_text(text)
    assert_refused(study, complete_study.output, "of 1 point it has 1, none with all")


def test_rows_of_other_numerics_are_not_taken(study, tmp_path):
    made = Mixed(tmp_path / "made")
    made.write(0)
    write_run(made.runs, made.points[3], numerics=NUMERICS + 1)
    made.build(0, 3)
    assert "covers 1 of 6" in adopt(study.path, made.output, study.results)
    assert adopted_ids(study) == set(ids(study, 0))


def test_a_row_that_is_damaged_later_is_set_aside_and_its_point_is_run(study, complete_study):
    adopt(study.path, complete_study.output, study.results)
    point = ids(study, 2)[0]
    there = study.runs / f"{point}.nc"
    content = there.read_bytes()
    there.write_bytes(content[: len(content) // 2] + content[len(content) // 2 + 1 :])
    with pytest.raises(InputError, match=f"now {there.name}.damaged: rerun the study"):
        build(study.path, study.results)
    assert adopted_ids(study) == set(ids(study, 0, 1, 3, 4, 5))
    adopt(study.path, complete_study.output, study.results)
    assert there.read_bytes() == content


def test_what_has_finished_is_written_beside_nothing_else(study, tmp_path):
    output = tmp_path / "new" / "half.nc"
    with pytest.raises(InputError, match="no point has a run file with all"):
        build(study.path, study.results, finished=output)
    assert not output.parent.exists()
    for number in HALF:
        study.write(number)
    write_run(study.runs, study.points[5].model_copy(update={"replicates": 1}))
    damaged = study.write(3)
    damaged.write_bytes(damaged.read_bytes()[:-1])
    build(study.path, study.results, finished=output)
    results = load_results(output)
    assert set(results.dataset["point"].values) == set(ids(study, *HALF))
    assert not study.output.exists() and damaged.exists()
    with pytest.raises(InputError, match="a file that is not there yet"):
        build(study.path, study.results, finished=output)
    with pytest.raises(InputError, match="a file that is not among the runs"):
        build(study.path, study.results, finished=study.runs / "half.nc")


def test_boundaries_refine_by_adopted_points(tmp_path):
    path, results = make_regimes(tmp_path)
    rounds = load_study(path, results).rounds
    for number in range(1, rounds + 1):
        write_round(path, number, results)
    finished = build(path, results, finished=tmp_path / "regimes.nc")
    with netCDF4.Dataset(build(path, results)) as file, netCDF4.Dataset(finished) as other:
        assert set(other["point"][:]) == set(file["point"][:])
    fresh = tmp_path / "fresh"
    adopt(path, finished, fresh)
    for number in range(1, rounds + 1):
        made = write_round(path, number, fresh)
        assert made.read_text() == (results / "regimes" / "rounds" / made.name).read_text()
    assert_same(build(path, fresh), results / "regimes" / "dataset.nc")
    status = survey(load_study(path, fresh), fresh)
    assert status.is_over and status.counts["done"] == len(status.points)
