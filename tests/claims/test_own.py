"""Claims of a study's own: judged under its protocols, with notes on unsteady points."""

from pathlib import Path

import pytest

from sim.base.plugins import load_plugins
from sim.claims import judge
from sim.claims.verdict_files import as_mapping, as_table
from tests.made.plugins import plugin_claims, restore_plugins
from tests.made.processes import ROOT
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
    load_plugins(path)
    points = [made_point("chute", {"velocity": 0.4}, angle=angle, depth=2.5) for angle in (17, 18)]
    _, judgement = judge.judge(made_results(*points))
    (check,) = judgement.variants[0].checks
    assert check.what.isprintable() and "V\\x1b[2J(18°)" in check.what


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
