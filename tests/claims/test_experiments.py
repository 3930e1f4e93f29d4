"""Experiments on the model are done once, and a damaged or foreign result gives no verdict."""

import json

import pytest

from sim.base.files import seal
from sim.claims import experiments
from sim.claims.experiments import experiment
from sim.claims.table import claims
from sim.claims.verdict import Check

CLAIM = claims()[0]
FOUND = (
    Check("x", 0.1, 1e-17, 0.0, float("inf"), points=("p", "q")),
    Check("y", 2.0, 0.1, 1.0, 3.0),
)


@pytest.fixture
def done(tmp_path, monkeypatch) -> list:
    """The readings under which the experiment was really done."""
    found = []

    def judge(reading):
        found.append(dict(reading))
        return FOUND

    monkeypatch.setattr(experiments, "cache_directory", lambda plugged: tmp_path)
    monkeypatch.setattr(type(CLAIM), "judging", lambda _: judge)
    return found


def test_an_experiment_is_done_once_for_each_reading(done, tmp_path):
    assert [experiment(CLAIM, {}) for _ in range(3)] == [FOUND] * 3
    assert experiment(CLAIM, {"friction_cap": "after"}) == FOUND
    assert done == [{}, {"friction_cap": "after"}]
    assert len(list(tmp_path.iterdir())) == 2


@pytest.mark.parametrize("what", ["source_hash", "library_versions"])
def test_other_code_or_libraries_do_it_again(what, done, monkeypatch):
    experiment(CLAIM, {})
    monkeypatch.setattr(experiments, what, lambda *_: "other")
    experiment(CLAIM, {})
    assert len(done) == 2


@pytest.mark.parametrize("damage", ["flipped", "cut", "unsealed", "empty", "foreign", "other form"])
def test_what_is_damaged_or_foreign_is_not_used(damage, done, tmp_path):
    experiment(CLAIM, {})
    (path,) = tmp_path.iterdir()
    whole = path.read_bytes()
    line, _, _ = whole.partition(b"\n")
    held = json.loads(line)
    match damage:
        case "flipped":
            path.write_bytes(whole.replace(b"0.1", b"0.2", 1))
        case "cut":
            path.write_bytes(whole[:-20])
        case "unsealed":
            path.write_bytes(line)
        case "empty":
            path.write_bytes(b"")
        case "foreign":
            path.write_text(json.dumps(held | {"identity": {}}))
            seal(path)
        case "other form":
            path.write_text(json.dumps(held | {"checks": [{"what": "x"}]}))
            seal(path)
    assert experiment(CLAIM, {}) == FOUND
    assert done == [{}, {}]
    assert path.read_bytes() == whole


def test_what_cannot_be_kept_gives_its_verdict_all_the_same(done, tmp_path, monkeypatch, caplog):
    (tmp_path / "file").write_text("")
    monkeypatch.setattr(experiments, "cache_directory", lambda plugged: tmp_path / "file")
    assert experiment(CLAIM, {}) == FOUND
    assert "not kept" in caplog.text
