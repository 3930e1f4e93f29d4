"""Files of a study, ranges of values, and hints at the intended value in messages."""

from pathlib import Path

import pytest

from sim.base.errors import InputError
from sim.base.yaml import read_yaml
from sim.study.entries import MAX_VALUES, expand_range
from sim.study.load import load_study, parse_study
from sim.study.read import read

SERIES = "series: [{{name: {}, system: chute, base: {{depth: {}}}}}]\n"


@pytest.fixture
def study_path(tmp_path) -> Path:
    (tmp_path / "one.yaml").write_text("study: one\n" + SERIES.format("a", 2))
    (tmp_path / "two.yaml").write_text("study: two\n" + SERIES.format("b", 3))
    path = tmp_path / "study.yaml"
    path.write_text("study: s\nparts: [two.yaml, one.yaml]\n" + SERIES.format("c", 4))
    return path


def test_the_study_file_comes_first_and_its_parts_in_their_order(study_path):
    documents = read(study_path)
    assert [one.path.name for one in documents] == ["study.yaml", "two.yaml", "one.yaml"]
    assert [one.contents["study"] for one in documents] == ["s", "two", "one"]
    assert [one.plugins for one in documents] == [(), (), ()]


@pytest.mark.parametrize("parts", ["one.yaml", "[1]", "[-]", "[../one.yaml]", "[one.yaml, a/b]"])
def test_malformed_names_of_parts_are_not_read_but_refused(study_path, parts):
    study_path.write_text(f"study: s\nparts: {parts}\n")
    assert len(read(study_path)) == 1
    with pytest.raises(InputError, match=r"study\.yaml: parts"):
        load_study(study_path, None)


def test_a_part_is_validated_before_a_point_is_expanded(study_path):
    # Pages are too many once all points are known; the unknown key of a part is found before.
    grid = "{name: c, system: chute, grid: {seed: {start: 1, stop: 1001, step: 1}}}"
    study_path.write_text(f"study: s\npages: true\nparts: [one.yaml]\nseries: [{grid}]\n")
    with pytest.raises(InputError, match=r"study\.yaml: pages"):
        load_study(study_path, None)
    part = study_path.with_name("one.yaml")
    part.write_text("titles: x\n" + part.read_text())
    with pytest.raises(InputError, match=r"one\.yaml: titles: unknown key"):
        load_study(study_path, None)


def error_message(**series) -> str:
    mapping = {"study": "s", "series": [{"name": "a", "system": "chute"} | series]}
    with pytest.raises(InputError) as caught:
        parse_study(mapping, "s.yaml", None)
    return str(caught.value).removeprefix("s.yaml: series[0].")


@pytest.mark.parametrize(
    ("series", "message"),
    [
        (
            {"base": {"friction": [0.3, 0.4]}},
            "base.friction: got [0.3, 0.4]; allowed: a number >= 0; a list of values belongs under "
            "grid",
        ),
        (
            {"grid": {"frequency": [3]}},
            "grid.frequency: unknown key, got [3]; frequency is a parameter of the belt and the "
            "conveyor",
        ),
        (
            {"grid": {"mu": [3]}},
            "grid.mu: unknown key, got [3]; did you mean friction? allowed: 46 names "
            "(talus schema has all)",
        ),
        (
            {"base": {"depth": "lhs(1,20,10)"}},
            "base.depth: got 'lhs(1,20,10)'; allowed: a number > 0; points spread over ranges "
            "belong under design (docs/designs.md)",
        ),
        (
            {"system": "chut"},
            "system: got 'chut'; did you mean chute? allowed: one of chute, belt, conveyor",
        ),
        (
            {"friction": 3},
            "friction: unknown key, got 3; parameters belong under base, grid or cases",
        ),
        (
            {"figures": ["gallas_1a"]},
            "figures[0]: got 'gallas_1a'; allowed: a figure of the chute; gallas_1a is one of the "
            "belt",
        ),
        (
            {"base": {"friction": "0,3"}},
            "base.friction: got '0,3'; allowed: a number >= 0; a number has a decimal point, not a "
            "comma",
        ),
    ],
)
def test_a_message_says_what_was_meant(series, message):
    assert error_message(**series) == message


@pytest.mark.parametrize(
    ("others", "message"),
    [
        (
            {"decide": {"budget": 1, "claims": ["ZZ"]}},
            "decide.claims[0]: got 'ZZ'; allowed: W1 to W26, G1 to G36, all, or the name of a "
            "judge of a plug-in",
        ),
        ({"parts": [1]}, "parts[0]: got 1; allowed: a file's name"),
    ],
)
def test_a_message_on_an_entry_of_a_list_says_what_an_entry_may_be(others, message):
    mapping = {"study": "s", "series": [{"name": "a", "system": "chute"}]} | others
    with pytest.raises(InputError) as caught:
        parse_study(mapping, "s.yaml", None)
    assert str(caught.value) == f"s.yaml: {message}"


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


def test_whole_numbers_stay_whole():
    assert points({"seed": {"start": 1, "stop": 5, "num": 3}}) == points({"seed": [1, 3, 5]})


@pytest.mark.parametrize(
    ("range_mapping", "message"),
    [
        ({"start": 1, "num": 4}, "friction: got {'num': 4, 'start': 1}; allowed: a list of"),
        ({"start": 1, "stop": 2, "num": 1}, r"friction\.num: got 1; allowed: an integer in \[2"),
        ({"start": 1, "stop": 2, "step": 0}, r"friction\.step: got 0; allowed: a step from start"),
        ({"start": 1, "stop": 2, "step": -1}, r"friction\.step: got -1; allowed: a step from"),
        ({"start": True, "stop": 2, "num": 4}, "friction: got .*; allowed: a list of values, {"),
        (
            {"start": 0, "stop": 1, "step": 1 / MAX_VALUES},
            r"friction\.step: got 0.0001; allowed: a",
        ),
        ({"start": "a", "stop": 2, "num": 4}, "friction: got .*; allowed: a list of values, {"),
        ({"start": 1, "stop": -1, "num": 2}, r"friction\[1\]: got -1; allowed: a number >= 0"),
    ],
)
def test_a_wrong_range_is_refused(range_mapping, message):
    with pytest.raises(InputError, match=rf"series\[0\]\.grid\.{message}"):
        points({"friction": range_mapping})


def test_what_is_no_range_is_left_to_others():
    assert expand_range([1, 2]) == [1, 2] and expand_range("a") == "a"
