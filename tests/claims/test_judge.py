"""Verdicts on claims: protocols, readings and the files written."""

import json
from dataclasses import replace
from math import inf
from typing import get_args

import pytest

from sim.claims import judge
from sim.claims.checks import above
from sim.claims.claim import Number, claims
from sim.claims.evidence import (
    DEFAULT,
    GRID,
    Evidence,
    model_readings,
    readings_of,
)
from sim.claims.judge import _variants
from sim.claims.judgement import Judgement, Variant
from sim.claims.verdict import (
    INCONCLUSIVE,
    NOT_REPRODUCED,
    PAPER_INCONSISTENT,
    PROTOCOL_DEPENDENT,
    READING_DEPENDENT,
    REPRODUCED,
    REPRODUCED_IN_PART,
    UNTESTABLE,
    Check,
)
from sim.claims.verdict_files import as_mapping, as_table
from sim.dataset.grids import GRIDS
from sim.parameters import SYSTEMS, roles
from sim.study.figure_spec import FIGURES
from sim.study.papers import papers
from tests.made.paper_belt import paper_point
from tests.made.results import made_point, made_results

HOLDS = Check("x", 2.0, 0.1, 1.0, 3.0, points=("p",), samples=50.0)
FAILS = Check("y", 4.0, 0.1, 1.0, 3.0)
SETTLES = replace(FAILS, what=HOLDS.what)
OPEN = Check("z", 3.0, 0.1, 1.0, 3.0)
NO_RUNS = Variant("converged", DEFAULT, reason="no runs")


def judged(*variants: Variant) -> Judgement:
    return Judgement(claims()[0], variants)


def variant_of(check: Check, protocol: str = "published", reading: str = DEFAULT) -> Variant:
    return Variant(protocol, reading, (check,))


def test_the_table_holds_every_claim_once_in_order_with_a_judge():
    ids = [claim.id for claim in claims()]
    numbers = {"W": 32, "G": 40, "S": 10}
    every = [f"{letter}{n + 1}" for letter, most in numbers.items() for n in range(most)]
    # The balance of forces, W26, is no statement of the paper.
    assert ids == [name for name in every if name != "W26"]
    for claim in claims():
        assert claim.judge.__doc__, claim.id
        assert set(claim.figures) <= set(FIGURES)
        assert claim.needs or claim.kind == "model"
        assert claim.place and claim.reason


@pytest.mark.parametrize(
    ("variants", "verdict"),
    [
        ([variant_of(HOLDS, "converged"), variant_of(HOLDS)], REPRODUCED),
        ([variant_of(FAILS, "converged"), variant_of(FAILS)], NOT_REPRODUCED),
        ([variant_of(FAILS, "converged"), variant_of(OPEN)], NOT_REPRODUCED),
        # What a flow that has not relaxed says is shown and gives no verdict.
        ([variant_of(OPEN, "converged"), variant_of(FAILS)], INCONCLUSIVE),
        ([NO_RUNS, variant_of(FAILS)], NOT_REPRODUCED),
        ([NO_RUNS, variant_of(OPEN)], INCONCLUSIVE),
        ([NO_RUNS], UNTESTABLE),
        ([NO_RUNS, variant_of(HOLDS, reading="other")], UNTESTABLE),
        ([variant_of(HOLDS), variant_of(OPEN, reading="other")], REPRODUCED),
        (
            # Readings are compared with the headline one, not with each other.
            [
                variant_of(OPEN),
                variant_of(FAILS, reading="other"),
                variant_of(HOLDS, reading="third"),
            ],
            INCONCLUSIVE,
        ),
    ],
)
def test_the_converged_protocol_decides_where_it_was_run(variants, verdict):
    assert judged(*variants).verdict == verdict


@pytest.mark.parametrize(
    ("variants", "depends"),
    [
        ([variant_of(HOLDS, "converged"), variant_of(FAILS)], "protocol"),
        ([variant_of(HOLDS, "converged"), variant_of(OPEN)], ""),
        ([variant_of(HOLDS), variant_of(FAILS, reading="other")], "reading"),
        # Readings are compared with the headline one under a protocol of both.
        ([variant_of(HOLDS, "converged"), variant_of(FAILS, reading="other")], ""),
        (
            [
                variant_of(HOLDS, "converged"),
                variant_of(HOLDS),
                variant_of(FAILS, reading="other"),
                variant_of(OPEN, "converged", "other"),
            ],
            "reading",
        ),
        # What converged runs of the same reading contradict is a transient.
        (
            [
                variant_of(HOLDS, "converged"),
                variant_of(HOLDS),
                variant_of(SETTLES, reading="other"),
                variant_of(HOLDS, "converged", "other"),
            ],
            "",
        ),
        # Another quantity that holds there makes it none.
        (
            [
                variant_of(HOLDS, "converged"),
                variant_of(HOLDS),
                variant_of(FAILS, reading="other"),
                variant_of(HOLDS, "converged", "other"),
            ],
            "reading",
        ),
    ],
)
def test_only_contradictions_make_a_claim_dependent(variants, depends):
    judgement = judged(*variants)
    assert judgement.protocol_dependent == (depends == "protocol")
    assert judgement.reading_dependent == (depends == "reading")
    dependent = {"protocol": PROTOCOL_DEPENDENT, "reading": READING_DEPENDENT}
    assert judgement.verdict == dependent.get(depends, REPRODUCED)


def test_a_claim_may_name_the_protocol_that_decides_it():
    for other in (OPEN, FAILS):
        variants = variant_of(other, "converged"), variant_of(HOLDS)
        claim = judged(*variants).claim.model_copy(update={"protocol": "published"})
        judgement = Judgement(claim, variants)
        assert (judgement.verdict, judgement.decided_by) == (REPRODUCED, "published")
        another = variant_of(HOLDS, "converged", "other"), variant_of(HOLDS, reading="other")
        assert not Judgement(claim, (*variants, *another)).reading_dependent


def test_a_control_is_no_reading():
    control = replace(variant_of(FAILS, reading="integrator verlet"), control="no reading")
    assert judged(variant_of(HOLDS), control).verdict == REPRODUCED
    belt = readings_of("belt")
    assert belt.control_reason({"belt_ghost": "centred", "integrator": "verlet"})
    assert not belt.control_reason({"belt_ghost": "centred"})


def test_every_reading_has_the_words_that_leave_it_open_or_is_a_control():
    for paper in papers().values():
        model, declared = SYSTEMS[paper.system], paper.readings
        # A paper with values of its own leaves nothing open that it does not say.
        readings = set() if paper.defaults else set(roles.reading_parameters(model))
        for name in readings - declared.open.keys():
            others = set(get_args(model.model_fields[name].annotation)) - {getattr(model(), name)}
            assert others, f"{name}: neither open nor a choice of which all others are controls"
            assert all(declared.control_reason({name: value}) for value in others), name
        assert declared.open.keys() == (
            declared.open.keys() & set(roles.reading_parameters(model))
            | declared.rows.keys()
            | ({GRID} if declared.grids else set())
        )
        assert declared.grids.keys() <= set(GRIDS)
        assert set(declared.headline) <= declared.open.keys()
        assert all(words.count('"') >= 2 for words in declared.open.values())


#: A claim that says two things.
TWO = claims()[0].model_copy(update={"parts": {"a": "one thing", "b": "another"}})


def on_part(part: str, check: Check) -> Check:
    return replace(check, part=part)


@pytest.mark.parametrize(
    ("converged", "published", "verdict"),
    [
        ([("a", HOLDS), ("b", HOLDS)], [], REPRODUCED),
        ([("a", HOLDS), ("b", FAILS)], [], REPRODUCED_IN_PART),
        ([("a", HOLDS), ("b", OPEN)], [], REPRODUCED_IN_PART),
        # One part that fails does not refute the others.
        ([("a", OPEN), ("b", FAILS)], [], INCONCLUSIVE),
        ([("b", FAILS)], [], INCONCLUSIVE),
        ([("a", FAILS), ("b", FAILS)], [], NOT_REPRODUCED),
        # Each part is decided by its own protocol, a part without runs is not reproduced yet.
        ([("a", HOLDS)], [("a", OPEN), ("b", HOLDS)], REPRODUCED),
        ([("a", HOLDS)], [("a", HOLDS)], REPRODUCED_IN_PART),
        # A part that depends on the protocol does not hold.
        ([("a", HOLDS)], [("a", FAILS), ("b", HOLDS)], REPRODUCED_IN_PART),
        ([("a", HOLDS), ("b", OPEN)], [("a", FAILS)], PROTOCOL_DEPENDENT),
        ([("a", HOLDS), ("b", FAILS)], [("a", FAILS)], PROTOCOL_DEPENDENT),
    ],
)
def test_a_claim_that_says_two_things_may_hold_in_part(converged, published, verdict):
    variants = [
        Variant(protocol, DEFAULT, tuple(on_part(part, check) for part, check in checks))
        for protocol, checks in (("converged", converged), ("published", published))
        if checks
    ]
    assert Judgement(TWO, tuple(variants)).verdict == verdict
    torn = TWO.model_copy(update={"contradiction": "both cannot be"})
    assert Judgement(torn, tuple(variants)).verdict == PAPER_INCONSISTENT
    assert Judgement(torn, (NO_RUNS,)).verdict == UNTESTABLE


@pytest.mark.parametrize(
    ("second", "verdict"), [(HOLDS, REPRODUCED_IN_PART), (OPEN, READING_DEPENDENT)]
)
def test_a_part_may_depend_on_the_reading(second, verdict):
    headline = Variant("published", DEFAULT, (on_part("a", FAILS), on_part("b", second)))
    other = Variant("published", "other", (on_part("a", HOLDS), on_part("b", HOLDS)))
    judgement = Judgement(TWO, (headline, other))
    assert judgement.verdict == verdict
    assert judgement.part_verdicts["a"] == READING_DEPENDENT
    assert judgement.verdict_under("other") == REPRODUCED


@pytest.mark.parametrize(
    ("headline", "headings", "verdict"),
    [
        ([("a", HOLDS), ("b", HOLDS)], ["late"], REPRODUCED),
        ([("a", HOLDS), ("b", OPEN)], ["late"], REPRODUCED_IN_PART),
        # Runs of the default reading decide a part that the headline one has none for.
        ([("a", HOLDS)], ["late", DEFAULT], REPRODUCED_IN_PART),
        ([], [DEFAULT], INCONCLUSIVE),
    ],
)
def test_the_default_reading_heads_parts_that_the_headline_one_has_no_runs_for(
    headline, headings, verdict
):
    variants = [
        Variant("published", reading, tuple(on_part(part, check) for part, check in checks))
        for reading, checks in (("late", headline), (DEFAULT, [("a", OPEN), ("b", OPEN)]))
    ]
    judgement = Judgement(TWO, tuple(variants), "late")
    assert (judgement.headings, judgement.verdict) == (headings, verdict)
    assert as_mapping([judgement], "made")["claims"][0]["headings"] == headings


def test_a_verdict_is_told_as_a_function_of_a_number_that_is_ours():
    number = Number(bound="margin", what="weak", values=[0.1, 0.15], headline=0.15)
    claim = claims()[0].model_copy(update={"number": number})
    variant = Variant(
        "published", DEFAULT, (HOLDS,), checks_by_number={0.1: (FAILS,), 0.15: (HOLDS,)}
    )
    judgement = Judgement(claim, (variant,))
    assert judgement.by_number == {0.1: NOT_REPRODUCED, 0.15: REPRODUCED}
    document = as_mapping([judgement], "made")["claims"][0]
    assert [row["verdict"] for row in document["by_number"]] == [NOT_REPRODUCED, REPRODUCED]
    assert document["by_number"][0]["checks"][0]["what"] == "y"
    with pytest.raises(ValueError, match="headline"):
        Number(bound="margin", what="weak", values=[0.1, 0.2], headline=0.15)


def test_an_open_claim_is_priced_by_the_points_of_its_votes():
    """What is reported beside the votes, decided or not, is not bought."""
    vote = replace(OPEN, value=2.95, points=("p",), freedom=7)
    beside = [
        replace(vote, points=("q",), votes=False),
        replace(vote, points=("r",), low=-inf, high=inf),
    ]
    variant = Variant("published", DEFAULT, (vote, *beside, replace(HOLDS, points=("s",))))
    judgement = Judgement(claims()[0], (variant,))
    assert judgement.verdict == INCONCLUSIVE
    assert [check.points for check in judgement.open_checks(DEFAULT)] == [("p",)]


def test_an_alternative_of_a_claim_is_another_reading():
    """Bounds that the paper's words leave open are judged under each value, beside the headline."""
    points = [paper_point(frequency=frequency) for frequency in (20, 30, 40)]
    claim = next(claim for claim in claims() if claim.id == "G12").model_copy(
        update={
            "judge": lambda evidence, *, least: [above("x", 1.0, least)],
            "bounds": {"least": 0},
            "number": None,
            "alternatives": {"at least two": {"least": 2}},
        }
    )
    readings, results = readings_of("belt"), made_results(*points)
    evidence = [({}, Evidence(results, "published"))]
    variants = tuple(_variants(claim, readings, evidence))
    assert [variant.reading for variant in variants] == [DEFAULT, "at least two"]
    assert Judgement(claim, variants).verdict == READING_DEPENDENT


def test_the_model_is_judged_under_its_readings_where_the_study_has_runs_of_any():
    flow, paper = {"velocity": 0.1}, papers()["walton"]
    usual = made_results(made_point("chute", flow), made_point("chute", flow, cell=5))
    assert model_readings(usual, "chute", paper) == [{}]
    other = made_results(made_point("chute", flow), made_point("chute", flow, friction_cap="after"))
    assert model_readings(other, "chute", paper) == paper.readings.model


def test_what_is_written_is_plain_json_and_one_row_per_check():
    judgements = [judged(variant_of(HOLDS, "converged"), variant_of(FAILS)), judged(NO_RUNS)]
    text = json.dumps(as_mapping(judgements, "made"), allow_nan=False)
    document = json.loads(text)
    assert [row["decided_by"] for row in document["claims"]] == ["converged", ""]
    first = document["claims"][0]
    assert first["verdict"] == PROTOCOL_DEPENDENT and first["protocol_dependent"]
    check = first["variants"][0]["checks"][0]
    told = {"what": "x", "value": 2.0, "points": ["p"], "samples": 50.0, "freedom": None}
    assert check.items() >= (told | {"verdict": REPRODUCED, "plan": ""}).items()
    assert check["bound"] == pytest.approx(0.0839, abs=1e-4)
    assert first["variants"][1]["checks"][0]["samples"] is None
    table = as_table(judgements)
    assert list(table["verdict on the check"].fillna("")) == [REPRODUCED, NOT_REPRODUCED, ""]
    assert table["reason"].iloc[-1] == "no runs"


def test_the_table_has_the_first_verdict_those_on_parts_and_those_by_number():
    number = Number(bound="margin", what="weak", values=[0.1, 0.15], headline=0.15)
    parts = {"a": "one thing", "b": "another"}
    claim = claims()[0].model_copy(update={"number": number, "parts": parts})
    checks = on_part("a", HOLDS), on_part("b", OPEN)
    others = {0.1: (on_part("a", FAILS), on_part("b", FAILS)), 0.15: checks}
    variant = Variant("published", DEFAULT, checks, checks_by_number=others)
    first, second = as_table([Judgement(claim, (variant,))]).to_dict("records")
    by_number = f"0.1: {NOT_REPRODUCED}; 0.15: {REPRODUCED_IN_PART}"
    told = {"first verdict": claim.first.verdict, "verdict by number": by_number}
    assert first.items() >= (told | {"part": "a", "verdict on the part": REPRODUCED}).items()
    assert second.items() >= (told | {"part": "b", "verdict on the part": INCONCLUSIVE}).items()


def test_a_study_of_nothing_relevant_leaves_the_claims_on_flows_untestable():
    results = made_results(made_point("belt", {"velocity": 0.1}, diameter_spread=0.1))
    judgements = judge.judge(results)
    assert {judgement.claim.system for judgement in judgements} == {"belt"}
    assert {claim.system for claim in claims()} == {paper.system for paper in papers().values()}
    for judgement in judgements:
        assert judgement.verdict == UNTESTABLE, judgement.claim.id
        assert all(variant.reason for variant in judgement.variants), judgement.claim.id


def test_a_paper_with_values_of_its_own_is_judged_by_studies_that_name_it_and_these_by_it_alone(
    monkeypatch,
):
    monkeypatch.setattr(judge, "run_experiment", lambda claim, changes: ())
    results = made_results(made_point("chute", {"velocity": 0.5}))
    for study, judged_papers in (("", {"walton"}), ("silbert", {"silbert"})):
        assert {one.claim.paper for one in judge.judge(results, study)} == judged_papers
