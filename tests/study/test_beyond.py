"""The study of the open questions of the papers, run tiny: every series, plot and start."""

import re

import pytest
import xarray as xr
import yaml

from sim.dataset.build import build
from sim.engine.run import run_point
from sim.figures.render import render
from sim.study.load import load_study
from tests.made.processes import ROOT

STUDY = ROOT / "config" / "beyond.yaml"

#: Smallest and shortest parameters of each system.
TINY = {
    "chute": {"cell": 3, "protocol": "published", "transient": 1, "average": 2, "replicates": 1},
    "conveyor": {"cell": 4, "transient": 1, "average": 1, "replicates": 1},
}
STARTS = re.compile(r"chute-depth\S+-[0-9a-f]{8}")


def shrink_study(text: str) -> str:
    """Return the study with only the ends of each range, shallow and short."""
    mapping = yaml.safe_load(text)
    for series in mapping["series"]:
        series["base"] = series.get("base", {}) | TINY[series["system"]]
        grid = series["grid"]
        for name, values in grid.items():
            grid[name] = [values["start"], values["stop"]] if isinstance(values, dict) else values
            grid[name] = list(dict.fromkeys([grid[name][0], grid[name][-1]]))
        if "depth" in grid:
            grid["depth"] = [1, 1.5]
        else:
            series["base"]["depth"] = 0.5 if series["base"].get("depth") == 2 else 1
    return yaml.safe_dump(mapping, sort_keys=False)


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    """Results of the tiny study."""
    folder = tmp_path_factory.mktemp("beyond")
    text, path = shrink_study(STUDY.read_text()), folder / "beyond.yaml"
    rest_ids = [load_study(STUDY, folder).series["rest"]]
    path.write_text(STARTS.sub("''", text[: text.index("plots:")]))
    rest_ids.append(load_study(path, folder).series["rest"])
    for before, after in zip(*rest_ids, strict=True):
        text = text.replace(before, after)
    path.write_text(text)
    study, runs = load_study(path, folder), folder / "beyond" / "runs"
    runs.mkdir(parents=True)
    for key in sorted(study.points, key=lambda key: bool(study.points[key].parameters.start_from)):
        assert run_point(study.points[key].parameters, runs / f"{key}.nc", quiet=True) == 0
    return study, build(path, folder), folder


def test_beds_at_rest_are_what_the_tilted_ones_start_from(tmp_path):
    study = load_study(STUDY, tmp_path)
    starts = {point.parameters.start_from for point in study.points.values()} - {""}
    assert starts == set(study.series["rest"])


def test_every_series_is_there(results):
    study, dataset, _ = results
    with xr.open_dataset(dataset) as table:
        assert set(table["point"].values) == set(study.points)
        assert (table["status"].values[:, 0] == "completed").all()


def test_every_plot_is_drawn(results):
    study, dataset, folder = results
    for name, spec in study.plots.items():
        files = render(spec, dataset, folder)
        assert {file.name for file in files} >= {f"{name}.png", f"{name}.csv"}
        data = (folder / f"{name}.csv").read_text().splitlines()
        assert len(data) > 1, name
