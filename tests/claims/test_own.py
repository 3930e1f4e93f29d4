"""Claims of a study's own: under the protocols that it has, with what its points are worth."""

from pathlib import Path

import pytest

from sim.base.plugins import load_plugins
from sim.claims import judge
from sim.claims.written import as_mapping, as_table
from tests.made.plugins import forgotten
from tests.made.processes import ROOT
from tests.made.results import made_point, made_results

STEEPER = str(ROOT / "docs" / "examples" / "steeper.py")
SHORT = {"independent_samples": 1.0}
SPEEDING = {"acceleration": 2.0}


@pytest.fixture(autouse=True)
def _its_claim_alone(monkeypatch):
    monkeypatch.setattr(judge, "claims", lambda: ())
    with forgotten():
        load_plugins(Path(STEEPER))
        yield


def judged(*scalars: dict, **options):
    """Return the judgement on flows down 17 and 18 degrees, the latter faster."""
    made = [
        made_point("chute", {"velocity": speed} | one, angle=angle, depth=2.5, **options)
        for angle, speed, one in zip((17, 18), (0.4, 0.5), scalars, strict=True)
    ]
    (found,) = judge.judge(made_results(*made))
    return found


@pytest.mark.parametrize("protocol", ["published", "converged"])
def test_only_protocols_that_the_study_has_are_told(protocol):
    found = judged({}, {}, protocol=protocol)
    assert [one.protocol for one in found.variants] == [protocol]
    assert found.verdict == "reproduced"
    assert set(as_table([found])["protocol"]) == {protocol}


def test_texts_of_a_judge_turn_no_letters_where_they_are_shown(tmp_path):
    text = Path(STEEPER).read_text().replace('"steeper_is_faster"', '"another"')
    path = tmp_path / "another.py"
    path.write_text(text.replace('above("V(18°)', r'above("\u202eV\x1b[2J(18°)'))
    load_plugins(path)
    made = [made_point("chute", {"velocity": 0.4}, angle=angle, depth=2.5) for angle in (17, 18)]
    _, found = judge.judge(made_results(*made))
    (check,) = found.variants[0].checks
    assert check.what.isprintable() and "V\\x1b[2J(18°)" in check.what


@pytest.mark.parametrize(
    ("scalars", "said"),
    [
        (({}, {}), ""),
        (({}, SPEEDING), "1 of 2 points is not steady: 1 accelerating"),
        ((SHORT, SPEEDING), "2 of 2 points are not steady: 1 accelerating, 1 undetermined"),
        (({"regime": "arrested"},) * 2, "2 of 2 points are not steady: 2 arrested"),
    ],
)
def test_the_evidence_names_points_that_are_not_steady(scalars, said):
    found = judged(*scalars)
    (variant,) = as_mapping([found], "s")["claims"][0]["variants"]
    assert variant.get("unsteady", "") == said
    assert set(as_table([found])["steadiness"]) == {said}
