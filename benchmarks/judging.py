"""How often the judge is right: verdicts on synthetic flows whose truth is known.

Each flow is a series per replicate with a mean, correlations, a drift or several states, and is
analysed like runs. Statements on it lie a known number of half widths from their threshold, on the
true or on the false side. `python -m benchmarks.judging` prints the rates of
docs/validation.md.
"""

import argparse
from collections.abc import Callable
from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np
import xarray as xr

from sim.base.statistics import student
from sim.claims.checks import below, withhold, within
from sim.claims.claim import Claim
from sim.claims.evidence import DEFAULT
from sim.claims.inference import outranks, share_above, trend
from sim.claims.judgement import Judgement, Variant
from sim.claims.place import Place, quotient
from sim.claims.verdict import (
    NOT_REPRODUCED,
    REPRODUCED,
    Check,
    combined_verdict,
)
from sim.dataset.results import Results
from sim.engine.observe.regime import Scales, analyse
from sim.papers.walton.judges.chute import acceleration, reason_unrankable, withhold_unsettled
from sim.parameters import ChuteParameters
from sim.parameters.chute import negligible_acceleration

PAPER = ChuteParameters()

#: Samples of a series, and the time between them (s).
SAMPLES, INTERVAL = 200, 0.1

#: Mean velocity (m/s), fluctuation of a sample and scatter of replicates relative to it.
SPEED, FLUCTUATION, SCATTER = 0.5, 0.05, 0.01

#: Parameters of a flow that judges need.
PLACE_LABELS = ("system", "target", "gravity", "angle", "depth", "diameter")

#: Margin of an equality, and trials that give the half width of a statement.
MARGIN, PILOT = 0.1, 60

#: What orders forgive, and scatter of beds relative to their mean.
ORDER_MARGIN, ORDER_SCATTER = 0.05, 0.02

#: Distances (half widths) of the headline reading and of another one from their threshold.
APART = ((0, 0), (0.5, 0.5), (1, 1), (0.5, -0.5), (1, -1), (1.5, -1.5))

#: Distances from the threshold in half widths, the true side positive, and replicates.
DISTANCES, REPLICATES, TRIALS = (-1, 0, 1, 2), (3, 8), 200


@dataclass(frozen=True)
class Kind:
    """Kind of series: correlation of successive samples, drift over the window, second state.

    ``drift`` is relative to the mean. ``state`` is the velocity of a second state relative to the
    first; half of the replicates are in each.
    """

    correlation: float = 0.3
    drift: float = 0.0
    state: float = 1.0


KINDS = {
    "stationary": Kind(),
    "correlated": Kind(correlation=0.9),
    "drifting": Kind(drift=0.05),
    "two states": Kind(state=1.3),
}


def flow(rng: np.random.Generator, kind: Kind, mean: float, replicates: int) -> dict[str, list]:
    """Return the scalars of the replicates of a flow with a mean velocity (m/s)."""
    slope = negligible_acceleration(PAPER.gravity, PAPER.angle)
    scales = Scales(1e-3 * PAPER.velocity_unit, slope, PAPER.drift, PAPER.target)
    rows: dict[str, list] = {}
    for _ in range(replicates):
        state = kind.state if rng.random() < 0.5 else 1.0
        state_mean = mean * state * (1 + SCATTER * rng.normal())
        analysis = analyse(_series(rng, kind, state_mean), INTERVAL, scales)
        row = {
            "status": "completed",
            "velocity": analysis.velocity.value,
            "velocity_half_width": analysis.velocity.half_width,
            "acceleration": analysis.acceleration.value,
            "acceleration_half_width": analysis.acceleration.half_width,
            "independent_samples": analysis.independent,
            "average_start": 0.0,
            "steps": float(SAMPLES),
            "time_step_used": INTERVAL,
            "regime": analysis.regime,
            "quality": analysis.quality,
            "stopped": "length",
            "reason": "",
        }
        for name, value in row.items():
            rows.setdefault(name, []).append(value)
    return rows


def _series(rng: np.random.Generator, kind: Kind, mean: float) -> np.ndarray:
    """Return a velocity per sample (m/s), correlated from one to the next."""
    noise, rho = rng.normal(size=SAMPLES), kind.correlation
    fluctuation = np.empty(SAMPLES)
    fluctuation[0] = noise[0]
    for k in range(1, SAMPLES):
        fluctuation[k] = rho * fluctuation[k - 1] + np.sqrt(1 - rho**2) * noise[k]
    drift = kind.drift * (np.arange(SAMPLES) / SAMPLES - 0.5)
    return mean * (1 + FLUCTUATION * fluctuation + drift)


def places(rng: np.random.Generator, kind: Kind, means: list[float], replicates: int):
    """Return a place per mean velocity, as a judge sees the points of a study."""
    rows = [flow(rng, kind, mean, replicates) for mean in means]
    data = {
        name: (("point", "replicate"), np.array([row[name] for row in rows], dtype=object))
        for name in rows[0]
    }
    data = {
        name: (dims, values.astype(float) if not isinstance(values[0, 0], str) else values)
        for name, (dims, values) in data.items()
    }
    ids = [f"flow-{k}" for k in range(len(means))]
    labels = {name: ("point", [getattr(PAPER, name)] * len(ids)) for name in PLACE_LABELS}
    dataset = xr.Dataset(data, coords={"point": ids} | labels)
    results = Results(dataset, {}, None)  # type: ignore[arg-type]
    return [Place(results, point) for point in ids]


Statement = Callable[[np.random.Generator, Kind, float, int], Check]


def _is_slower(rng: np.random.Generator, kind: Kind, apart: float, replicates: int) -> Check:
    """Return the check that a flow is slower than another, by the relative difference ``apart``."""
    slow, fast = places(rng, kind, [SPEED * (1 - apart), SPEED], replicates)
    check = below("V over V", quotient(slow.velocity, fast.velocity), 1, (slow, fast))
    return withhold_unsettled([check], (slow, fast))[0]


def _are_equal(rng: np.random.Generator, kind: Kind, apart: float, replicates: int) -> Check:
    """Return the check that two flows are equally fast within a margin, ``apart`` inside it."""
    first, second = places(rng, kind, [SPEED * (1 + MARGIN - apart), SPEED], replicates)
    ratio = quotient(first.velocity, second.velocity)
    check = within("V over V", ratio, 1 - MARGIN, 1 + MARGIN, (first, second))
    return withhold_unsettled([check], (first, second))[0]


def _are_rising(rng: np.random.Generator, kind: Kind, apart: float, replicates: int) -> Check:
    """Return the check that four flows are ever faster, by ``apart`` between the ends."""
    means = [SPEED * (1 + apart * k / 3) for k in range(4)]
    flows = places(rng, kind, means, replicates)
    check = trend("V", [[place.values("velocity") for place in flows]], flows)
    return withhold([check], next(filter(None, map(reason_unrankable, flows)), ""))[0]


def _ranks_above(rng: np.random.Generator, kind: Kind, apart: float, replicates: int) -> Check:
    """Return the check that a flow ranks above another, faster by ``apart``."""
    pair = places(rng, kind, [SPEED * (1 + apart), SPEED], replicates)
    return outranks("V", pair[0].values("velocity"), pair[1].values("velocity"), pair)


STATEMENTS: dict[str, Statement] = {
    "bound": _is_slower,
    "equality": _are_equal,
    "trend": _are_rising,
    "rank": _ranks_above,
}


def half_width(rng: np.random.Generator, kind: Kind, replicates: int) -> float:
    """Return the median half width of the ratio of two velocities, relative to it."""
    widths = [_is_slower(rng, kind, 0.0, replicates).half_width for _ in range(PILOT)]
    return float(np.median(widths))


def rates(
    statement: str, kind: str, replicates: int, distance: float, trials: int = TRIALS
) -> tuple[float, float]:
    """Return how often a statement is reproduced, and how often it is not reproduced.

    Parameters
    ----------
    statement, kind : str
        Of `STATEMENTS` and `KINDS`.
    replicates : int
        Of each flow.
    distance : float
        From the threshold, in half widths of the 95 % interval; true where positive.
    trials : int
        Sets of flows that are judged.

    Returns
    -------
    tuple of float
        Not-a-number for an equality where ``distance`` exceeds the margin.
    """
    rng = np.random.default_rng([trials, replicates, *map(ord, statement + kind)])
    apart = distance * half_width(rng, KINDS[kind], replicates)
    if statement == "equality" and apart > MARGIN:
        return np.nan, np.nan
    judge = STATEMENTS[statement]
    verdicts = [
        combined_verdict([judge(rng, KINDS[kind], apart, replicates)]) for _ in range(trials)
    ]
    return tuple(
        np.mean([verdict == expected for verdict in verdicts])
        for expected in (REPRODUCED, NOT_REPRODUCED)
    )


def steadiness(gain: float, replicates: int, trials: int = TRIALS) -> tuple[float, float]:
    """Return how often a flow that gains a share of g sin θ is steady and accelerating.

    The criterion of the papers' steady flows: less than 1 % of g sin θ.
    """
    rng = np.random.default_rng([trials, replicates, int(1e4 * gain)])
    verdicts = []
    for _ in range(trials):
        drift = gain * PAPER.gravity * np.sin(np.radians(PAPER.angle)) * SAMPLES * INTERVAL / SPEED
        (place,) = places(rng, Kind(drift=drift), [SPEED], replicates)
        verdicts.append(
            combined_verdict([within("dV/dt", acceleration(place), -0.01, 0.01, (place,))])
        )
    return tuple(
        np.mean([verdict == expected for verdict in verdicts])
        for expected in (REPRODUCED, NOT_REPRODUCED)
    )


def majority_rates(share: float, number: int, trials: int = TRIALS) -> tuple[float, float]:
    """Return how often most of ``number`` runs are judged to be in a state, and not to be.

    ``share`` is the true probability of that state.
    """
    rng = np.random.default_rng([trials, number, int(100 * share)])
    verdicts = [
        combined_verdict([share_above("share", int(count), number, 0.5)])
        for count in rng.binomial(number, share, trials)
    ]
    return tuple(
        np.mean([verdict == expected for verdict in verdicts])
        for expected in (REPRODUCED, NOT_REPRODUCED)
    )


def joint_rates(
    votes: int, distance: float, odd: float, replicates: int, trials: int = TRIALS
) -> tuple[float, float]:
    """Return how often a claim of ``votes`` bounds is reproduced, and how often not reproduced.

    All but one lie ``distance`` half widths from their thresholds, and one lies ``odd`` of them.
    """
    rng = np.random.default_rng([trials, votes, replicates, int(10 + distance), int(10 + odd)])
    kind = KINDS["stationary"]
    width = half_width(rng, kind, replicates)
    apart = [odd * width] + [distance * width] * (votes - 1)
    verdicts = [
        combined_verdict(
            [_is_slower(rng, kind, distance_apart, replicates) for distance_apart in apart]
        )
        for _ in range(trials)
    ]
    return tuple(
        np.mean([verdict == expected for verdict in verdicts])
        for expected in (REPRODUCED, NOT_REPRODUCED)
    )


def rates_by_replicates(
    statement: str, kind: str, numbers: tuple[int, ...], trials: int = TRIALS
) -> list[float]:
    """Return how often a true statement is reproduced, for each number of replicates.

    Its distance from the threshold is one half width at the first number. Not-a-number for an
    equality where this distance exceeds the margin.
    """
    rng = np.random.default_rng([trials, *map(ord, statement + kind)])
    apart, judge = half_width(rng, KINDS[kind], numbers[0]), STATEMENTS[statement]
    if statement == "equality" and apart > MARGIN:
        return [np.nan] * len(numbers)
    return [
        float(
            np.mean(
                [
                    judge(rng, KINDS[kind], apart, replicates).verdict == REPRODUCED
                    for _ in range(trials)
                ]
            )
        )
        for replicates in numbers
    ]


def look_rates(looks: int, distance: float, counted: bool, trials: int) -> tuple[float, float]:
    """Return how often a bound is called held and failed when beds are bought until it is decided.

    The first look has 8 beds, each further one half as many again. The value lies ``distance`` of
    its first half widths beyond the threshold. ``counted``: the judge knows of the looks.
    """
    rng = np.random.default_rng([trials, looks, int(10 + distance)])
    outcomes = {REPRODUCED: 0, NOT_REPRODUCED: 0}
    for _ in range(trials):
        beds, width = rng.normal(size=8), float(student(7)) / np.sqrt(8)
        shift = distance * width
        for look in range(1, looks + 1):
            error = float(beds.std(ddof=1)) / np.sqrt(beds.size)
            half = float(student(beds.size - 1)) * error
            check = Check(
                "V",
                float(beds.mean()) + shift,
                half,
                0.0,
                np.inf,
                freedom=beds.size - 1,
                looks=look if counted else 0,
            )
            if check.verdict in outcomes:
                outcomes[check.verdict] += 1
                break
            beds = np.concatenate([beds, rng.normal(size=beds.size // 2)])
    return outcomes[REPRODUCED] / trials, outcomes[NOT_REPRODUCED] / trials


def order_rates(reversal: float, looks: int, trials: int) -> tuple[float, float]:
    """Return how often an order of five points is called held and failed.

    Two of them are reversed by a share, and beds are bought for these until the order is decided:
    eight at first, half as many again at each further look. Another point has had five looks.
    """
    rng = np.random.default_rng([trials, looks, int(1e4 * reversal)])
    means = np.array([1.0, 1.5, 1.5 / (1 + reversal), 2.0, 2.5])
    outcomes = {REPRODUCED: 0, NOT_REPRODUCED: 0}
    for _ in range(trials):
        beds = [mean * (1 + ORDER_SCATTER * rng.normal(size=8)) for mean in means]
        for look in range(1, looks + 1):
            watched = (1, look, look, 1, 5)
            points = [
                SimpleNamespace(id=f"{number}", samples=99, freedom=7, looks=one)
                for number, one in enumerate(watched)
            ]
            verdict = trend("V", [beds], points, margin=ORDER_MARGIN).verdict
            if verdict in outcomes:
                outcomes[verdict] += 1
                break
            for one in (1, 2):
                more = rng.normal(size=beds[one].size // 2)
                beds[one] = np.append(beds[one], means[one] * (1 + ORDER_SCATTER * more))
    return outcomes[REPRODUCED] / trials, outcomes[NOT_REPRODUCED] / trials


def dependence_rate(
    readings: int, headline: float, other: float, trials: int, transient: float | None = None
) -> float:
    """Return how often a claim is said to depend on the reading.

    Each reading has 8 beds of its own. The headline reading and all others but one lie ``headline``
    half widths above a threshold, the last one ``other``. With a ``transient`` there are as many
    runs of the paper's length beside these, and those of the last reading lie there.
    """
    rng = np.random.default_rng([trials, readings, int(10 + headline), int(10 + other)])
    claim = Claim(
        id="V",
        title="value",
        statement="beyond a threshold",
        criterion="above 0",
        system="belt",
        judge=lambda evidence: (),
    )
    of_protocols = {"converged": other} | ({} if transient is None else {"published": transient})
    dependent = 0
    for _ in range(trials):
        variants = []
        for protocol, last in of_protocols.items():
            beds = rng.normal(size=(readings, 8))
            errors = beds.std(axis=1, ddof=1) / np.sqrt(8)
            distances = np.array([headline] * (readings - 1) + [last])
            means = beds.mean(axis=1) + distances * float(student(7)) / np.sqrt(8)
            for number, (mean, error) in enumerate(zip(means, errors, strict=True)):
                half = float(student(7)) * float(error)
                check = Check("V", float(mean), half, 0.0, np.inf, freedom=7)
                reading = f"reading {number}" if number else DEFAULT
                variants.append(Variant(protocol, reading, (check,)))
        dependent += Judgement(claim, tuple(variants)).reading_dependent
    return dependent / trials


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.judging", description=__doc__)
    parser.add_argument("--trials", type=int, default=TRIALS, help="sets of flows per number")
    trials = parser.parse_args().trials
    heads = " | ".join(f"{distance:+d}" for distance in DISTANCES)
    print(f"| statement | flows | replicates | {heads} |\n|" + " --- |" * (3 + len(DISTANCES)))
    for statement in STATEMENTS:
        for kind in KINDS:
            for replicates in REPLICATES:
                columns = [rates(statement, kind, replicates, d, trials) for d in DISTANCES]
                cells = " | ".join(
                    f"{100 * reproduced:.0f} / {100 * failed:.0f}" for reproduced, failed in columns
                )
                print(f"| {statement} | {kind} | {replicates} | {cells} |", flush=True)
    print("\n| gain, % of g sin θ | replicates | steady | not steady |\n| --- | --- | --- | --- |")
    for gain in (0.0, 0.005, 0.01, 0.02):
        for replicates in REPLICATES:
            reproduced, failed = steadiness(gain, replicates, trials)
            print(
                f"| {100 * gain:g} | {replicates} | {100 * reproduced:.0f} | {100 * failed:.0f} |"
            )
    print("\n| true share | runs | often | not often |\n| --- | --- | --- | --- |")
    for share in (0.35, 0.5, 0.65, 0.8):
        for number in (10, 40):
            reproduced, failed = majority_rates(share, number, trials)
            print(f"| {share:g} | {number} | {100 * reproduced:.0f} | {100 * failed:.0f} |")
    print("\n| votes | one at | replicates | reproduced | not |\n| --- | --- | --- | --- | --- |")
    for votes in (1, 3, 10):
        for odd in (2, 0, -1, -2):
            for replicates in REPLICATES:
                reproduced, failed = joint_rates(votes, 2, odd, replicates, trials // 2)
                cells = f"{100 * reproduced:.0f} | {100 * failed:.0f}"
                print(f"| {votes} | {odd:+d} | {replicates} | {cells} |", flush=True)
    print("\n| looks | distance | looks not counted | counted |\n| --- | --- | --- | --- |")
    for looks in (1, 2, 4, 9):
        for distance in (0, 1, 2):
            columns = [look_rates(looks, distance, c, 20 * trials) for c in (False, True)]
            cells = " | ".join(f"{100 * held:.1f} / {100 * failed:.1f}" for held, failed in columns)
            print(f"| {looks} | +{distance} | {cells} |", flush=True)
    heads = " | ".join(f"{a:+g} and {b:+g}" for a, b in APART)
    print(f"\n| readings | {heads} |\n|" + " --- |" * (1 + len(APART)))
    for readings in (2, 5, 10, 20):
        cells = (f"{100 * dependence_rate(readings, a, b, 20 * trials):.1f}" for a, b in APART)
        print(f"| {readings} | {' | '.join(cells)} |", flush=True)
    print("\n| converged | the paper's length | depends |\n| --- | --- | --- |")
    for converged, transient in ((0, 0), (1, 1), (1.5, -1.5), (0, -1.5)):
        rate = dependence_rate(
            2, 1.5 if transient < 0 else converged, converged, 20 * trials, transient
        )
        print(f"| {converged:+g} | {transient:+g} | {100 * rate:.1f} |", flush=True)
    shares = (0, 0.025, 0.05, 0.1)
    heads = " | ".join(f"{100 * share:g} %" for share in shares)
    print(f"\n| looks | {heads} |\n|" + " --- |" * (1 + len(shares)))
    for looks in (1, 4):
        columns = [order_rates(share, looks, 5 * trials) for share in shares]
        cells = " | ".join(f"{100 * held:.1f} / {100 * failed:.1f}" for held, failed in columns)
        print(f"| {looks} | {cells} |", flush=True)
    numbers = (3, 6, 12, 24, 48)
    heads = " | ".join(map(str, numbers))
    print(f"\n| statement | flows | {heads} |\n|" + " --- |" * (2 + len(numbers)))
    for statement in STATEMENTS:
        for kind in KINDS:
            reproduced = rates_by_replicates(statement, kind, numbers, trials // 2)
            cells = ["–" if np.isnan(rate) else f"{100 * rate:.0f}" for rate in reproduced]
            print(f"| {statement} | {kind} | {' | '.join(cells)} |", flush=True)


if __name__ == "__main__":
    main()
