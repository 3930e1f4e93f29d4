"""Claims, their evidence and the readings of papers as rows of the report."""

from types import SimpleNamespace

import pytest

from sim.claims.verdict import VERDICTS as JUDGED
from sim.claims.verdict_files import as_mapping
from sim.report.claims import (
    VERDICTS,
    claim_rows,
    count_verdicts,
    has_tested_claims,
    model_checks,
    papers_of,
    protocols_of,
    reading_tables,
)
from sim.report.numbers import strip
from tests.made.report import DEPTH, FREQUENCY, made_claims
from tests.made.results import made_point, made_results

POINTS = [f"chute-{DEPTH}-1", f"belt-{FREQUENCY}-2"]


def test_every_verdict_has_a_sign():
    assert tuple(VERDICTS) == JUDGED
    assert len({sign for _, sign in VERDICTS.values()}) == len(JUDGED)


def test_a_row_has_what_the_outline_of_the_page_does_not_show():
    claims = as_mapping(made_claims(POINTS), "made")["claims"]
    runs = [{"point": POINTS[0], "number": 7, "wall_time": 90.0}]
    rows = {row["id"]: row for row in claim_rows(claims, runs, ["walton_2"])}
    assert [variant["usual"] for variant in rows["G4"]["variants"]] == [True, True, False]
    assert rows["W9"]["cost"] == {"points": 1, "seconds": 90.0}
    known, unknown = rows["G3"]["variants"][0]["checks"]
    # What is not finite has no strip.
    assert strip(known) is not None and strip(unknown) is None
    assert protocols_of(rows.values()) == ["published", "converged"]
    assert protocols_of([rows["G6"]]) == ["published"] and not protocols_of([rows["W1"]])
    assert not has_tested_claims([rows["W1"], rows["G31"]]) and has_tested_claims([rows["G3"]])


def test_checks_of_the_model_are_counted_apart():
    shared = {"paper": "walton", "verdict": "reproduced"}
    claims = [shared | {"kind": kind} for kind in ("model", "check", "flow", "flow")]
    claims[0] |= {"verdict": "not reproduced"}
    claims[3] |= {"verdict": "untestable"}
    (found,) = count_verdicts(claims).values()
    assert {verdict: number for verdict, number in found.items() if number} == {
        "reproduced": 1,
        "untestable": 1,
    }
    assert model_checks(claims) == {"tested": 2, "reproduced": 1}


@pytest.mark.parametrize(
    ("named", "fed", "verdicts", "counted"),
    [
        ("", "", {"W1": "reproduced", "W9": "untestable", "G3": "untestable"}, set()),
        ("", "", {"W1": "reproduced", "G3": "inconclusive"}, {"gallas"}),
        ("", "Walton (1993), Fig. 2", {"W9": "untestable", "G3": "untestable"}, {"walton"}),
        ("gallas", "Walton (1993), Fig. 2", {"W1": "reproduced"}, {"walton", "gallas"}),
        ("gallas", "", {"W9": "not reproduced"}, {"gallas"}),
        ("", "Gallas et al. (1992), Fig. 1a", {"W9": "not reproduced"}, {"walton", "gallas"}),
    ],
)
def test_papers_count_that_a_study_names_or_feeds_or_decides(named, fed, verdicts, counted):
    """Claims on the contact law alone hold whatever was run."""
    names = {"W": "walton", "G": "gallas"}
    claims = [
        {"paper": names[one[0]], "kind": "model" if one == "W1" else "flow", "verdict": verdict}
        for one, verdict in verdicts.items()
    ]
    study = SimpleNamespace(paper=named, entries={"a": SimpleNamespace(paper=fed)})
    assert papers_of(claims, study) == counted


def test_a_strip_keeps_its_order():
    place = strip({"value": 16.0, "bound": 2.0, "low": 15.0, "high": 17.0})
    assert place["start"] < place["low"] < place["value"] < place["high"]
    assert place["end"] > place["high"]
    assert place["value"] == pytest.approx(50)
    open_end = strip({"value": 3.0, "bound": 0.1, "low": None, "high": 1.0})
    assert open_end["low"] == 0 and open_end["high"] < open_end["start"]
    for high in (1.0, None):
        place = strip({"value": 1.0, "bound": 0.0, "low": None, "high": high})
        assert 0 < place["value"] < 100
        assert place["start"] == place["end"]


def flow(missing: float, **parameters):
    return made_point("belt", {"velocity": 0.05, "missing_energy": missing}, **parameters)


def claim(name: str, default: str, reduced: str) -> dict:
    by_reading = {"default": default, "damping_mass reduced": reduced}
    shared = {"title": "A claim", "paper": "gallas", "kind": "flow", "verdict": default}
    return shared | {"id": name} | judged(by_reading)


def judged(by_reading: dict) -> dict:
    """Return verdicts by reading, and the variants that give them from published runs."""
    variants = [
        {"protocol": "published", "reading": reading, "verdict": verdict}
        for reading, verdict in by_reading.items()
    ]
    return {"by_reading": by_reading, "variants": variants}


CLAIMS = [
    claim("G1", "not reproduced", "reproduced"),
    claim("G2", "reproduced in part", "untestable"),
]


@pytest.fixture
def table():
    results = made_results(
        flow(2e3, frequency=10),
        flow(1e-5, frequency=80),
        flow(0.5, frequency=10, protocol="converged"),
        flow(5e-5, frequency=10, damping_mass="reduced"),
    )
    (found,) = reading_tables(CLAIMS, results)
    return found


def test_each_reading_has_its_counts_verdicts_and_steps_that_theory_and_energy_bear(table):
    assert [claim["id"] for claim in table["claims"]] == ["G1"]
    rows = [(row["words"], row["protocol"], row["verdicts"]) for row in table["rows"]]
    assert rows == [
        ("default", "published", ["not reproduced"]),
        ("damping_mass reduced", "published", ["reproduced"]),
    ]
    default, reduced = table["readings"]
    names = ("words", "hold", "tested", "is_headline", "points", "stable", "sound")
    assert [default[name] for name in names] == ["default", 1, 2, True, 2, 1, 1]
    assert [reduced[name] for name in names] == ["damping_mass reduced", 1, 1, False, 1, 1, 1]
    assert (reduced["common"], reduced["common_hold"], reduced["headline_hold"]) == (1, 1, 0)
    assert reduced["sentences"] and not default["sentences"]
    assert default["missing"] == pytest.approx(2e3, rel=0.01)


def test_no_step_is_called_stable_where_no_bound_of_it_is_known():
    by_reading = {"default": "reproduced", "friction_cap after": "reproduced"}
    shared = {"id": "W1", "title": "A claim", "paper": "walton", "kind": "flow"}
    quantities = {"velocity": 0.1, "missing_energy": 1e-5}
    results = made_results(
        made_point("chute", quantities), made_point("chute", quantities, friction_cap="after")
    )
    (found,) = reading_tables([shared | judged(by_reading)], results)
    assert [(one["points"], one["stable"]) for one in found["readings"]] == [(1, None), (1, None)]
