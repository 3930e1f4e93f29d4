"""Likelihoods: errors of a surrogate that go together, and regimes that measurements ask for."""

from dataclasses import dataclass, replace

import numpy as np
import pytest
from scipy.special import ndtr
from scipy.stats import multivariate_normal, norm

from sim.surrogates import likelihood
from sim.surrogates.likelihood import Calibration
from sim.surrogates.posterior import MOST_UNCOUNTED, attributes, check_draws
from tests.made.surrogates import made_surrogate
from tests.surrogates.predictors import MadePredictor


def calibration(count: int, **options) -> Calibration:
    """Return measurements of a made surrogate, two at the first depth."""
    made = made_surrogate(count=16, error=0.2, scatter=True)
    depths = np.array([2.0, *np.linspace(2, 10, count - 1)])
    errors = np.linspace(0.02, 0.05, count)
    return Calibration(
        made, {"friction": (0.2, 0.8)}, {"depth": depths}, 1 + 0.1 * depths, errors, "velocity",
        **options,
    )  # fmt: skip


def dense(made: Calibration, friction: float, size: float) -> float:
    """Return the logarithm of the density of the measurements, from the whole covariance."""
    depths = made.conditions["depth"]
    x = np.column_stack([np.full(len(depths), friction), depths])
    mean, error = made.predictor.predict(x)
    shared = made.predictor.correlation(x[None], x[None])[0] * np.outer(error, error)
    own = np.diag(made.errors**2 + (size * made.usual_error) ** 2)
    return float(multivariate_normal(mean, shared + own).logpdf(made.values)) - size**2 / 2


@pytest.mark.parametrize(("count", "error"), [(2, 0.01), (6, 0.05), (20, 0.05), (60, 0.2)])
def test_the_density_is_that_of_correlated_errors_whole_or_in_parts(count, error, monkeypatch):
    made, draws = calibration(count), np.random.default_rng(1).random((5, 2))
    exact = [dense(made, 0.2 + 0.6 * share, size) for share, size in draws]
    found = made.log_probability(draws)
    assert found - found[0] == pytest.approx(np.array(exact) - exact[0], rel=error, abs=error)
    monkeypatch.setattr(likelihood, "_MOST_NUMBERS", 50 * count)
    assert made.log_probability(draws) == pytest.approx(found, rel=1e-3)


def test_many_measurements_do_not_average_the_error_of_the_surrogate_away():
    """At equal conditions a measurement repeated is one with a smaller error."""
    one, draws = calibration(4), np.random.default_rng(1).random((5, 1))
    one = replace(one, has_discrepancy=False)
    many = replace(
        one,
        conditions={"depth": np.repeat(one.conditions["depth"], 25)},
        values=np.repeat(one.values, 25),
        errors=5 * np.repeat(one.errors, 25),
    )
    few, repeated = one.log_probability(draws), many.log_probability(draws)
    assert repeated - repeated[0] == pytest.approx(few - few[0], rel=0.05, abs=0.05)


@dataclass
class Bed(MadePredictor):
    """A flow that rests at angles below a limit, which grows with the friction."""

    def __post_init__(self):
        super().__post_init__()
        self.regimes.names = ("arrested", "steady")

    def probability(self, x):
        flows = ndtr((x[:, 1] - 10 - 20 * x[:, 0]) / 0.5)
        return np.array([1 - flows, flows])


#: Velocity as a function of friction and angle; a bed of friction 0.5 flows from 20 degrees on.
BED = Bed(lambda friction, angle: angle / 10 - friction, [(0, 1), (10, 40)], 0.01)


def bed(angles, values, error=0.02) -> Calibration:
    angles, values = np.array(angles, float), np.array(values, float)
    errors = np.full(len(angles), error)
    return Calibration(BED, {"x0": (0, 1)}, {"x1": angles}, values, errors, "velocity")


def at(made, *frictions):
    return made.log_probability(np.column_stack([frictions, np.zeros(len(frictions))]))


def test_a_flow_asks_for_the_regime_at_its_least_sure_condition_once():
    plain = replace(BED, mean_regimes=("steady", "arrested"))
    for angles in ([19.0], [19.0, 25.0], [19.0] * 40):
        made = bed(angles, [angle / 10 - 0.5 for angle in angles])
        asked = at(made, 0.3, 0.5) - at(replace(made, predictor=plain), 0.3, 0.5)
        assert asked == pytest.approx(np.log(ndtr([6.0, -2.0])), abs=1e-9)


def test_a_bed_at_rest_is_not_punished_where_it_rests():
    """0 at 15 degrees is what friction 0.6 gives, and friction 0.1 does not."""
    made = bed([15.0, 30.0], [0.0, 2.4])
    assert made.may_rest.tolist() == [True, False]
    rests, flows = at(made, 0.6, 0.1)
    alone = at(bed([30.0], [2.4]), 0.6)[0]
    assert rests == pytest.approx(alone - 2 * np.log(0.02) / 2 + 0.0, abs=0.01)
    assert flows < rests - 100
    check = check_draws(made, np.column_stack([np.full(50, 0.6), np.full(50, 0.1)]))
    assert np.abs(check.repeated[:, 0]).max() < 0.1 and check.uncounted == 0
    assert check.repeated[:, 1] == pytest.approx(2.4, abs=0.1)


def test_of_beds_at_rest_the_least_sure_rest_first():
    """Where the limit lies is one question: either none, the lower or both rest."""
    made = bed([19.0, 20.0], [0.01, -0.01], error=1.0)
    means = np.array([1.9, 2.0]) - 0.5
    flowing = norm.pdf(made.values, means, np.hypot(1.0, 0.01))
    resting = norm.pdf(made.values, 0, 1.0)
    lower, upper = ndtr([-2.0, 0.0])
    exact = (
        lower * flowing.prod()
        + (upper - lower) * flowing[1] * resting[0]
        + (1 - upper) * resting.prod()
    )
    sure = norm.pdf(made.values, means + 0.5, np.hypot(1.0, 0.01)).prod()
    found = at(made, 0.5, 0.0)
    assert found[0] - found[1] == pytest.approx(np.log(exact / sure))


@pytest.mark.parametrize(("friction", "fits"), [(0.3, True), (0.7, False)])
def test_draws_where_nothing_flows_are_no_fit(friction, fits):
    made = bed([20.0, 21.0], [2.0 - friction, 2.1 - friction])
    draws = np.column_stack([np.full(50, friction), np.full(50, 0.1)])
    check = check_draws(made, draws)
    assert check.repeated.shape == (50, 2) and check.probability > 0.05
    assert (check.uncounted <= MOST_UNCOUNTED) == fits
    about = attributes(made, check, 1000, 10.0)
    assert about["outcome"] == ("converged" if fits else "no fit")
    assert about["uncounted_regime"] == "arrested" and sum(about["regime_shares"]) == pytest.approx(
        1
    )
