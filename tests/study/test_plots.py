"""Plots of a study file: entries like those of the catalogue, and refused plots."""

from types import SimpleNamespace

import pytest

from sim.base.errors import InputError
from sim.base.plugins import load_plugins
from sim.figures.render import drawing_of
from sim.parameters import SYSTEMS
from sim.study.load import Study, parse_study
from sim.study.plottable import kinds, study_kinds
from tests.made.processes import restore_plugins

SERIES = {
    "name": "flows",
    "system": "chute",
    "grid": {"friction": [0.3, 0.4], "angle": [16, 17], "law": ["walton_braun", "spring_dashpot"]},
}
BEDS = {"name": "beds", "system": "belt", "grid": {"frequency": [20, 50]}}
#: A valid plot.
VALID_PLOT = {"name": "v", "x": "friction", "curves": "angle", "panels": "law"}


@pytest.fixture
def parse(tmp_path):
    def parse(*plots: dict, series: tuple[dict, ...] = (SERIES,), **others) -> Study:
        mapping = {"study": "s", "series": list(series), "plots": list(plots)} | others
        return parse_study(mapping, tmp_path / "study.yaml", tmp_path / "results")

    return parse


def test_a_plot_is_an_entry_of_all_points_of_its_series(parse):
    study = parse(VALID_PLOT)
    spec = study.entries["v"]
    assert (spec.kind, spec.system, spec.axes) == ("curves", "chute", ("friction",))
    assert spec.title == "Velocity against friction, by angle and law"
    assert spec.lead.startswith("Velocity: mean velocity over the averaging window, against")
    assert study.figures["v"] == tuple(study.points)
    assert all(point.figures == () for point in study.points.values())

    # x of curves may be an observable, and y of profiles another profile.
    spec = parse(VALID_PLOT | {"x": "shear_depth"}).entries["v"]
    assert spec.axes == () and spec.groups == ("angle", "law")
    assert (spec.show, spec.second) == ("velocity", "shear_depth")
    assert spec.title == "Velocity against shear depth, by angle and law"
    assert ", against shear depth (height at which the velocity is" in spec.lead
    assert "friction" in spec.named
    plot = {"name": "p", "kind": "profiles", "x": "granular_temperature", "y": "packing"}
    spec = parse(plot | {"between": [1, 4], "log": ["y"]}).entries["p"]
    assert (spec.show, spec.second) == ("granular_temperature", "packing")
    assert spec.between == [1.0, 4.0]
    assert spec.title == "Packing against granular temperature"
    assert spec.lead.startswith("Packing: packing fraction, against granular temperature (granular")


DATA_BESIDE = {"label": "Pouliquen (1999)", "points": [[0.3, 1], [0.6, 2.5]]}
FILE_BESIDE = {"file": "exp.csv", "x": "mu", "y": "V", "yerr": "s"}


def test_data_beside_are_points_or_columns_of_a_file_which_belongs_to_the_study(parse, tmp_path):
    beside = [DATA_BESIDE, DATA_BESIDE | {"label": "law", "line": True}]
    points = ((0.3, 1.0), (0.6, 2.5))
    foreign = parse(VALID_PLOT | {"beside": beside}).entries["v"].foreign
    assert foreign == (("Pouliquen (1999)", points, False), ("law", points, True))
    (tmp_path / "exp.csv").write_text("mu,V (mm/s),s (mm/s)\n0.3,250,0\n0.5,200,4\n")
    study = parse(VALID_PLOT | {"beside": FILE_BESIDE})
    assert study.plots["v"].foreign == (("exp", ((0.3, 0.25, 0.0), (0.5, 0.2, 0.004)), False),)
    assert study.data == (tmp_path / "exp.csv",) and study.data[0] in study.sources
    one = FILE_BESIDE | {"label": "glass", "line": True}
    assert parse(VALID_PLOT | {"beside": [one]}).plots["v"].foreign[0][::2] == ("glass", True)


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
    keys = kinds()[kind].keys
    axes = dict(zip(keys.axes, grids[system], strict=False))
    series = {"name": "a", "system": system, "grid": grids[system]}
    spec = parse({"name": "p", "kind": kind} | axes, series=(series,)).plots["p"]
    shown = spec.show
    assert shown in keys.shows(system) or (kind, shown) == ("map", "regime")
    assert spec.title[0].isupper() and spec.lead.endswith(".")


OWN = """
import sim
from sim.study.plottable import Keys, numbers

keys = Keys(axes=("x",), observable="y", usual="shear_depth", shows=numbers, log=("y",))
sim.plot_kind("own", keys=keys)(print)
sim.plot_kind("alike", like="curves")(print)
sim.plot_kind("mute", like="curves", notes=print, table=print, select=print)(print)
"""


@pytest.fixture
def own(tmp_path):
    """Load a plug-in with kinds of plots."""
    path = tmp_path / "own.py"
    path.write_text(OWN)
    with restore_plugins():
        load_plugins(path)
        yield


def test_a_kind_of_a_plugin_takes_the_keys_that_it_names(parse, own):
    plot = {"name": "v", "kind": "own", "x": "friction"}
    others = {"series": ({"name": "a", "system": "chute", "grid": {"friction": [0.3, 0.4]}},)}
    spec = parse(plot | {"log": ["y"]}, **others).plots["v"]
    assert spec.title == "Shear depth against friction" and len(spec.plugin) > 6
    assert spec.log == ["y"]


@pytest.mark.parametrize(
    ("role", "why"),
    [
        ("draw", "draw returns a figure of matplotlib: got nothing"),
        ("table", "table returns a pandas.DataFrame: got nothing"),
        ("select", "select returns the data of a figure: got nothing"),
        ("notes", "'NoneType' object is not iterable"),
    ],
)
def test_what_functions_of_a_plugin_return_is_checked(own, role, why, capsys):
    function = getattr(drawing_of("mute"), role)
    with pytest.raises(InputError, match=rf"plug-in own.py .*: plot mute v: TypeError: {why}"):
        function(SimpleNamespace(spec=SimpleNamespace(name="v")))


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


def test_curves_of_a_design_are_told_from_curves_of_a_grid(parse):
    cases = [{"friction": 0.3 + n / 50, "angle": 16 + n / 10} for n in range(9)]
    series = {"name": "a", "system": "chute", "cases": cases}
    assert parse({"name": "v", "x": "friction"}, series=(series,)).entries["v"].scattered
    assert not parse(VALID_PLOT).entries["v"].scattered
