"""Reading comes before anything else: all files of a study, and the plug-ins that they name."""

from pathlib import Path

import pytest

from sim.base.errors import InputError
from sim.study.load import load_study
from sim.study.read import read

SERIES = "series: [{{name: {}, system: chute, base: {{depth: {}}}}}]\n"


@pytest.fixture
def study(tmp_path) -> Path:
    (tmp_path / "one.yaml").write_text("study: one\n" + SERIES.format("a", 2))
    (tmp_path / "two.yaml").write_text("study: two\n" + SERIES.format("b", 3))
    path = tmp_path / "study.yaml"
    path.write_text("study: s\nparts: [two.yaml, one.yaml]\n" + SERIES.format("c", 4))
    return path


def test_the_study_file_comes_first_and_its_parts_in_their_order(study):
    documents = read(study)
    assert [one.path.name for one in documents] == ["study.yaml", "two.yaml", "one.yaml"]
    assert [one.contents["study"] for one in documents] == ["s", "two", "one"]
    assert [one.plugins for one in documents] == [(), (), ()]


@pytest.mark.parametrize("parts", ["one.yaml", "[1]", "[-]", "[../one.yaml]", "[one.yaml, a/b]"])
def test_malformed_names_of_parts_are_not_read_but_refused(study, parts):
    study.write_text(f"study: s\nparts: {parts}\n")
    assert len(read(study)) == 1
    with pytest.raises(InputError, match=r"study\.yaml: parts"):
        load_study(study, None)


def test_a_part_is_validated_before_a_point_is_expanded(study):
    # Pages are too many once all points are known; the unknown key of a part is found before.
    grid = "{name: c, system: chute, grid: {seed: {start: 1, stop: 1001, step: 1}}}"
    study.write_text(f"study: s\npages: true\nparts: [one.yaml]\nseries: [{grid}]\n")
    with pytest.raises(InputError, match=r"study\.yaml: pages"):
        load_study(study, None)
    part = study.with_name("one.yaml")
    part.write_text("titles: x\n" + part.read_text())
    with pytest.raises(InputError, match=r"one\.yaml: titles: unknown key"):
        load_study(study, None)
