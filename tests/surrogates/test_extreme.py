"""Where a mean is highest: exact functions, noise, regimes, words, and what the command says."""

import numpy as np
import pytest

from sim.base.errors import InputError
from sim.report.predict import predict
from sim.study.design import Axis
from sim.surrogates.answers import Refusal
from sim.surrogates.storage import save_surrogate
from sim.surrogates.surrogate import Surrogate
from tests.made.surrogates import AXES, asked, design, made_sample, made_surrogate

LAW = Axis("law", 0, 1, choices=("walton_braun", "hertz"))

#: The top of `hill` in the unit cube, and in the ranges of friction, depth and stiffness.
TOP = (0.3, 0.6, 0.75)
PLACE = {"friction": 0.38, "depth": 6.8, "stiffness": 10**3.5}


def hill(x: np.ndarray) -> np.ndarray:
    """Return a function of the unit cube with one top, of height 2."""
    return 2 - sum((1 + n) * (x[:, n] - TOP[n]) ** 2 for n in range(x.shape[1]))


def noisy(seed: int, count: int = 24, error: float = 0.03) -> Surrogate:
    x = design(count, 2, seed)
    y = hill(x) + np.random.default_rng(seed).normal(0, error, count)
    return Surrogate.fit(asked(), made_sample(x, y, error=error))


def is_likely(answer, names=("friction", "depth")) -> bool:
    likely = answer.attrs["likely"]
    return all(likely[name][0] <= PLACE[name] <= likely[name][1] for name in names)


def test_the_place_value_and_interval_of_a_top_are_found():
    answer = made_surrogate(hill, 48, AXES).highest()
    assert float(answer["mean"]) == pytest.approx(2, abs=0.01)
    assert float(answer["friction"]) == pytest.approx(PLACE["friction"], abs=0.02)
    assert float(answer["depth"]) == pytest.approx(PLACE["depth"], abs=0.2)
    assert np.log(float(answer["stiffness"])) == pytest.approx(np.log(PLACE["stiffness"]), abs=0.15)
    assert "edge" not in answer.attrs["caveats"]
    upside_down = made_surrogate(lambda x: -hill(x), 48, AXES).lowest()
    assert float(upside_down["mean"]) == pytest.approx(-2, abs=0.01)


def test_the_place_of_noisy_runs_lies_where_it_is_said_to():
    """Of four pairs of ranges of 95 %, three have the top for all but 5 % of chances."""
    answers = [noisy(seed).highest() for seed in range(4)]
    assert sum(map(is_likely, answers)) >= 3
    widths = [
        np.ptp(one.attrs["likely"]["depth"]) for one in (noisy(1, error=3e-3).highest(), answers[1])
    ]
    assert widths[0] < widths[1]


def test_what_is_given_is_held_and_only_the_rest_is_searched():
    surrogate = made_surrogate(hill)
    answer = surrogate.highest(depth=3.0)
    assert float(answer["depth"]) == 3 and set(answer.attrs["likely"]) == {"friction"}
    assert float(answer["friction"]) == pytest.approx(PLACE["friction"], abs=0.02)
    assert float(answer["mean"]) < float(surrogate.highest()["mean"])
    with pytest.raises(InputError, match="speed: given: got 'depth, friction'; allowed: some of"):
        surrogate.highest(depth=3.0, friction=0.4)
    with pytest.raises(InputError, match=r"speed: depth: got 11; allowed: a number in \[2, 10\]"):
        surrogate.highest(depth=11)


def test_an_edge_is_told():
    lowest = made_surrogate(lambda x: 1 + x[:, 0] + x[:, 1] ** 2).lowest()
    assert (float(lowest["friction"]), float(lowest["depth"])) == (0.2, 2.0)
    assert lowest.attrs["caveats"].startswith(
        "friction = 0.2 is at the edge of its range, beyond which it may be lower; depth = 2 is at"
    )


def test_places_whose_regime_has_no_part_in_the_mean_are_no_answer():
    """The function grows into flows that rest, where its mean says nothing."""
    x = design(48, 2)
    words = np.where(x[:, 0] > 0.5, "arrested", "steady")
    surrogate = Surrogate.fit(asked(), made_sample(x, 1 + x[:, 0], regime=words))
    answer = surrogate.highest()
    assert 0.42 < float(answer["friction"]) < 0.56
    assert float(answer["probability"].sel(regime="steady")) >= 0.5
    with pytest.raises(Refusal, match=r"another regime is likelier than steady or .* everywhere"):
        surrogate.highest(friction=0.79)


@pytest.fixture(scope="module")
def of_laws(tmp_path_factory):
    """A surrogate of two parameters and a law, which raises the mean, and its folder."""
    x, axes = design(48, 3), (*AXES[:2], LAW)
    mean = hill(x[:, :2]) + 0.5 * (x[:, 2] >= 0.5)
    surrogate = Surrogate.fit(asked(axes), made_sample(x, mean, axes, error=0.01))
    folder = tmp_path_factory.mktemp("results")
    save_surrogate(surrogate, folder / "surrogates" / "speed.nc")
    return surrogate, folder


def test_words_are_searched(of_laws):
    answer = of_laws[0].highest()
    assert str(answer["law"].item()) == "hertz" and answer.attrs["likely"]["law"] == ("hertz",)
    assert is_likely(answer) and float(answer["mean"]) == pytest.approx(2.5, abs=0.05)
    assert str(of_laws[0].lowest()["law"].item()) == "walton_braun"


def test_the_command_tells_place_and_range_and_a_row_for_each_value_given(of_laws):
    _, folder = of_laws
    lines = predict(folder, ["depth=3,6"], None, False, "table", highest=True).splitlines()
    rows = [line.split() for line in lines[1:3]]
    assert [row[4] for row in rows] == ["3", "6"] and {row[5] for row in rows} == {"hertz"}
    assert rows[0][0].startswith("0.3") and rows[0][1].startswith("(0.") and rows[0][2] == "to"
    assert lines[3].startswith("highest over friction, law; in brackets where it lies with 95 %")
    with pytest.raises(InputError, match="--lowest: got 'given'; allowed: --highest without it"):
        predict(folder, [], None, False, "table", highest=True, lowest=True)


def test_a_number_left_out_is_held_in_the_middle_and_told(of_laws):
    surrogate, folder = of_laws
    lines = predict(folder, ["law=hertz", "depth=5"], None, False, "table").splitlines()
    assert lines[1].split()[:3] == ["0.5", "5", "hertz"] and lines[2] == "held: μ = 0.5"
    held, given = surrogate(law="hertz", depth=5.0), surrogate(law="hertz", depth=5.0, friction=0.5)
    assert held["mean"].identical(given["mean"])
    assert (held.attrs["held"], given.attrs["held"]) == ("μ = 0.5", "")
