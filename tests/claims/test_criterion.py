"""Numbers of a criterion: each stands once, among the bounds of its claim."""

import inspect
import re
from string import Formatter

import pytest
from pydantic import ValidationError

from sim.base.statistics import CONFIDENCE
from sim.claims.claim import Claim, claims, fill
from sim.measures import layers
from sim.measures.belt import EARLY_CYCLES, FAR_DISTANCE
from sim.measures.chute import MIN_BONDS

#: What has digits and is no bound: symbols, claims, zero, and what variables are defined by.
NAMES = (
    r"K[012]|q6|[WG]\d+|4π²|\(5/7\)|(?<![\d.])0(?![\d.])|\(1 \u2212|\u2212 1\|",
    rf"{100 * CONFIDENCE:g} %",
    "99.9th percentile",
    rf"first {EARLY_CYCLES} cycles",
    rf"more than {FAR_DISTANCE}⟨d⟩ from the obstacle",
    rf"{100 * layers.PLUG_SHEAR:g} % of (the mean|what it does) below",
    rf"{MIN_BONDS} coherent",
    # The regime of a chute at rest, which `sim.engine.systems.chute` defines.
    r"V < 1e-3 √\(gσ\)",
)


def named(template: str) -> set[str]:
    """Return the bounds that a template names."""
    return {re.split(r"[.[]", name)[0] for _, name, *_ in Formatter().parse(template) if name}


@pytest.mark.parametrize("claim", claims(), ids=lambda claim: claim.id)
def test_every_number_of_a_criterion_is_a_bound_that_its_judge_takes(claim):
    bare = "".join(text for text, *_ in Formatter().parse(claim.criterion))
    assert not re.findall(r"\d", re.sub("|".join(NAMES), "", bare)), bare
    arguments = inspect.signature(claim.judge).parameters.values()
    taken = {one.name for one in arguments if one.kind == one.KEYWORD_ONLY}
    assert taken == set(claim.bounds_at())
    # A bound that another reading changes is told by the words of that reading.
    other = {name for changes in claim.alternatives.values() for name in changes}
    assert set(claim.bounds) - other <= named(claim.criterion) | named(claim.reason)


@pytest.mark.parametrize("claim", claims(), ids=lambda claim: claim.id)
def test_no_text_of_a_claim_is_left_with_braces(claim):
    texts = claim.model_dump() | claim.texts()
    words = {key: text for key, text in texts.items() if isinstance(text, str)}
    assert not [key for key, text in words.items() if re.search("[{}]", text)]


def numbers_of(bound) -> set[float]:
    """Return the numbers of a bound, however it is nested."""
    return set.union(*map(numbers_of, bound)) if isinstance(bound, list) else {bound}


CONDITIONAL = [claim for claim in claims() if claim.condition]


@pytest.mark.parametrize("claim", CONDITIONAL, ids=lambda claim: claim.id)
def test_a_condition_has_the_numbers_of_the_criterion(claim):
    bounds = set().union(*map(numbers_of, claim.bounds_at().values()))
    words = re.sub("|".join(NAMES), "", claim.condition)
    numbers = {float(number.replace(",", "")) for number in re.findall(r"\d[\d.,]*", words)}
    assert numbers <= bounds


def test_a_criterion_whose_braces_name_no_bound_is_refused():
    fields = dict(claims()[0]) | {"bounds": {"low": 15}, "reason": "ours"}
    assert Claim(**fields | {"criterion": "above {low} Hz"}).texts()["criterion"] == "above 15 Hz"
    for criterion in ("above {high} Hz", "above {low[0]} Hz", "above {low:word} Hz", "above {} Hz"):
        with pytest.raises(ValidationError, match="one that fits each brace"):
            Claim(**fields | {"criterion": criterion})


@pytest.mark.parametrize(
    ("template", "text"),
    [
        ("{low} to {low:percent} %", "0.1 to 10 %"),
        ("{low:words} of it, {many:times} as much", "a tenth of it, twice as much"),
        ("{few:times}, {few:words}", "3 times, 3"),
        ("{tiny:.0e}, {many:.2f}", "1e-3, 2.00"),
        ("{pairs} or {line:and}, {line[1]}", "(0, 50), (10, 10) or 1.5, 1 and 0.5, 1"),
    ],
)
def test_texts_are_filled_as_the_tables_write_numbers(template, text):
    numbers = {"low": 0.1, "many": 2, "few": 3, "tiny": 0.001}
    lists = {"pairs": [[0, 50], [10, 10]], "line": [1.5, 1, 0.5]}
    assert fill(template, numbers | lists) == text
