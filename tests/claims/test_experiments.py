"""Experiments on the model are done once, and a damaged or foreign result gives no verdict."""

import pytest

from sim.base.seals import seal
from sim.claims import experiments
from sim.claims.claim import claims
from sim.claims.experiments import run_experiment
from sim.claims.verdict import Check

CLAIM = claims()[0]
CHECKS = (
    Check("x", 0.1, 1e-17, 0.0, float("inf"), points=("p", "q")),
    Check("y", 2.0, 0.1, 1.0, 3.0),
)


@pytest.fixture
def run_readings(tmp_path, monkeypatch) -> list:
    """Return the readings under which the experiment was really run."""
    readings = []

    def judge(reading, **_):
        readings.append(dict(reading))
        return CHECKS

    monkeypatch.setattr(experiments, "cache_directory", lambda with_plugins: tmp_path)
    monkeypatch.setitem(vars(CLAIM), "judge", judge)
    return readings


def test_an_experiment_is_done_once_for_each_reading(run_readings, tmp_path):
    assert [run_experiment(CLAIM, {}) for _ in range(3)] == [CHECKS] * 3
    assert run_experiment(CLAIM, {"friction_cap": "after"}) == CHECKS
    assert run_readings == [{}, {"friction_cap": "after"}]
    assert len(list(tmp_path.iterdir())) == 2


@pytest.mark.parametrize("function", ["source_hash", "library_versions"])
def test_other_code_or_libraries_do_it_again(function, run_readings, monkeypatch):
    run_experiment(CLAIM, {})
    monkeypatch.setattr(experiments, function, lambda *_: "other")
    run_experiment(CLAIM, {})
    assert len(run_readings) == 2


@pytest.mark.parametrize("form", [None, '[{"what": "x"}]'])
def test_what_is_damaged_or_of_another_form_is_not_used(form, run_readings, tmp_path):
    run_experiment(CLAIM, {})
    (path,) = tmp_path.iterdir()
    whole = path.read_bytes()
    path.write_bytes(whole.replace(b"0.1", b"0.2", 1))
    if form:
        path.write_text(form)
        seal(path)
    assert run_experiment(CLAIM, {}) == CHECKS
    assert run_readings == [{}, {}] and path.read_bytes() == whole


def test_what_cannot_be_kept_gives_its_verdict_all_the_same(
    run_readings, tmp_path, monkeypatch, caplog
):
    (tmp_path / "file").write_text("")
    monkeypatch.setattr(experiments, "cache_directory", lambda with_plugins: tmp_path / "file")
    assert run_experiment(CLAIM, {}) == CHECKS
    assert "not kept" in caplog.text
