"""The table of Walton's claims is complete, and every judge tells how it decides."""

from sim.claims.table import claims

WALTON = [claim for claim in claims() if claim.paper == "walton"]


def test_all_claims_are_in_the_table_in_their_order():
    assert [claim.id for claim in WALTON] == [f"W{number}" for number in range(1, 27)]


def test_each_claim_has_a_judge_of_its_own_that_says_how_it_decides():
    judges = [claim.judging() for claim in WALTON]
    assert [judge.__name__.upper() for judge in judges] == [claim.id for claim in WALTON]
    assert all(judge.__doc__ for judge in judges)


def test_only_claims_on_the_model_are_judged_without_runs():
    assert [claim.id for claim in WALTON if claim.kind == "model"] == ["W1", "W2", "W3", "W4"]
