"""Evidence: the point selected for given parameters, and its intervals."""

import numpy as np
import pytest

from sim.base.plugins import load_plugins
from sim.claims.checks import above
from sim.claims.evidence import ANY, Evidence
from sim.claims.place import replicate_mean
from sim.claims.verdict import SIGMAS, Ambiguous, Unbounded, Untestable
from tests.made.processes import ROOT, restore_plugins
from tests.made.results import made_boundary, made_point, made_results


def evidence(*points, protocol="published", reading=None, **options) -> Evidence:
    return Evidence(made_results(*points, **options), protocol, reading)


def belt(velocity=0.1, **parameters):
    return made_point("belt", {"velocity": velocity}, **parameters)


def test_what_is_not_named_has_the_papers_value():
    study = evidence(belt(0.1, frequency=30), belt(0.2, frequency=30, amplitude=1.5))
    assert study.at("belt", frequency=30).velocity.nominal_value == pytest.approx(0.1)
    assert study.at("belt", frequency=30, amplitude=1.5)["amplitude"] == 1.5
    with pytest.raises(Untestable, match="no published run of the belt at frequency 40"):
        study.at("belt", frequency=40)
    with pytest.raises(Untestable, match="no published run of the belt at the paper's values"):
        evidence(belt(0.2, amplitude=1.5)).at("belt")


def test_a_law_of_a_plugin_goes_by_its_name():
    with restore_plugins():
        load_plugins(ROOT / "docs" / "examples" / "hertz_mindlin.py")
        study = evidence(
            made_point("chute", {"velocity": 1.0}, depth=3),
            made_point("chute", {"velocity": 2.0}, depth=3, law="hertz_mindlin"),
        )
        place = study.at("chute", depth=3, law="hertz_mindlin")
        assert place.velocity.nominal_value == pytest.approx(2)
        assert study.at("chute", depth=3, law=place["law"])["law"].startswith("hertz_mindlin.")
        assert list(study.line("chute", "depth", law="hertz_mindlin")) == [3]
        with pytest.raises(Untestable, match="law hertz_mind,"):
            study.at("chute", depth=3, law="hertz_mind")


def test_protocols_and_readings_are_kept_apart():
    points = (
        belt(0.1),
        belt(0.2, protocol="converged"),
        belt(0.3, belt_ghost="centred"),
    )
    assert evidence(*points).at("belt").velocity.nominal_value == pytest.approx(0.1)
    place = evidence(*points, protocol="converged").at("belt")
    assert place.velocity.nominal_value == pytest.approx(0.2)
    place = evidence(*points, reading={"belt_ghost": "centred"}).at("belt")
    assert place.velocity.nominal_value == pytest.approx(0.3)


def test_numerical_settings_may_be_any_but_defaults_and_richer_points_come_first():
    chutes = [
        made_point("chute", {"velocity": 1.0}, depth=10, replicates=2, sample_interval=0.5),
        made_point("chute", {"velocity": 1.001}, depth=10, replicates=8, cell=5),
        made_point("chute", {"velocity": 1.002}, depth=10, replicates=4),
    ]
    assert evidence(*chutes).at("chute", depth=10).velocity.nominal_value == pytest.approx(1.002)
    narrow = evidence(*chutes).at("chute", depth=10, cell=5)
    assert narrow.velocity.nominal_value == pytest.approx(1.001)
    assert evidence(chutes[1]).at("chute", depth=10).completed == 8


def chute(velocity, **parameters):
    return made_point("chute", {"velocity": velocity}, **parameters)


#: What a control has that the flows of a line do not: one kind of what changes which flow it is.
CONTROLS = [
    ({"cell": 8}, {}),
    ({"cell": 8}, {"cell": 6}),
    ({}, {"cell": 7}),
    ({"initial_velocity": 2}, {}),
    ({}, {"start_from": "run.nc"}),
]


@pytest.mark.parametrize(("usual", "control"), CONTROLS)
def test_a_control_does_not_stand_in_for_a_flow_of_the_line(usual, control):
    """A cell of 5 that is the default has made gliding layers, three times as fast as the flow."""
    line = [chute(0.1 * angle, angle=angle, depth=12, **usual) for angle in (20, 22, 24)]
    longer = {"angle": 24, "depth": 12, "replicates": 8, "average": 400}
    study = evidence(chute(5.3, **longer, **control), *line)
    flows = study.line("chute", "angle", depth=12)
    assert [flow.velocity.nominal_value for flow in flows.values()] == pytest.approx([2, 2.2, 2.4])
    # Where only the control was run, the line has no flow.
    study = evidence(chute(5.3, angle=26, depth=12, **control), *line)
    assert list(study.line("chute", "angle", depth=12)) == [20, 22, 24]
    differing = [name for name in control or usual]
    any_of_them = study.line("chute", "angle", depth=12, **dict.fromkeys(differing, ANY))
    assert list(any_of_them) == [20, 22, 24, 26]


@pytest.mark.parametrize(
    ("usual", "control"), [*CONTROLS, ({}, {"transient": 900}), ({}, {"steps_per_collision": 80})]
)
def test_two_flows_that_are_both_asked_for_and_differ_are_an_error(usual, control):
    flow, other = chute(1.5, angle=24, **usual), chute(5.3, angle=24, **control)
    study, (name,) = evidence(flow, other), {*usual, *control}
    with pytest.raises(Ambiguous) as error:
        study.at("chute", angle=24)
    assert flow.id in str(error.value) and other.id in str(error.value)
    assert f" differ in {name} (" in str(error.value) and "and in velocity (" in str(error.value)
    value = getattr(flow.parameters, name)
    assert study.at("chute", angle=24, **{name: value}).id == flow.id
    alike = evidence(flow, chute(1.501, angle=24, **control))
    assert alike.at("chute", angle=24).velocity.nominal_value == pytest.approx(1.5, abs=2e-3)


def test_a_line_is_in_order_and_leaves_out_what_failed():
    lost = made_point("belt", {"velocity": 0.3, "status": "failed"}, frequency=50)
    study = evidence(belt(frequency=40), belt(frequency=20), lost)
    assert list(study.line("belt", "frequency")) == [20, 40]
    assert study.line("belt", "frequency", amplitude=1.5) == {}


def test_intervals_are_students_and_never_below_the_own_error():
    values = [1.0, 1.2, 1.1]
    place = evidence(made_point("belt", {"velocity": values, "shear_power": values}, replicates=3))
    place = place.at("belt")
    half_width = 4.3027 * np.std(values, ddof=1) / np.sqrt(3)
    assert SIGMAS * place.value("shear_power").std_dev == pytest.approx(half_width, rel=1e-4)
    assert SIGMAS * place.velocity.std_dev == pytest.approx(half_width, rel=1e-4)
    assert replicate_mean(np.array([1.0])).std_dev == np.inf


def test_samples_are_those_of_all_replicates_and_those_of_the_poorest_place_count():
    rich = made_point("belt", {"velocity": 0.2, "independent_samples": 10.0}, frequency=30)
    poor = made_point("belt", {"velocity": 0.1, "independent_samples": 1.0}, frequency=20)
    study = evidence(rich, poor)
    places = (
        study.at("belt", frequency=30),
        study.at("belt", frequency=20),
    )
    assert [place.samples for place in places] == pytest.approx([50, 5], rel=0.01)
    check = above("gain", places[0].velocity - places[1].velocity, 0, places)
    assert check.samples == places[1].samples
    assert check.points == tuple(place.id for place in places)


def onset(low, high=None, **parameters):
    """Return a boundary of transport."""
    return made_boundary("belt", "transport", "frequency", low, high or low + 0.25, **parameters)


def test_the_narrowest_bracket_of_a_boundary_is_its_interval():
    brackets = [
        row
        for seed in (1, 2)
        for row in (
            onset(15.0, 16.0, seed=seed),
            onset(15.5, 15.75, seed=seed, steps_per_cycle=4000),
            onset(12.0, 13.0, seed=seed, amplitude=1.5),
        )
    ]
    study = evidence(belt(), boundaries=brackets)
    found = study.boundary("belt", "transport", "frequency")
    assert found.nominal_value == pytest.approx(15.625)
    # The ends of the bracket are bounds of one side.
    assert SIGMAS * found.std_dev == pytest.approx(0.125 * 1.96 / 1.645, rel=1e-3)
    assert study.boundary("belt", "transport", "frequency", amplitude=1.5).nominal_value == 12.5
    with pytest.raises(Untestable, match="no boundary of transport"):
        study.boundary("belt", "transport", "frequency", amplitude=0.5)
    # How much starts differ is not known from one seed.
    study = evidence(belt(), boundaries=[onset(15.0, seed=1), onset(12.0, seed=2, amplitude=1.5)])
    assert study.boundary("belt", "transport", "frequency").std_dev == np.inf


def test_a_boundary_is_none_where_one_seed_of_it_has_none():
    lacking = [onset(15.5, seed=1), onset(np.nan, seed=2, verdict="none")]
    study = evidence(belt(), boundaries=lacking)
    with pytest.raises(Unbounded, match="frequency at the paper's values found from seed 2"):
        study.boundary("belt", "transport", "frequency")
    finer = [onset(15.0, seed=seed, steps_per_cycle=4000) for seed in (1, 2)]
    other = [onset(12.0, seed=seed, amplitude=1.5) for seed in (1, 2)]
    study = evidence(belt(), boundaries=[*lacking, *finer, *other])
    assert study.boundary("belt", "transport", "frequency").nominal_value == 15.125
    assert study.boundary("belt", "transport", "frequency", amplitude=1.5).nominal_value == 12.125
