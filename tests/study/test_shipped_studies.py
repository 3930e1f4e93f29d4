"""The study files in config/, and studies made of parts."""

import re
from dataclasses import replace
from functools import cache
from pathlib import Path

import pytest
import yaml

from sim.study.figure_spec import FIGURES
from sim.study.load import load_study, parse_study

CONFIG = Path(__file__).parents[2] / "config"

HEADLINES = ["walton_2", "gallas_1a", "gallas_1b", "gallas_1c"]
SILBERT = [name for name in FIGURES if name.startswith("silbert_")]
BOTH = [name for name in FIGURES if name not in SILBERT]
REGIMES = [name for name in BOTH if FIGURES[name].keys.is_map]


@pytest.fixture(scope="module")
def shipped(tmp_path_factory):
    """Return a shipped study by its name, read once."""
    folder = tmp_path_factory.mktemp("results")
    return cache(lambda name: load_study(CONFIG / f"{name}.yaml", folder))


@pytest.mark.parametrize(
    ("name", "figures"),
    [("quick", HEADLINES), ("paper", BOTH), ("regimes", REGIMES), ("paper_silbert", SILBERT)],
)
def test_shipped_studies_feed_their_figures(name, figures, shipped):
    study = shipped(name)
    assert study.name == name
    assert set(study.figures) >= set(figures)
    rows = re.findall(r"^\| `(\w+\.yaml)` \|", (CONFIG / "README.md").read_text(), re.MULTILINE)
    assert sorted(rows) == sorted(path.name for path in CONFIG.glob("*.yaml"))
    if name != "paper":  # whose controls of claims feed none
        assert set().union(*study.figures.values()) == set(study.points)


def test_a_study_has_the_points_of_its_parts(shipped):
    study, *halves = map(shipped, ("paper", "paper_walton", "paper_gallas"))
    # The halves decide claims, so that their points count looks.
    points = halves[0].points | halves[1].points
    assert study.points == {name: replace(point, looks=0) for name, point in points.items()}
    assert study.series == halves[0].series | halves[1].series
    assert study.figures == halves[0].figures | halves[1].figures
    assert len(study.boundaries) == sum(len(half.boundaries) for half in halves)


@pytest.mark.parametrize("name", ["quick", "paper_walton", "paper_gallas", "regimes"])
def test_shipped_studies_mean_the_same_to_any_yaml_reader(name, shipped, tmp_path):
    path = CONFIG / f"{name}.yaml"
    plain = parse_study(yaml.safe_load(path.read_text()), path, tmp_path)
    assert plain.points == shipped(name).points


def test_beds_at_rest_are_what_the_tilted_ones_start_from(shipped):
    study = shipped("beyond")
    starts = {point.parameters.start_from for point in study.points.values()} - {""}
    assert starts == set(study.series["rest"])
