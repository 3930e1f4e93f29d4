"""Files of a study, ranges of values, and hints at the intended value in messages."""

from pathlib import Path

import pytest

from sim.base.errors import InputError
from sim.base.yaml import read_yaml
from sim.study.entries import expand_range
from sim.study.load import load_study, parse_study

SERIES = "series: [{{name: {}, system: chute, base: {{depth: {}}}}}]\n"


@pytest.fixture
def study_path(tmp_path) -> Path:
    (tmp_path / "one.yaml").write_text("study: one\n" + SERIES.format("a", 2))
    (tmp_path / "two.yaml").write_text("study: two\n" + SERIES.format("b", 3))
    path = tmp_path / "study.yaml"
    path.write_text("study: s\nparts: [two.yaml, one.yaml]\n" + SERIES.format("c", 4))
    return path


def test_the_study_file_comes_first_and_its_parts_in_their_order(study_path):
    study = load_study(study_path, None)
    assert [one.name for one in study.files] == ["study.yaml", "two.yaml", "one.yaml"]
    assert list(study.series) == ["c", "b", "a"] and study.plugins == ()
    # A point of two of them is one.
    study_path.write_text("study: s\nparts: [two.yaml]\n" + SERIES.format("c", 3))
    (point,) = load_study(study_path, None).points.values()
    assert point.series == ("c", "b")


def test_a_part_is_validated_before_a_point_is_expanded(study_path):
    # A start is looked for once all points are known; the unknown key of a part is found before.
    base = "{name: c, system: chute, base: {start_from: none.nc}}"
    study_path.write_text(f"study: s\nparts: [one.yaml]\nseries: [{base}]\n")
    with pytest.raises(InputError, match=r"study\.yaml: start_from"):
        load_study(study_path, None)
    part = study_path.with_name("one.yaml")
    part.write_text("titles: x\n" + part.read_text())
    with pytest.raises(InputError, match=r"one\.yaml: titles: unknown key"):
        load_study(study_path, None)


def test_a_decimal_comma_within_braces_is_told(tmp_path: Path):
    path = tmp_path / "s.yaml"
    path.write_text("base: {friction: 0,3}\n")
    with pytest.raises(InputError, match="expected text as a key; a number has a decimal point"):
        read_yaml(path)


def points(grid: dict) -> list[str]:
    series = {"name": "a", "system": "chute", "grid": grid}
    return list(parse_study({"study": "s", "series": [series]}, "s.yaml", None).points)


@pytest.mark.parametrize(
    ("range_mapping", "values"),
    [
        ({"start": 0.3, "stop": 0.6, "step": 0.1}, [0.3, 0.4, 0.5, 0.6]),
        ({"start": 0.3, "stop": 0.65, "step": 0.1}, [0.3, 0.4, 0.5, 0.6]),
        ({"start": 0.6, "stop": 0.4, "step": -0.1}, [0.6, 0.5, 0.4]),
        ({"start": 1, "stop": 2, "num": 5}, [1, 1.25, 1.5, 1.75, 2]),
    ],
)
def test_a_range_is_the_list_of_its_values(range_mapping, values):
    assert points({"friction": range_mapping}) == points({"friction": values})


def test_whole_numbers_stay_whole_and_what_is_no_range_is_left_to_others():
    assert points({"seed": {"start": 1, "stop": 5, "num": 3}}) == points({"seed": [1, 3, 5]})
    assert expand_range([1, 2]) == [1, 2] and expand_range("a") == "a"
