"""Points of figures: one at each position of a curve, and of several readings the first."""

from dataclasses import replace

import pandas as pd
import pytest

from sim.base.errors import InputError
from sim.figures.data import split_curves
from sim.parameters import SYSTEMS, BeltParameters, ChuteParameters
from sim.report.points import as_table
from sim.study.figure_spec import FIGURES
from sim.study.load import Study, parse_study


@pytest.fixture
def parse(tmp_path):
    def parse(*series: dict, **others) -> Study:
        entries = [{"name": "a", "system": "belt"} | entry for entry in series]
        return parse_study(
            {"study": "s", "series": entries} | others, "study.yaml", tmp_path / "results"
        )

    return parse


SEVERAL = {"frequency": [10, 15, 25], "steps_per_cycle": [2000, 8000]}
NUMERICS = {"grid": SEVERAL | {"integrator": ["gear", "verlet"]}, "figures": ["gallas_1b"]}


def test_two_points_at_one_place_of_a_curve_are_refused(parse):
    with pytest.raises(InputError) as refused:
        parse(NUMERICS)
    message = str(refused.value)
    assert message.startswith("study.yaml: series[0].figures[0]: got gallas_1b with two points at ")
    assert "frequency = 10" in message
    assert "that differ in steps_per_cycle (2000, 8000), which" in message
    assert "\n" not in message and "integrator" not in message
    # Points that feed no curve may differ in anything.
    assert len(parse(NUMERICS | {"figures": []}).points) == 12
    one = {"grid": {"frequency": [20, 30]}, "figures": ["gallas_1a"]}
    faster = {"grid": one["grid"] | {"initial_velocity": [0, 4]}}
    with pytest.raises(InputError, match=r"differ in initial_velocity \(0, 4\)"):
        parse(one | faster)
    with pytest.raises(InputError, match=r"seed \(1, 2\) \(series a and b\)"):
        parse(one, one | {"name": "b", "base": {"seed": 2}})


def test_a_figure_about_starts_tells_them_apart_and_a_map_has_a_marker_for_every_point(parse):
    grid = {"shear_damping": [50, 100], "initial_velocity": [0, 4]}
    study = parse({"base": {"frequency": 80}, "grid": grid, "figures": ["gallas_3c"]})
    assert len(study.figures["gallas_3c"]) == 4
    grid = {"depth": [2, 5], "angle": [15, 17], "seed": [1, 2]}
    study = parse({"system": "chute", "grid": grid, "figures": ["regimes_angle"]})
    assert len(study.figures["regimes_angle"]) == 8


@pytest.mark.parametrize(
    ("figure", "name"),
    [
        (figure, name)
        for figure, model in {"walton_2": ChuteParameters, "gallas_1b": BeltParameters}.items()
        for name in model.model_fields
        if name not in ("system", "depth", "frequency")
    ],
)
def test_the_study_tells_apart_what_the_curves_do(figure, name):
    spec = FIGURES[figure]
    (along,) = spec.axes
    first = SYSTEMS[spec.system]()
    value = getattr(first, name)
    kinds = {str: "other", bool: not value}
    other = kinds[type(value)] if type(value) in kinds else value + 1
    second = first.model_copy(update={name: other})
    rows = pd.DataFrame([first.model_dump(), second.model_dump()])
    names = [name for name in type(first).model_fields if name not in spec.alike]
    curves = split_curves(rows, along, spec.groups, tuple(names))
    assert (spec.place(first) != spec.place(second)) == (len(curves) == 2)


def test_points_left_out_are_counted_with_the_values_taken(parse):
    study = parse({"grid": {"frequency": [10, 15, 25, 60]}, "figures": ["gallas_2a", "gallas_1a"]})
    sentence = "gallas_2a leaves out 2 of 4 points: it takes frequency 10, 20, 60, 80"
    assert study.omission_notes == [sentence]
    assert sentence in as_table(study).splitlines()


def test_the_table_warns_of_caveats_known_before_any_run(parse):
    study = parse({"grid": {"frequency": [10, 11, 11.5, 12, 80]}})
    (line,) = (line for line in as_table(study).splitlines() if line.startswith("caveat"))
    ids = list(study.points)
    assert line.startswith("caveat for 4 of 5 points: the time step is beyond the stability")
    assert line.endswith(f"({', '.join(ids[:3])} and 1 more)")
    sound = replace(study, points={ids[-1]: study.points[ids[-1]]})
    assert "caveat" not in as_table(sound)


def study_of(readings, **rest):
    return parse_study({"study": "s", "readings": readings} | rest, "study.yaml", None)


BELTS = {"name": "a", "system": "belt"}
MASSES = {"belt": {"damping_mass": ["reduced", "own"]}}


def test_readings_combine_and_figures_and_boundaries_take_the_first():
    several = {"belt": {"damping_mass": ["own", "reduced"], "belt_ghost": ["below", "centred"]}}
    found = study_of(several, series=[BELTS])
    names = "damping_mass", "belt_ghost"
    points = {tuple(getattr(p.parameters, n) for n in names) for p in found.points.values()}
    assert points == {(m, g) for m in ("own", "reduced") for g in ("below", "centred")}
    figures = ["gallas_1a", "readings_1a"]
    found = study_of(MASSES, series=[BELTS | {"grid": {"frequency": [20, 80]}, "figures": figures}])
    shown = {name: [found.points[one] for one in ids] for name, ids in found.figures.items()}
    assert {p.parameters.damping_mass for p in shown["gallas_1a"]} == {"reduced"}
    assert len(shown["readings_1a"]) == 4
    boundary = {"of": "transport", "along": "frequency", "range": [10, 26], "tolerance": 4}
    found = study_of(MASSES, boundaries=[BELTS | boundary])
    assert len(found.boundaries) == 1
    assert {p.parameters.damping_mass for p in found.points.values()} == {"reduced"}


def test_points_of_all_readings_count_against_the_limit():
    grid = {"frequency": [10 + 0.001 * n for n in range(60_000)]}
    with pytest.raises(InputError, match="120,000 points"):
        study_of(MASSES, series=[BELTS | {"grid": grid}])
