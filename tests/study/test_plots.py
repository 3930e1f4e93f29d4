"""Plots of a study file: entries like those of the catalogue, and refused plots."""

from types import SimpleNamespace

import pytest

from sim.base.errors import InputError
from sim.base.plugins import load_plugins
from sim.parameters import SYSTEMS
from sim.study.load import Study, parse_study
from sim.study.plot_kinds import Answer, FigureSpec, find_kind, study_kinds
from tests.made.plugins import restore_plugins

SERIES = {
    "name": "flows",
    "system": "chute",
    "grid": {"friction": [0.3, 0.4], "angle": [16, 17], "law": ["walton_braun", "spring_dashpot"]},
}
BEDS = {"name": "beds", "system": "belt", "grid": {"frequency": [20, 50]}}
#: A valid plot.
VALID_PLOT = {"name": "v", "x": "friction", "curves": "angle", "panels": "law"}
#: Changes that make it a map of regimes.
REGIME_MAP = {"kind": "map", "y": "angle", "curves": None}


@pytest.fixture
def parse(tmp_path):
    def parse(*plots: dict, series: tuple[dict, ...] = (SERIES,), **others) -> Study:
        mapping = {"study": "s", "series": list(series), "plots": list(plots)} | others
        return parse_study(mapping, tmp_path / "study.yaml", tmp_path / "results")

    return parse


def error_message(parse, plot: dict, **others) -> str:
    with pytest.raises(InputError) as caught:
        parse(plot, **others)
    message = str(caught.value)
    assert "study.yaml: plots[0]." in message and "\n" not in message
    return message.partition("study.yaml: plots[0].")[2]


def test_a_plot_is_an_entry_of_all_points_of_its_series(parse):
    study = parse(VALID_PLOT)
    spec = study.entries["v"]
    assert (spec.kind, spec.system, spec.axes) == ("curves", "chute", ("friction",))
    assert spec.title == "Velocity against friction, by angle and law"
    assert spec.lead.startswith("Velocity: mean velocity over the averaging window, against")
    assert eval(repr(spec), {"FigureSpec": FigureSpec, "Answer": Answer}) == spec
    assert study.figures["v"] == tuple(study.points)
    assert all(point.figures == () for point in study.points.values())


def test_x_of_curves_may_be_an_observable(parse):
    study = parse(VALID_PLOT | {"x": "shear_depth"})
    spec = study.entries["v"]
    assert spec.axes == () and spec.curves == ("angle", "law")
    assert (spec.show, spec.second) == ("velocity", "shear_depth")
    assert spec.title == "Velocity against shear depth, by angle and law"
    assert ", against shear depth (height at which the velocity is" in spec.lead
    assert "friction" in spec.named
    assert parse(VALID_PLOT).entries["v"].second == ""


def test_y_of_profiles_is_another_profile_in_the_same_slices(parse):
    plot = {"name": "p", "kind": "profiles", "x": "granular_temperature", "y": "packing"}
    spec = parse(plot | {"between": [1, 4], "log": ["y"]}).entries["p"]
    assert (spec.show, spec.second) == ("granular_temperature", "packing")
    assert spec.between == (1.0, 4.0)
    assert spec.title == "Packing against granular temperature"
    assert spec.lead.startswith("Packing: packing fraction, against granular temperature (granular")


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"y": "packng"}, "y: got 'packng'; did you mean packing"),
        ({"y": "velocity"}, "y: got 'velocity'; allowed: an observable other than x"),
        ({"y": "shear_depth"}, "y: got 'shear_depth'; allowed: an observable of profiles; shear"),
        ({"y": "overburden"}, "y: got 'overburden'; allowed: points with stress_profiles: true"),
        ({"log": ["y"]}, "log[0]: got 'y'; allowed: one of x"),
        ({"between": [4, 1]}, "between: got [4, 1]; allowed: two heights in diameters, 0 or"),
        ({"between": [-1, 1]}, "between: got [-1, 1]; allowed: two heights in diameters, 0"),
        ({"between": [1]}, "between: got [1]; allowed: two heights in diameters, 0 or more"),
        ({"between": 1}, "between: got 1; allowed: two heights in diameters, 0 or more, the"),
        ({"between": [1, ".inf"]}, "between[1]: got '.inf'; allowed: two heights in diameters"),
        ({"kind": "time_series", "between": [1, 4]}, "between: got [1, 4]; allowed: a key of"),
    ],
)
def test_mistakes_in_profiles_are_refused_by_their_key(parse, change, message):
    assert error_message(parse, {"name": "p", "kind": "profiles"} | change).startswith(message)


@pytest.mark.parametrize(
    ("plot", "key"),
    [
        ({"kind": "profiles"}, "x: got 'velocity'"),
        ({"x": "angle", "y": "packing"}, "y: got 'packing'"),
    ],
)
def test_profiles_that_the_dataset_leaves_out_are_refused(plot, key, parse):
    bare = SERIES | {"profiles": False}
    message = error_message(parse, {"name": "p"} | plot, series=(bare,))
    assert message.startswith(f"{key}; allowed: points of series without profiles: false")


DATA_BESIDE = {"label": "Pouliquen (1999)", "points": [[0.3, 1], [0.6, 2.5]]}


def test_data_beside_a_plot_are_kept_with_it(parse):
    spec = parse(
        VALID_PLOT | {"beside": [DATA_BESIDE, DATA_BESIDE | {"label": "law", "line": True}]}
    ).entries["v"]
    points = ((0.3, 1.0), (0.6, 2.5))
    assert spec.beside == (("Pouliquen (1999)", points, False), ("law", points, True))
    assert eval(repr(spec), {"FigureSpec": FigureSpec, "Answer": Answer}) == spec


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"label": " "}, "beside[0].label: got ' '; allowed: a text that is not empty"),
        ({"label": "a" * 61}, "beside[0].label: got 'aaa"),
        (
            {"label": "a\u202eb"},
            "beside[0].label: got 'a\\u202eb'; allowed: one line of at most 60",
        ),
        ({"points": []}, "beside[0].points: got []; allowed: a list of points [x, y], numbers"),
        (
            {"points": [[1, -1e101]]},
            "beside[0].points[0][1]: got -1e+101; allowed: a list of points",
        ),
        ({"points": [0.3, 1]}, "beside[0].points[0]: got 0.3; allowed: a list of points [x, y]"),
        ({"points": [[1, 2, 3]]}, "beside[0].points[0]: got [1, 2, 3]; allowed: a list of points"),
        ({"points": [[1, float("nan")]]}, "beside[0].points[0][1]: got nan; allowed: finite, a"),
        ({"points": [[1, 2]], "line": True}, "beside[0].points: got [[1, 2]]; allowed: at least"),
        ({"colour": "red"}, "beside[0].colour: unknown key, got 'red'; "),
    ],
)
def test_mistakes_in_data_beside_are_refused_by_their_key(parse, change, message):
    assert error_message(parse, VALID_PLOT | {"beside": [DATA_BESIDE | change]}).startswith(message)


def test_data_beside_without_a_place_are_refused(parse):
    nonpositive_data = DATA_BESIDE | {"points": [[0.3, 1], [0.4, 0]]}
    message = error_message(parse, VALID_PLOT | {"log": ["y"], "beside": [nonpositive_data]})
    assert message.startswith("beside[0].points[1]: got [0.4, 0]; allowed: numbers >= 1e-100 on")
    assert parse(VALID_PLOT | {"log": ["x"], "beside": [nonpositive_data]}).plots
    message = error_message(parse, VALID_PLOT | {"beside": [DATA_BESIDE, DATA_BESIDE]})
    assert message.startswith("beside[1].label: got 'Pouliquen (1999)'; allowed: a label of its")
    message = error_message(parse, VALID_PLOT | {"kind": "distribution", "beside": [DATA_BESIDE]})
    assert message.startswith("beside: got 'Pouliquen (1999)'; allowed: a key of distribution")
    message = error_message(
        parse, VALID_PLOT | {"beside": [DATA_BESIDE | {"label": str(n)} for n in range(7)]}
    )
    assert "allowed: a list of at most 6" in message


FILE_BESIDE = {"file": "exp.csv", "x": "mu", "y": "V", "yerr": "s"}


def test_data_beside_may_be_columns_of_a_file_which_belongs_to_the_study(parse, tmp_path):
    (tmp_path / "exp.csv").write_text("mu,V (mm/s),s (mm/s)\n0.3,250,0\n0.5,200,4\n")
    study = parse(VALID_PLOT | {"beside": FILE_BESIDE})
    assert study.plots["v"].beside == (("exp", ((0.3, 0.25, 0.0), (0.5, 0.2, 0.004)), False),)
    assert study.data == (tmp_path / "exp.csv",) and study.data[0] in study.sources
    one = FILE_BESIDE | {"label": "glass", "line": True}
    assert parse(VALID_PLOT | {"beside": [one]}).plots["v"].beside[0][::2] == (
        "glass",
        True,
    )


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"file": "other.csv"}, "other.csv: no such file"),
        ({"file": "../exp.csv"}, "beside[0].file: got '../exp.csv'; allowed: the name of a CSV"),
        ({"x": None}, "beside[0].x: got nothing; allowed: "),
        ({"points": [[1, 2]]}, "beside[0].points: got [[1, 2]]; allowed: points, or columns"),
        ({"y": "v"}, "exp.csv: column v: got nothing; allowed: a column v, for the axis y; the"),
        ({"x": "V"}, "exp.csv: unit of column V: got 'mm/s'; allowed: no unit, as it is a pure"),
        ({"yerr": "t"}, "exp.csv: line 3, column t: got '-1'; allowed: an error in [0, 1e+100]"),
        ({"yerr": "e"}, "exp.csv: line 2, column e: got 'x'; allowed: an error in [0, 1e+100]"),
        ({"y": "t"}, "exp.csv: line 3, column t: got '-1'; allowed: numbers >= 1e-100 on the log"),
    ],
)
def test_mistakes_in_files_beside_name_file_line_and_column(parse, tmp_path, change, message):
    (tmp_path / "exp.csv").write_text("mu,V (mm/s),s,t,e\n0.3,250,1,1,x\n0.5,200,1,-1,1\n")
    data = {key: value for key, value in (FILE_BESIDE | change).items() if value is not None}
    with pytest.raises(InputError) as caught:
        parse(VALID_PLOT | {"log": ["y"], "beside": data})
    assert message in str(caught.value) and "\n" not in str(caught.value)


def test_a_law_is_fitted_to_curves_alone(parse):
    assert parse(VALID_PLOT | {"fit": "power"}).plots["v"].fit == "power"
    message = error_message(parse, VALID_PLOT | REGIME_MAP | {"panels": "law", "fit": "power"})
    assert message.startswith("curves: got nothing") or "a key of map" in message
    assert error_message(parse, VALID_PLOT | {"fit": "cubic"}).startswith("fit: got 'cubic'; allow")


def test_plots_draw_on_the_series_they_name_and_on_those_of_their_system(parse):
    more = {"name": "more", "system": "chute", "cases": [{"friction": 0.5}, {"friction": 0.6}]}
    study = parse(
        {"name": "a", "x": "friction", "series": ["more"]},
        {"name": "b", "x": "frequency"} | {"system": "belt"},
        series=(SERIES, more, BEDS),
    )
    assert study.figures == {"a": study.series["more"], "b": study.series["beds"]}


def test_parts_bring_their_plots(parse, tmp_path):
    part = "study: p\nseries: [{name: beds, system: belt, grid: {frequency: [20, 50]}}]\n"
    (tmp_path / "part.yaml").write_text(part + "plots: [{name: w, x: frequency}]\n")
    study = parse(VALID_PLOT | {"system": "chute"}, parts=["part.yaml"])
    assert list(study.plots) == ["v", "w"]
    assert study.figures["w"] == study.series["beds"]
    with pytest.raises(InputError, match="a name that no other plot has"):
        parse(VALID_PLOT | {"name": "w", "system": "chute"}, parts=["part.yaml"])
    with pytest.raises(InputError, match="capitals or not"):
        parse(VALID_PLOT | {"name": "W", "system": "chute"}, parts=["part.yaml"])


@pytest.mark.parametrize("kind", study_kinds())
@pytest.mark.parametrize("system", SYSTEMS)
def test_every_kind_shows_its_usual_observable_of_every_system(parse, kind, system):
    grids = {"chute": {"depth": [1, 2], "friction": [0.4, 0.5]}}
    grids["belt"] = {"frequency": [20, 50], "obstacle": [0, 1]}
    grids["conveyor"] = {"frequency": [20, 50], "friction": [0.2, 0.4]}
    keys = find_kind(kind).keys
    axes = dict(zip(keys.axes, grids[system], strict=False))
    series = {"name": "a", "system": system, "grid": grids[system]}
    spec = parse({"name": "p", "kind": kind} | axes, series=(series,)).plots["p"]
    shown = spec.show
    assert shown in keys.shows(system) or (kind, shown) == ("map", "regime")
    assert spec.title[0].isupper() and spec.lead.endswith(".")


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"name": "walton_2"}, "name: got 'walton_2'; allowed: a name that no figure"),
        ({"name": "a/b"}, "name: got 'a/b'; allowed: up to 60 letters"),
        ({"x": None}, "x: got nothing; allowed: "),
        ({"x": "fricton"}, "x: got 'fricton'; did you mean friction"),
        (
            {"x": "slop"},
            "x: got 'slop'; allowed: a parameter of the chute that the points vary: friction, "
            "friction_plane, law, angle; or an observable: ",
        ),
        ({"x": "frequency"}, "x: got 'frequency'; allowed: a parameter of the chute; this is"),
        ({"x": "law", "panels": "friction"}, "x: got 'law'; allowed: a parameter that is a number"),
        ({"x": "velocity"}, "x: got 'velocity'; allowed: an observable other than y"),
        ({"x": "shear_dept"}, "x: got 'shear_dept'; did you mean shear_depth"),
        ({"x": "backflow"}, "x: got 'backflow'; allowed: an observable of the chute; backflow is"),
        ({"x": "overburden"}, "x: got 'overburden'; allowed: points with stress_profiles: true"),
        ({"x": "depth"}, "x: got 'depth, which is 5 throughout'; allowed: a parameter that the"),
        ({"curves": ["angle", "depth"]}, "curves[1]: got 'depth, which is 5 throughout'"),
        ({"panels": "friction"}, "panels: got 'friction'; allowed: a parameter other than x"),
        ({"y": "velocty"}, "y: got 'velocty'; did you mean velocity"),
        ({"y": "backflow"}, "y: got 'backflow'; allowed: an observable of the chute; backflow is"),
        ({"y": "mass_flux"}, "y: got 'mass_flux'; allowed: an observable of curves; mass_flux is"),
        ({"y": "overburden"}, "y: got 'overburden'; allowed: points with stress_profiles: true"),
        ({"series": ["flow"]}, "series[0]: got 'flow'; did you mean flows? allowed: one of flows"),
        ({"system": "belt"}, "system: got 'belt'; allowed: a system of its series: chute"),
        (
            {"colour": "velocity"},
            "colour: got 'velocity'; allowed: a key of curves: x, y, curves, panels, beside",
        ),
        ({"log": ["colour"]}, "log[0]: got 'colour'; allowed: one of x, y"),
        (REGIME_MAP | {"log": ["colour"]}, "log[0]: got 'colour'; allowed: one of x, y"),
        ({"curves": ["angle", 1]}, "curves[1]: got 1; allowed: a name, or a list of names"),
        ({"kind": "pie"}, "kind: got 'pie'; allowed: "),
        ({"kind": "profiles", "curves": None}, "x: got 'friction'; allowed: "),
        ({"kind": "map", "y": "angle", "curves": None, "panels": None}, "panels: got nothing; "),
        ({"size": 3}, "size: unknown key, got 3; "),
    ],
)
def test_mistakes_are_refused_by_their_key(parse, change, message):
    plot = {key: value for key, value in (VALID_PLOT | change).items() if value is not None}
    assert error_message(parse, plot).startswith(message)


def test_a_study_of_both_systems_asks_for_which(parse):
    message = error_message(parse, VALID_PLOT, series=(SERIES, BEDS))
    assert message.startswith("system: got nothing; allowed: one of chute, belt")


def test_an_axis_with_zero_is_not_logarithmic(parse):
    series = {"name": "a", "system": "chute", "grid": {"friction": [0, 0.4]}}
    message = error_message(parse, {"name": "v", "x": "friction", "log": ["x"]}, series=(series,))
    assert message.startswith("log[0]: got 'x with friction = 0'")


def test_a_kind_of_a_plugin_takes_the_keys_that_it_names(parse, tmp_path):
    path = tmp_path / "own.py"
    path.write_text(
        "import sim\nfrom sim.study.plot_kinds import Keys\n"
        "from sim.study.plottable import numbers\n"
        "keys = Keys(axes=('x',), observable='y', usual='shear_depth', shows=numbers)\n"
        "sim.plot_kind('own', keys=keys)(print)\n"
    )
    series = ({"name": "a", "system": "chute", "grid": {"friction": [0.3, 0.4]}},)
    plot = {"name": "v", "kind": "own", "x": "friction"}
    with restore_plugins():
        load_plugins(path)
        spec = parse(plot, series=series).plots["v"]
        assert spec.title == "Shear depth against friction" and len(spec.plugin) > 6
        message = error_message(parse, plot | {"panels": "law"}, series=series)
        assert message == "panels: got 'law'; allowed: a key of own: x, y"
        message = error_message(parse, plot | {"log": ["x"]}, series=series)
        assert message.startswith("log[0]: got 'x'; allowed: one of")


def test_logarithmic_axes_of_a_kind_of_a_plugin_are_those_that_it_names(parse, tmp_path):
    path = tmp_path / "own.py"
    path.write_text(
        "import sim\nfrom sim.study.plot_kinds import Keys\n"
        "from sim.study.plottable import numbers\n"
        "keys = Keys(axes=('x',), observable='y', shows=numbers, log=('y',))\n"
        "sim.plot_kind('own', keys=keys)(print)\n"
        "sim.plot_kind('alike', like='curves')(print)\n"
    )
    series = ({"name": "a", "system": "chute", "grid": {"friction": [0.3, 0.4]}},)
    plot = {"name": "v", "kind": "own", "x": "friction"}
    with restore_plugins():
        load_plugins(path)
        assert parse(plot | {"log": ["y"]}, series=series).plots["v"].log == ("y",)
        message = error_message(parse, plot | {"log": ["x"]}, series=series)
        assert message == "log[0]: got 'x'; allowed: one of y"
        # Nothing would draw data beside such a plot.
        beside = {"kind": "alike", "beside": [{"label": "data", "points": [[0.3, 1]]}]}
        message = error_message(parse, plot | beside, series=series)
        assert message == "beside: got 'data'; allowed: a key of alike: x, y, curves, panels"


@pytest.mark.parametrize(
    ("role", "why"),
    [
        ("draw", "draw returns a figure of matplotlib: got nothing"),
        ("table", "table returns a pandas.DataFrame: got nothing"),
        ("select", "select returns the data of a figure: got nothing"),
        ("notes", "'NoneType' object is not iterable"),
    ],
)
def test_what_functions_of_a_plugin_return_is_checked(tmp_path, role, why):
    path = tmp_path / "own.py"
    path.write_text(
        "import sim\n"
        "def nothing(data): pass\n"
        "options = {'table': nothing, 'notes': nothing, 'select': nothing}\n"
        "sim.plot_kind('own', like='curves', **options)(nothing)\n"
    )
    with restore_plugins():
        load_plugins(path)
        function = getattr(find_kind("own"), role)
        with pytest.raises(InputError, match=rf"plug-in own.py .*: plot own v: TypeError: {why}"):
            function(SimpleNamespace(spec=SimpleNamespace(name="v")))


def test_points_that_would_lie_on_each_other_are_refused(parse):
    series = {"name": "a", "system": "chute", "grid": {"friction": [0.3, 0.4], "cell": [5, 10]}}
    with pytest.raises(InputError, match=r"plots\[0\]: got v with two points at friction = 0.3 "):
        parse({"name": "v", "x": "friction"}, series=(series,))


def test_panels_are_few(parse):
    grid = {"friction": [0.3 + 0.01 * step for step in range(13)], "depth": [1, 2]}
    series = {"name": "a", "system": "chute", "grid": grid}
    message = error_message(
        parse, {"name": "v", "x": "depth", "panels": "friction"}, series=(series,)
    )
    assert message.startswith("panels: got 'friction with 13 values'; allowed: a parameter of at")


SCATTER = {"name": "s", "kind": "scatter", "x": "friction"}
SEVERAL = {"name": "s", "kind": "main_effects"}


def test_the_colour_of_a_scatter_is_a_parameter_an_observable_or_the_regime(parse):
    for colour, said in {
        "angle": "colour: angle θ.",
        "shear_depth": "colour: shear depth.",
        "regime": "colour: regime.",
    }.items():
        spec = parse(SCATTER | {"colour": colour}).entries["s"]
        assert spec.colour == colour and spec.lead.endswith(said)
        assert spec.title == f"Velocity against friction, by {colour.replace('_', ' ')}"
    assert parse(SCATTER | {"x": "shear_depth"}).entries["s"].axes == ()


def test_parameters_are_all_that_vary_unless_they_are_named(parse):
    spec = parse(SEVERAL).entries["s"]
    assert set(spec.axes) == {"friction", "angle", "law"}
    spec = parse(SEVERAL | {"parameters": "angle"}).entries["s"]
    assert spec.axes == ("angle",) and spec.title == "Velocity against angle"


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"colour": "anglee"}, "colour: got 'anglee'; did you mean angle"),
        ({"colour": "depth"}, "colour: got 'depth, which is 5 throughout'; allowed: a param"),
        ({"colour": "friction"}, "colour: got 'friction'; allowed: a parameter other than x"),
        ({"colour": "backflow"}, "colour: got 'backflow'; allowed: an observable of the chute"),
        ({"colour": "law", "log": ["colour"]}, "log[0]: got 'colour'; allowed: no log, as law"),
        ({"colour": "regime", "log": ["colour"]}, "log[0]: got 'colour'; allowed: one of x, y"),
        ({"parameters": ["friction"]}, "parameters: got ['friction']; allowed: a key of scatter"),
        (SEVERAL | {"x": None, "parameters": ["fricton"]}, "parameters[0]: got 'fricton'; did "),
        (SEVERAL | {"x": None, "parameters": []}, "parameters: got []; allowed: a name, or a"),
    ],
)
def test_mistakes_in_plots_of_designs_are_refused_by_their_key(parse, change, message):
    plot = {key: value for key, value in (SCATTER | change).items() if value is not None}
    assert error_message(parse, plot).startswith(message)


@pytest.mark.parametrize("kind", ["pairs", "parallel"])
def test_a_plot_that_the_explorer_draws_is_refused_with_its_name(parse, kind):
    message = error_message(parse, SEVERAL | {"kind": kind})
    assert message.startswith(f"kind: got '{kind}'") and "explorer" in message


def test_main_effects_have_few_parameters(parse):
    names = SYSTEMS["chute"].model_fields
    parameters = [name for name, field in names.items() if field.annotation is float][:13]
    message = error_message(parse, SEVERAL | {"parameters": parameters})
    assert message.startswith("parameters")


def test_curves_of_a_design_are_told_from_curves_of_a_grid(parse):
    cases = [{"friction": 0.3 + n / 50, "angle": 16 + n / 10} for n in range(9)]
    series = {"name": "a", "system": "chute", "cases": cases}
    assert parse({"name": "v", "x": "friction"}, series=(series,)).entries["v"].scattered
    assert not parse(VALID_PLOT).entries["v"].scattered
