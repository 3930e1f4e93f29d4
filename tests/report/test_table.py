"""The table of a study in Python and as a file, and a study in one call."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import yaml

import sim
from sim.__main__ import main
from sim.report.table import TABLES
from tests.made.figures import make_built_study
from tests.made.processes import refusal
from tests.made.results import made_point
from tests.report.test_results import BELT, GRID, results_of

SHEAR = made_point("chute", {"velocity": [0.5, 0.7], "base_shear": [2e-3, 4e-3]}, replicates=2)


def test_a_row_has_what_varies_then_how_sure_it_is_then_means_with_intervals():
    table = results_of(*GRID).table()
    assert table.columns[:5].tolist() == [
        *("depth [1]", "friction [1]", "regime", "caveats", "replicates"),
    ]
    assert table.columns[-1] == "point" and len(table) == len(GRID)
    row = table[(table["depth [1]"] == 2) & (table["friction [1]"] == 0.4)].iloc[0]
    assert row["velocity [m s-1]"] == pytest.approx(0.8) and row["regime"] == "steady"
    found = results_of(*GRID)
    same = found.dataset.point_half_width.sel(point=row["point"]).item()
    assert row["velocity half width [m s-1]"] == pytest.approx(same)


def test_any_number_can_be_asked_for_in_a_unit_of_ones_own():
    asked = ["base_shear (mN)", "velocity (km/h)"]
    table = results_of(SHEAR, *GRID).table(of=asked)
    assert [name for name in table if "velocity" in name or "shear" in name] == [
        *("base_shear [mN]", "base_shear half width [mN]"),
        *("velocity [km/h]", "velocity half width [km/h]"),
    ]
    row = table[table["point"] == SHEAR.id].iloc[0]
    assert row["base_shear [mN]"] == pytest.approx(3)
    assert row["velocity [km/h]"] == pytest.approx(0.6 * 3.6)
    # Student's t for two values 1 mN from their mean.
    assert row["base_shear half width [mN]"] == pytest.approx(12.706, rel=1e-3)


def test_several_systems_have_a_column_that_tells_them_apart():
    found = results_of(*GRID, BELT)
    table = found.table(of=["velocity"])
    assert table["system"].tolist() == ["chute"] * len(GRID) + ["belt"]
    assert np.isfinite(table["velocity [m s-1]"]).all()
    assert "system" not in found.table(system="belt") and len(found.table(system="belt")) == 1


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"of": ["velocty"]}, "table: observable: got 'velocty'; did you mean velocity?"),
        ({"of": ["velocity (kg)"]}, "table: unit of velocity: got 'kg'; allowed: a unit such as m"),
        ({"system": "belt"}, "system: got 'belt'; allowed: one of chute"),
        ({"series": "mine"}, "series: got 'mine'; allowed: one of chute"),
        ({"name": "mine"}, "table: got 'mine'"),
    ],
)
def test_what_a_table_cannot_have_is_refused(keys, message):
    with pytest.raises(sim.InputError) as error:
        results_of(*GRID).table(**keys)
    assert message in str(error.value)


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    folder = tmp_path_factory.mktemp("made")
    make_built_study(folder)
    return folder / "results" / "made"


@pytest.mark.parametrize("to", TABLES)
def test_a_file_has_the_same_table(results, to, tmp_path, capsys):
    output, asked = tmp_path / "new" / f"mine.{to}", ["--of", "velocity (mm/s)"]
    assert main(["export", str(results), "-o", str(output), *asked]) == 0
    read = pd.read_csv(output) if to == "csv" else pd.read_excel(output)
    table = sim.load(results).table(of=["velocity (mm/s)"])
    assert capsys.readouterr().out.startswith(f"{output}: {len(table)} points, ")
    # A file has no difference between an empty text and none.
    table = table.replace("", np.nan)
    pd.testing.assert_frame_equal(read, table, check_dtype=False, rtol=1e-8)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (
            ["--to", "csv", "-o", "there.xlsx"],
            "got 'there.xlsx'; allowed: a name that ends in .csv",
        ),
        (["--of", "velocity (kg/h)", "-o", "new.csv"], "unit of velocity: got 'kg/h'"),
        (["-o", "there.ods"], "--to: got '.ods'; allowed: one of amber,"),
        (["--to", "vtk", "--of", "velocity"], "--of: got 'velocity'; allowed: --to csv or xlsx"),
    ],
)
def test_files_that_cannot_be_are_refused(results, words, message, capsys):
    assert message in refusal(capsys, "export", results, *words)


STUDY = {
    "study": "tiny",
    "series": [
        {
            "name": "speeds",
            "system": "belt",
            "base": {"beads": 4, "width": 5, "transient": 1, "average": 2, "replicates": 2},
            "grid": {"frequency": [20, 30]},
        }
    ],
}


def test_a_mapping_is_run_in_one_call_and_grows(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    found = sim.study(STUDY, cores=1)
    assert found.table()["frequency [Hz]"].tolist() == [20, 30]
    assert "report.html" in capsys.readouterr().out
    assert yaml.safe_load(Path("tiny.yaml").read_text()) == STUDY
    runs = {path: path.stat().st_mtime_ns for path in Path("results/tiny/runs").glob("*.nc")}
    (series,) = STUDY["series"]
    more = STUDY | {"series": [series | {"grid": {"frequency": [20, 30, 40]}}]}
    assert len(sim.study(more, cores=1).table()) == 3
    assert len(runs) == 2 and all(path.stat().st_mtime_ns == time for path, time in runs.items())


def test_a_mapping_replaces_no_file_of_somebody_else(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("tiny.yaml").write_text("mine")
    with pytest.raises(sim.InputError, match="got 'tiny'; allowed: another name: tiny"):
        sim.study(STUDY)
    with pytest.raises(sim.InputError, match=r"none\.yaml: no such file"):
        sim.study("none.yaml")
    assert Path("tiny.yaml").read_text() == "mine"
