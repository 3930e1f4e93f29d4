"""Claims of a study's own: judged under its protocols, with notes on unsteady points."""

import re
from pathlib import Path

import pytest

from sim.base.errors import InputError
from sim.base.plugins import load_plugins
from sim.base.seals import seal
from sim.claims import experiments, judge
from sim.claims.claim import claims
from sim.claims.experiments import run_experiment
from sim.claims.verdict import Check
from sim.claims.verdict_files import as_mapping, as_table
from sim.study.command import init
from tests.made.processes import ROOT, plugin_claims, restore_plugins
from tests.made.results import made_point, made_results

STEEPER = str(ROOT / "docs" / "examples" / "steeper.py")
SHORT = {"independent_samples": 1.0}
SPEEDING = {"acceleration": 2.0}


@pytest.fixture(autouse=True)
def _its_claim_alone(monkeypatch):
    monkeypatch.setattr(judge, "claims", plugin_claims)
    with restore_plugins():
        load_plugins(Path(STEEPER))
        yield


def changed_judge(folder: Path, checks: str) -> Path:
    """Write a plug-in whose judge returns ``checks``, an expression of those of the example."""
    text = Path(STEEPER).read_text().replace('"steeper_is_faster"', '"odd"')
    text = text.replace("import talus\n", "import dataclasses\nimport numpy\nimport talus\n", 1)
    path = folder / "odd.py"
    path.write_text(
        text.replace("    return [above", "    checks = [above") + f"    return {checks}\n"
    )
    return path


def judged_by(path: Path):
    """Return the judgement of the judge that a file adds."""
    load_plugins(path)
    points = [made_point("chute", {"velocity": 0.4}, angle=angle, depth=2.5) for angle in (17, 18)]
    return judge.judge(made_results(*points))[-1]


def judged(*scalars: dict, **options):
    """Return the judgement on flows down 17 and 18 degrees; the steeper one is faster."""
    points = [
        made_point("chute", {"velocity": speed} | changes, angle=angle, depth=2.5, **options)
        for angle, speed, changes in zip((17, 18), (0.4, 0.5), scalars, strict=True)
    ]
    (judgement,) = judge.judge(made_results(*points))
    return judgement


@pytest.mark.parametrize("protocol", ["published", "converged"])
def test_only_protocols_that_the_study_has_are_told(protocol):
    judgement = judged({}, {}, protocol=protocol)
    assert [variant.protocol for variant in judgement.variants] == [protocol]
    assert judgement.verdict == "reproduced"
    assert set(as_table([judgement])["protocol"]) == {protocol}


def test_texts_of_a_judge_turn_no_letters_where_they_are_shown(tmp_path):
    text = Path(STEEPER).read_text().replace('"steeper_is_faster"', '"another"')
    path = tmp_path / "another.py"
    path.write_text(text.replace('above("V(18°)', r'above("\u202eV\x1b[2J(18°)'))
    (check,) = judged_by(path).variants[0].checks
    assert check.what.isprintable() and "V\\x1b[2J(18°)" in check.what


@pytest.mark.parametrize(("changes", "verdict"), [({}, "reproduced"), (SHORT, "untestable")])
def test_the_paper_that_init_writes_is_judged_by_steady_flows_alone(tmp_path, changes, verdict):
    init(tmp_path, "", "incline")
    load_plugins(tmp_path / "incline")
    claims()
    flow = {"depth": 1.24, "friction": 0.4, "restitution": 0.85}
    points = [
        made_point("chute", {"velocity": 0.02 * angle} | changes, angle=angle, **flow)
        for angle in (15, 17, 19)
    ]
    judgement = judge.judge(made_results(*points))[-1]
    assert judgement.claim.id == "incline_steeper" and judgement.verdict == verdict
    reason = "fewer than 3 angles with a steady flow" if changes else ""
    reasons = {one.protocol: one.reason for one in judgement.variants}
    assert reasons["published"] == reason


@pytest.mark.parametrize(
    ("odd", "why"),
    [
        ("value='fast'", "value: got 'fast'; allowed: a valid number"),
        ("half_width=-1.0", "half_width: got -1; allowed: a number >= 0, or not-a-number"),
        ("low=float('nan')", "low: got nan; allowed: a number <= high"),
        ("tested=(0.1,)", "tested[1]: got (0.1,); allowed: one more"),
        ("tested=(2, 0.1)", "tested[0]: got 2; allowed: less than or equal to 1"),
    ],
)
def test_an_odd_check_is_one_line_that_names_its_judge(tmp_path, odd, why):
    path = changed_judge(tmp_path, f"[dataclasses.replace(one, {odd}) for one in checks]")
    line = r"plug-in odd.py \(\w{8}\): judge odd: check 'V\(18°\)/V\(17°\)'." + re.escape(why)
    with pytest.raises(InputError, match=line):
        judged_by(path)


@pytest.mark.parametrize(
    ("checks", "why"),
    [
        ("None", "TypeError: 'NoneType' object is not iterable"),
        ("[checks]", "TypeError: a judge returns checks, one at least"),
        (
            "[dataclasses.replace(checks[0], points=('p',))]",
            "ValueError: the study has no point 'p', which a check names",
        ),
        ("[dataclasses.replace(checks[0], part='a')]", "ValueError: odd has no part a"),
    ],
)
def test_what_is_no_list_of_checks_is_one_line_that_names_its_judge(tmp_path, checks, why):
    with pytest.raises(InputError, match=rf"plug-in odd.py \(\w{{8}}\): judge odd: .*{why}"):
        judged_by(changed_judge(tmp_path, checks))


def test_numbers_of_numpy_and_what_is_no_number_are_values_of_checks(tmp_path):
    change = "votes=numpy.True_, value=numpy.float32('nan'), half_width=float('nan')"
    path = changed_judge(tmp_path, f"[dataclasses.replace(one, {change}) for one in checks]")
    judgement = judged_by(path)
    assert judgement.verdict == "inconclusive"
    (variant,) = as_mapping([judgement], "s")["claims"][0]["variants"]
    (check,) = variant["checks"]
    assert check["votes"] is True and check["value"] is None


@pytest.mark.parametrize(
    ("scalars", "note"),
    [
        (({}, {}), ""),
        (({}, SPEEDING), "1 of 2 points is not steady: 1 accelerating"),
        ((SHORT, SPEEDING), "2 of 2 points are not steady: 1 accelerating, 1 undetermined"),
        (({"regime": "arrested"},) * 2, "2 of 2 points are not steady: 2 arrested"),
    ],
)
def test_the_evidence_names_points_that_are_not_steady(scalars, note):
    judgement = judged(*scalars)
    (variant,) = as_mapping([judgement], "s")["claims"][0]["variants"]
    assert variant.get("unsteady", "") == note
    assert set(as_table([judgement])["steadiness"]) == {note}


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
