"""YAML as study and point files use it: numbers of YAML 1.2, anchors, merge keys."""

import pytest

from sim.base.errors import InputError
from sim.parameters import load_point


@pytest.mark.parametrize(
    ("text", "depth"),
    [
        ("system: chute\ndepth: 1e1\n", 10),
        ("system: chute\ndepth: 2.5E+1\n", 25),
        ("system: chute\ndepth: .5\n", 0.5),
        ("{'system': 'chute', 'depth': 1_0}", None),
        ("system: chute\ndepth: 010\n", 10),
        ("system: chute\ndepth: 1:30\n", None),
        ("system: chute\ndepth: yes\n", None),
    ],
)
def test_numbers_are_read_by_yaml_1_2(tmp_path, text, depth):
    path = tmp_path / "point.yaml"
    path.write_text(text)
    if depth is None:
        with pytest.raises(InputError, match=r"depth: got '.*'; allowed: a number > 0"):
            load_point(path)
    else:
        assert load_point(path).depth == depth


def test_anchors_and_merge_keys_are_no_duplicates(tmp_path):
    path = tmp_path / "point.yaml"
    path.write_text("<<: &base {system: chute, depth: 2}\ndepth: 3\n")
    assert load_point(path).depth == 3


@pytest.mark.parametrize("text", ["system: chute\n\tdepth: 1\n", "system: chute\n  \tdepth: 1\n"])
def test_a_tab_before_a_key_is_named(tmp_path, text):
    path = tmp_path / "point.yaml"
    path.write_text(text)
    with pytest.raises(InputError) as error:
        load_point(path)
    assert str(error.value) == f"{path}: line 2 begins with a tab; YAML wants spaces"
