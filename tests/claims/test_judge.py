"""Verdicts on claims: protocols, readings, and what is written of them."""

import json
from typing import get_args

import pytest

from sim.claims import judge
from sim.claims.judge import DEFAULT, Judgement, Variant, as_mapping, as_table
from sim.claims.table import claims
from sim.claims.verdict import INCONCLUSIVE, NOT_REPRODUCED, REPRODUCED, UNTESTABLE, Check
from sim.parameters import SYSTEMS, ChuteParameters
from sim.study.catalogue import FIGURES
from tests.made.results import made_point, made_results

HOLDS = Check("x", 2.0, 0.1, 1.0, 3.0, points=("p",), samples=50.0)
FAILS = Check("y", 4.0, 0.1, 1.0, 3.0)
OPEN = Check("z", 3.0, 0.1, 1.0, 3.0)
LACKING = Variant("converged", DEFAULT, reason="no runs")


def judged(*variants: Variant) -> Judgement:
    return Judgement(claims()[0], variants)


def of(check: Check, protocol: str = "published", reading: str = DEFAULT) -> Variant:
    return Variant(protocol, reading, (check,))


def test_the_table_holds_every_claim_once_in_order_with_a_judge():
    found = [claim.id for claim in claims()]
    assert found == [f"W{n}" for n in range(1, 27)] + [f"G{n}" for n in range(1, 37)]
    for claim in claims():
        assert claim.judging().__doc__, claim.id
        assert set(claim.figures) <= set(FIGURES)
        assert claim.needs or claim.kind == "model"


@pytest.mark.parametrize(
    ("variants", "verdict"),
    [
        ([of(HOLDS, "converged"), of(HOLDS)], REPRODUCED),
        ([of(FAILS, "converged"), of(HOLDS)], NOT_REPRODUCED),
        ([of(OPEN, "converged"), of(HOLDS)], REPRODUCED),
        ([LACKING, of(FAILS)], NOT_REPRODUCED),
        ([LACKING, of(OPEN)], INCONCLUSIVE),
        ([LACKING], UNTESTABLE),
        ([LACKING, of(HOLDS, reading="other")], UNTESTABLE),
    ],
)
def test_the_converged_protocol_speaks_first_where_it_is_decided(variants, verdict):
    assert judged(*variants).verdict == verdict


def test_only_contradictions_make_a_claim_dependent():
    assert judged(of(HOLDS, "converged"), of(FAILS)).protocol_dependent
    assert not judged(of(HOLDS, "converged"), of(OPEN)).protocol_dependent
    other = of(FAILS, reading="belt_ghost centred")
    assert judged(of(HOLDS), other).reading_dependent
    assert not judged(of(HOLDS), other).protocol_dependent
    assert not judged(of(HOLDS, "converged"), other).reading_dependent


def test_readings_are_what_points_have_beyond_the_defaults():
    results = made_results(
        made_point("belt", {"velocity": 0.1}),
        made_point("belt", {"velocity": 0.1}, integrator="verlet"),
        made_point("belt", {"velocity": 0.1}, integrator="verlet", frequency=30),
        made_point("belt", {"velocity": 0.1}, integrator="verlet", belt_ghost="centred"),
        made_point("chute", {"velocity": 0.1}, friction_cap="after"),
    )
    assert judge.readings(results, "belt") == [
        {"integrator": "verlet"},
        {"belt_ghost": "centred", "integrator": "verlet"},
    ]
    assert judge.readings(results, "chute") == [{"friction_cap": "after"}]


def test_readings_without_the_runs_of_a_claim_are_left_out(monkeypatch):
    monkeypatch.setattr(judge, "MODEL_READINGS", ({},))
    results = made_results(
        made_point("chute", {"velocity": 0.1}, friction_cap="after"),
        made_point("belt", {"velocity": 0.1}, integrator="verlet"),
    )
    for one in judge.judge(results):
        assert one.claim.paper == {"chute": "walton", "belt": "gallas"}[one.claim.system]
        flows = [variant for variant in one.variants if variant.protocol != judge.MODEL]
        assert all(variant.reading == DEFAULT or variant.checks for variant in flows)


def test_what_is_written_is_plain_json_and_one_row_per_check():
    judgements = [judged(of(HOLDS, "converged"), of(FAILS)), judged(LACKING)]
    text = json.dumps(as_mapping(judgements, "made"), allow_nan=False)
    document = json.loads(text)
    assert [one["decided_by"] for one in document["claims"]] == ["converged", ""]
    first = document["claims"][0]
    assert first["verdict"] == REPRODUCED and first["protocol_dependent"]
    assert first["variants"][0]["checks"][0] == {
        "what": "x",
        "value": 2.0,
        "half_width": 0.1,
        "low": 1.0,
        "high": 3.0,
        "unit": "",
        "points": ["p"],
        "samples": 50.0,
        "freedom": None,
        "verdict": REPRODUCED,
    }
    assert first["variants"][1]["checks"][0]["samples"] is None
    table = as_table(judgements)
    assert list(table["verdict on the check"].fillna("")) == [REPRODUCED, NOT_REPRODUCED, ""]
    assert table["reason"].iloc[-1] == "no runs"


def test_a_study_of_nothing_relevant_leaves_the_claims_on_flows_untestable():
    results = made_results(made_point("belt", {"velocity": 0.1}, diameter_spread=0.1))
    judgements = judge.judge(results)
    assert {one.claim.system for one in judgements} == {"belt"}
    assert {claim.system for claim in claims()} == set(SYSTEMS)
    for one in judgements:
        assert one.verdict == UNTESTABLE, one.claim.id
        assert all(variant.reason for variant in one.variants), one.claim.id


def test_the_contact_law_is_judged_under_its_readings_too(monkeypatch):
    """Forgetting the overlap when the force is zero raises the restitution (docs/physics.md).

    These readings are those of loops that other tests compile too.
    """
    readings = [
        {"tangential_exponent": exponent, "overlap_memory": memory, "friction_cap": cap}
        for exponent, memory, cap in ((0.0, "shrink", "after"), (1.0, "reset", "before"))
    ]
    monkeypatch.setattr(judge, "MODEL_READINGS", ({}, *readings))
    (first,) = [claim for claim in claims() if claim.id == "W1"]
    found = {one.reading: one.verdict for one in judge._variants(first, [])}
    assert found == {
        DEFAULT: REPRODUCED,
        "γ = 0; overlap_memory shrink; friction_cap after": REPRODUCED,
        "γ = 1; overlap_memory reset; friction_cap before": NOT_REPRODUCED,
    }


def test_every_reading_of_the_contact_law_is_judged():
    """Each other value of a reading of the law, one at a time."""
    law = {"overlap_memory", "friction_cap"}
    others = [
        {name: value}
        for name in ChuteParameters.model_fields
        if name in law
        for value in get_args(ChuteParameters.model_fields[name].annotation)
        if value != getattr(ChuteParameters(), name)
    ]
    assert list(judge.MODEL_READINGS) == [{}, *others]
