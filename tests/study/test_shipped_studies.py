"""The study files in config/, studies made of parts, and beyond.yaml run tiny."""

import re
from dataclasses import replace
from pathlib import Path

import pytest
import xarray as xr
import yaml

from sim.base.errors import InputError
from sim.dataset.build import build
from sim.dataset.results import load_results
from sim.engine.run import run_point
from sim.figures.render import derive_texts
from sim.study.catalogue import FIGURES
from sim.study.load import load_study, parse_study
from tests.made.processes import ROOT

CONFIG = Path(__file__).parents[2] / "config"

HEADLINES = ["walton_2", "gallas_1a", "gallas_1b", "gallas_1c"]
REGIMES = [name for name, spec in FIGURES.items() if spec.regimes]


@pytest.mark.parametrize(
    ("name", "figures"),
    [
        ("quick", HEADLINES),
        ("paper", list(FIGURES)),
        ("regimes", REGIMES),
    ],
)
def test_shipped_studies_feed_their_figures(name, figures, tmp_path):
    study = load_study(CONFIG / f"{name}.yaml", tmp_path)
    assert study.name == name
    assert set(study.figures) >= set(figures)
    if name != "paper":  # whose controls of claims feed none
        assert set().union(*study.figures.values()) == set(study.points)


def test_the_reference_lists_every_study():
    """Its table has a row for each file."""
    rows = re.findall(r"^\| `(\w+\.yaml)` \|", (CONFIG / "README.md").read_text(), re.MULTILINE)
    assert sorted(rows) == sorted(path.name for path in CONFIG.glob("*.yaml"))


def test_shipped_studies_share_points_between_figures(tmp_path):
    study = load_study(CONFIG / "quick.yaml", tmp_path)
    a, b, c = (set(study.figures[f"gallas_1{panel}"]) for panel in "abc")
    assert a & b and b & c
    assert len(study.points) < sum(map(len, study.series.values()))


def test_the_paper_study_has_the_papers_sizes(tmp_path):
    study = load_study(CONFIG / "paper.yaml", tmp_path)
    points = [p.parameters for p in study.points.values()]
    bracketing = {name for name in study.series if name.startswith("onset")}
    belts = [
        p.parameters
        for p in study.points.values()
        if p.parameters.system == "belt" and not bracketing & set(p.series)
    ]
    assert all(p.replicates >= 3 and p.transient >= 45 and p.average >= 45 for p in belts)
    figure_belts = [p for p in belts if (p.beads, p.width) == (200, 20)]
    assert len(figure_belts) > 250 and sum(p.replicates >= 5 for p in figure_belts) > 200
    chutes = [p for p in points if p.system == "chute"]
    assert {(p.depth, p.cell) for p in chutes} >= {(10, 10), (20, 5), (40, 5)}
    assert {p.stiffness for p in chutes} == {100, 130, 200, 400, 1000, 10_000}
    base = [study.points[key].parameters for key in study.series["base"]]
    assert all(p.replicates >= 3 for p in base if p.depth <= 10)


def test_a_study_has_the_points_of_its_parts(tmp_path):
    study = load_study(CONFIG / "paper.yaml", tmp_path)
    halves = [
        load_study(CONFIG / f"paper_{paper}.yaml", tmp_path) for paper in ("walton", "gallas")
    ]
    # The halves decide claims, so that their points count looks.
    points = {
        name: replace(point, looks=0) for half in halves for name, point in half.points.items()
    }
    assert study.points == points
    assert study.series == halves[0].series | halves[1].series
    assert study.figures == halves[0].figures | halves[1].figures
    assert len(study.boundaries) == sum(len(half.boundaries) for half in halves)


def test_points_and_figures_of_parts_join_those_of_the_study(tmp_path):
    series = (
        "series: [{name: NAME, system: belt, grid: {frequency: [20, 30]}, figures: [gallas_1a]}]"
    )
    (tmp_path / "one.yaml").write_text("study: one\n" + series.replace("NAME", "a"))
    path = tmp_path / "two.yaml"
    path.write_text("study: two\nparts: [one.yaml]\n" + series.replace("NAME", "b"))
    study = load_study(path, tmp_path)
    assert len(study.points) == 2 and set(study.series) == {"a", "b"}
    assert all(point.series == ("b", "a") for point in study.points.values())
    assert study.figures == {"gallas_1a": tuple(study.points)}


@pytest.mark.parametrize(
    ("part", "message"),
    [
        ("absent.yaml", "absent.yaml"),
        ("nested.yaml", "parts[0]: got 'nested.yaml'; allowed: a study without parts of its own"),
        ("same.yaml", "series b: got 'same.yaml'; allowed: a part without a series of a name"),
        ("bad.yaml", "bad.yaml: series[0].base.frequency: got -1"),
    ],
)
def test_a_part_that_cannot_be_used_is_named(part, message, tmp_path):
    one = "series: [{name: b, system: belt, base: {frequency: FREQUENCY}}]"
    (tmp_path / "nested.yaml").write_text("study: n\nparts: [same.yaml]")
    (tmp_path / "same.yaml").write_text("study: s\n" + one.replace("FREQUENCY", "20"))
    (tmp_path / "bad.yaml").write_text("study: s\n" + one.replace("FREQUENCY", "-1"))
    path = tmp_path / "study.yaml"
    path.write_text(f"study: x\nparts: [{part}]\n" + one.replace("FREQUENCY", "30"))
    with pytest.raises(InputError, match=re.escape(message)):
        load_study(path, tmp_path)


@pytest.mark.parametrize("name", ["quick", "paper", "paper_walton", "paper_gallas", "regimes"])
def test_shipped_studies_mean_the_same_to_any_yaml_reader(name, tmp_path):
    path = CONFIG / f"{name}.yaml"
    plain = parse_study(yaml.safe_load(path.read_text()), path, tmp_path)
    assert plain.points == load_study(path, tmp_path).points


BEYOND = ROOT / "config" / "beyond.yaml"

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
    text, path = shrink_study(BEYOND.read_text()), folder / "beyond.yaml"
    rest_ids = [load_study(BEYOND, folder).series["rest"]]
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
    study = load_study(BEYOND, tmp_path)
    starts = {point.parameters.start_from for point in study.points.values()} - {""}
    assert starts == set(study.series["rest"])


@pytest.mark.long
def test_every_series_is_there(results):
    study, dataset, _ = results
    with xr.open_dataset(dataset) as table:
        assert set(table["point"].values) == set(study.points)
        assert (table["status"].values[:, 0] == "completed").all()


@pytest.mark.long
def test_every_plot_has_data_and_a_caption(results):
    """Each kind is drawn in tests/conformance/test_plots.py."""
    study, dataset, _ = results
    found = load_results(dataset)
    for name, spec in study.plots.items():
        table, caption = derive_texts(spec, found)
        assert len(table.splitlines()) > 1 and caption.strip(), name
