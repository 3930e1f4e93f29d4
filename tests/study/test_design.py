"""Designs of a series: their points, their growth, what a study file may say of them."""

import copy
from math import log

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sim.parameters import point_id
from sim.report.points import as_table
from sim.study.design import Axis, axis_of
from sim.study.load import Study, parse_study

OVER = {
    "friction": [0.35, 0.8],
    "stiffness": {"between": [100, 10000], "scale": "log"},
    "restitution": {"mean": 0.85, "deviation": 0.03, "between": [0.6, 0.99]},
    "law": {"choices": ["walton_braun", "hertz"]},
    "steps_per_collision": [20, 23],
}

PINNED = {
    "sobol": "chute-depth2-friction0.478776-restitution0.820489-stiffness1502.17-928bc53f",
    "latin_hypercube": "chute-depth2-friction0.721359-restitution0.825432-stiffness475.818-"
    "law-hertz-49a65a17",
    "random": "chute-depth2-friction0.58032-restitution0.899481-stiffness194.231-"
    "law-hertz-f8472266",
    "saltelli": "chute-depth2-friction0.419959-restitution0.85673-stiffness1640.83-6878725d",
    "morris": "chute-depth2-friction0.35-restitution0.6-stiffness10000-law-hertz-a8b1a348",
}
SECOND = "chute-depth2-friction0.638607-restitution0.887059-stiffness870.299-law-hertz-0454ffca"


def study_of(kind: str = "sobol", over: dict = OVER, series: dict | None = None, **design) -> Study:
    design = {"kind": kind, "over": over} | design
    entry = {"name": "wide", "system": "chute", "base": {"depth": 2}, "design": design}
    contents = {"study": "s", "series": [entry | (series or {})]}
    return parse_study(copy.deepcopy(contents), "s.yaml", None)


def ids(study: Study) -> tuple[str, ...]:
    return study.series["wide"]


def test_ids_are_the_same_on_every_machine():
    where = {"where": ["friction < restitution"]}
    assert ids(study_of(points=4, **where))[:2] == (PINNED["sobol"], SECOND)
    for kind, first in PINNED.items():
        points = {"saltelli": 14, "morris": 12}.get(kind, 4)
        assert ids(study_of(kind, points=points))[0] == first


def test_points_lie_where_the_file_says():
    points = [point.parameters for point in study_of(points=256).points.values()]
    assert len(points) == 256
    frictions = np.array([point.friction for point in points])
    assert 0.35 <= frictions.min() < 0.36
    assert 0.79 < frictions.max() <= 0.8
    # Half of the values lie in either half of the range, of a logarithmic one in its logarithm.
    assert np.mean(frictions < 0.575) == pytest.approx(0.5, abs=0.01)
    assert np.mean([point.stiffness < 1000 for point in points]) == pytest.approx(0.5, abs=0.01)
    restitutions = [point.restitution for point in points]
    assert np.mean(restitutions) == pytest.approx(0.85, abs=0.002)
    assert np.std(restitutions) == pytest.approx(0.03, abs=0.002)
    words = {"law": ("walton_braun", "hertz"), "steps_per_collision": (20, 21, 22, 23)}
    for name, values in words.items():
        counts = [sum(getattr(point, name) == value for point in points) for value in values]
        assert counts == pytest.approx([256 / len(values)] * len(values), abs=4)
    assert {point.depth for point in points} == {2}


@pytest.mark.parametrize(
    ("kind", "few", "more", "where"),
    [
        ("sobol", 5, 64, ["friction < restitution", "stiffness >= 2000"]),
        ("sobol", 32, 64, None),
        ("random", 5, 64, ["friction < 0.4"]),
        ("saltelli", 28, 112, None),
        ("morris", 12, 60, None),
    ],
)
def test_more_points_keep_the_first_ones(kind, few, more, where):
    condition = {"where": where} if where else {}
    before, after = (study_of(kind, points=points, **condition) for points in (few, more))
    assert ids(after)[: len(ids(before))] == ids(before)
    assert len(ids(after)) > len(ids(before))
    design = before.designs["wide"]
    assert design.grows
    following = design.sequence(more - few, after=few)
    assert [*map(point_id, design.sequence(few)), *map(point_id, following)] == [
        point_id(point) for point in after.designs["wide"].sequence(more)
    ]


def test_a_latin_hypercube_spreads_evenly_along_each_parameter_and_does_not_grow():
    study = study_of("latin_hypercube", points=20, over={"friction": [0, 1], "angle": [10, 30]})
    points = [point.parameters for point in study.points.values()]
    assert sorted(int(20 * point.friction) for point in points) == list(range(20))
    assert sorted(int(point.angle - 10) for point in points) == list(range(20))
    design = study.designs["wide"]
    assert not design.grows
    assert len(design.sequence(30)) == 20
    assert "more points later replace these" in as_table(study)


def test_zip_pairs_lists():
    over = {"friction": [0.3, 0.4, 0.3], "depth": [1, 2, 1], "law": ["hertz"] * 3}
    study = study_of("zip", over)
    assert [(p.parameters.friction, p.parameters.depth) for p in study.points.values()] == [
        (0.3, 1),
        (0.4, 2),
    ]
    assert "zip, 3 points over depth, friction, law, of which 2 differ" in as_table(study)
    # Equal points count once.
    same = study_of(points=32, over={"steps_per_collision": [20, 23]})
    assert len(same.points) == 4 and len(same.designs["wide"].sequence(32)) == 32
    some = study_of("zip", over, where=["friction > 0.35"])
    assert [point.parameters.friction for point in some.points.values()] == [0.4]
    assert len(some.designs["wide"].sequence(3)) == some.designs["wide"].size == 1


def test_readings_share_a_design():
    design = {"kind": "sobol", "points": 4, "over": {"frequency": [10, 40]}}
    series = [{"name": "wide", "system": "belt", "design": design}]
    readings = {"belt": {"damping_mass": ["own", "reduced"]}}
    study = parse_study({"study": "s", "readings": readings, "series": series}, "s.yaml", None)
    points = [point.parameters for point in study.points.values()]
    frequencies = [point.frequency for point in points]
    assert frequencies[:4] == frequencies[4:]
    assert [point.damping_mass for point in points] == ["own"] * 4 + ["reduced"] * 4
    assert study.designs["wide"].sequence(4) == points[:4]


@given(
    low=st.floats(1e-3, 1e3),
    width=st.floats(1e-3, 1e3),
    scale=st.sampled_from(["linear", "log"]),
    share=st.floats(0, 1),
)
def test_values_lie_in_their_range(low, width, scale, share):
    axis = Axis("friction", low, low + width, scale)
    (value,) = axis.values(np.array([share]))
    assert low <= value <= low + width
    if low < value < low + width:
        assert value == float(f"{value:.6g}")
    factor = np.exp(share * log((low + width) / low))
    exact = low + width * share if scale == "linear" else low * factor
    assert value == pytest.approx(exact, rel=2e-5)


def test_axes_have_the_ranges_and_scales_of_a_design_or_those_in_which_values_are_even():
    friction, restitution, stiffness, law, steps = study_of(points=4).designs["wide"].axes
    assert friction == Axis("friction", 0.35, 0.8) and restitution.normal == (0.85, 0.03)
    assert stiffness == Axis("stiffness", 100, 10000, "log")
    assert law.choices == ("walton_braun", "hertz") and steps.is_integer and not law.is_number
    grid = {"stiffness": [100, 1000, 10000], "friction": [0.4, 0.5, 0.6], "depth": [2]}
    cases = [{"law": "hertz", "replicates": 3}, {"steps_per_collision": 60}, {}]
    for series, axes in (
        ({"grid": grid}, {Axis("friction", 0.4, 0.6), Axis("stiffness", 100, 10000, "log")}),
        (
            {"cases": cases},
            {
                Axis("law", 0, 1, choices=("hertz", "walton_braun")),
                Axis("steps_per_collision", 40, 60, is_integer=True),
            },
        ),
        ({}, set()),
    ):
        contents = {"study": "s", "series": [{"name": "wide", "system": "chute"} | series]}
        study = parse_study(contents, "s.yaml", None)
        assert set(study.axes["wide"]) == axes and not study.designs
    assert axis_of("depth", [1, 2, 4, 8, 16], False).scale == "log"
    assert axis_of("depth", [0, 1, 10, 100], False).scale == "linear"
