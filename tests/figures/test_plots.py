"""Plots of a study's own: every kind, from made-up points to picture, data and caption."""

from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd
import pytest

from sim.base.errors import InputError
from sim.base.statistics import student_half_width
from sim.dataset.build import build
from sim.dataset.replicates import mean_interval
from sim.dataset.results import load_results
from sim.figures.caption import scale_of, unit_of
from sim.figures.data import split_curves
from sim.figures.render import render
from sim.parameters import point_id
from sim.study.load import load_study
from tests.figures.drawing import derive_texts, notes
from tests.figures.made_plots import GRID, SIZE, SPEED, drawn, flows
from tests.made.results import MadePoint, made_point
from tests.made.runs import write_run


def labels(axes) -> list[str]:
    return [text.get_text() for text in axes.get_xticklabels()]


def test_curves_name_what_varies_and_every_value_has_a_tick():
    figure, rows, _ = drawn({"x": "friction", "curves": "angle"})
    (axes,) = figure.axes
    assert [text.get_text() for text in figure.legends[0].texts] == ["θ = 16°", "θ = 17°"]
    assert list(axes.xaxis.get_minor_locator()()) == [0.3, 0.4, 0.6]
    assert axes.get_ylabel() == "velocity\N{NO-BREAK SPACE}(m/s)"
    assert rows["mean velocity over the averaging window [m/s]"].tolist()[0] == pytest.approx(0.7)
    assert len(rows) == 6


def flows_of_depths(x: Mapping[float, Sequence[float]], angles=(16, 17)) -> list[MadePoint]:
    """Return flows of some shear depths (diameters), one per replicate, by their frictions."""
    return [
        made_point(
            "chute",
            {"velocity": friction, "shear_depth": np.asarray(depths) * SIZE},
            replicates=len(depths),
            friction=friction,
            angle=angle,
        )
        for friction, depths in x.items()
        for angle in angles
    ]


def lines(axes) -> list[np.ndarray]:
    """Return the x values of the curves of a plot."""
    return [line.get_xdata() for line in axes.lines if line.get_linestyle() not in ("None", "none")]


def test_curves_against_a_number_are_joined_in_its_order_with_bars_both_ways():
    points = flows_of_depths({0.3: (3, 3.3, 3.6), 0.4: (1, 1.1, 1.2), 0.6: (2, 2, 2.3)})
    plot = {"x": "shear_depth", "curves": "angle", "units": "natural"}
    figure, rows, _ = drawn(plot, points)
    (axes,) = figure.axes
    assert axes.get_xlabel() == "shear depth/σ"
    assert [line.tolist() for line in lines(axes)[:1]] == [pytest.approx([1.1, 2.1, 3.3])]
    ends = [part.get_segments() for bars in axes.containers for part in bars.lines[2]]
    wide = [segment for each in ends for segment in each if segment[0][0] < segment[1][0]]
    high = [segment for each in ends for segment in each if segment[0][1] < segment[1][1]]
    assert len(wide) == len(high) == 6
    assert rows.filter(regex=r"^height .*\[σ\]").iloc[0, 0] == pytest.approx(3.3)
    half = rows.filter(regex=r"^half width .* height .*\[σ\]").iloc[0, 0]
    assert half == pytest.approx(student_half_width(np.array([3, 3.3, 3.6])))
    assert rows.filter(like="mean velocity").shape[1] == 2


def test_a_cloud_of_points_is_not_joined_and_choices_tell_curves_apart():
    points = flows_of_depths({0.3: (3,), 0.4: (1,), 0.6: (2,)})
    figure, _, data = drawn({"x": "shear_depth"}, points)
    (axes,) = figure.axes
    assert not lines(axes) and not figure.legends
    assert sum(len(line.get_xdata()) for line in axes.lines if line.get_zorder() == 3) == 6
    # Of one replicate the velocity alone has bars, which are upright.
    assert bars_of(axes) == [6]
    text = notes(data)
    assert "Points that differ in friction μ and angle θ are not joined." in text


def test_a_sweep_has_a_curve_up_and_one_down():
    points: list = []
    for angle in (16, 18, 20, 18, 16):
        start = point_id(points[-1].parameters) if points else ""
        points.append(made_point("chute", {"velocity": angle}, angle=angle, start_from=start))
    other = made_point("chute", {"velocity": 1.0}, angle=17, start_from=start)
    plot = {"x": "angle", "curves": "start_from"}
    figure, _, data = drawn(plot, [*points, other])
    assert list(data.rows["start_from"]) == ["flows up"] * 3 + ["flows down"] * 3
    legend = {text.get_text() for text in figure.legends[0].get_texts()}
    assert {"start from: flows up", "start from: flows down"} <= legend
    _, _, data = drawn(plot, points[:3])
    assert set(data.rows["start_from"]) == {"flows"}
    # Without that key they would lie on each other.
    with pytest.raises(InputError, match=r"two points at .* that differ in start_from"):
        drawn({"x": "angle"}, points)


def test_panels_fill_their_rows_evenly():
    points = [
        made_point("chute", {"velocity": 1.0}, friction=friction, angle=15 + angle)
        for friction in (0.3, 0.4)
        for angle in range(5)
    ]
    figure, _, _ = drawn({"x": "friction", "panels": "angle"}, points)
    assert figure.axes[0].get_gridspec().get_geometry() == (2, 3)


def test_natural_units_divide_by_what_diameter_gravity_and_mass_make():
    _, rows, data = drawn({"x": "friction", "curves": "angle", "units": "natural"})
    first = rows["mean velocity over the averaging window [√(gσ)]"].iloc[0]
    assert first == pytest.approx(data.rows["velocity"].iloc[0] / SPEED)
    plot = {"x": "friction", "curves": "angle", "y": "shear_depth", "units": "natural"}
    _, rows, _ = drawn(plot)
    assert rows.filter(like="[σ]").iloc[0, 0] == pytest.approx(2)
    assert unit_of("W", "natural", "belt") == "mg√(g⟨d⟩)"
    point = pd.DataFrame([{"diameter": 2.0, "gravity": 8.0, "mass": 3.0}])
    assert scale_of("W", "natural", point).item() == pytest.approx(3 * 8 * 4)
    assert scale_of("W", "si", point).item() == 1


def test_profiles_end_above_the_last_particles():
    figure, rows, _ = drawn(
        {"kind": "profiles", "curves": "friction", "panels": "angle", "units": "natural"}
    )
    assert len(figure.axes) == 2
    assert rows["height [σ]"].max() == pytest.approx(4.875)
    heights, speeds = rows["height [σ]"], rows["velocity [√(gσ)]"] * SPEED
    assert speeds.tolist() == pytest.approx(heights.tolist(), rel=1e-6)
    assert list(rows["friction [1]"].unique()) == GRID["friction"]


def sliced(replicates: int, lone: int = 0) -> list[MadePoint]:
    """Return a flow whose packing is a tenth of its granular temperature, which falls upwards.

    Above 3 diameters only the first ``lone`` replicates know the temperature.
    """
    height = (np.arange(20) + 0.5) * 0.25 * SIZE
    factors = 1 + 0.1 * np.arange(replicates)[:, None]
    cold = factors * (5 - height / SIZE)
    hot = np.where(height < 4.5 * SIZE, cold, 0.5)
    unknown = (np.arange(replicates)[:, None] >= lone) & (height > 3 * SIZE)
    profiles = {
        "packing_profile": cold / 10,
        "granular_temperature_profile": np.where(unknown, np.nan, hot),
    }
    options = {"replicates": replicates, "height": height, "angle": 16}
    return [
        made_point("chute", {"velocity": 0.5}, profiles, friction=friction, **options)
        for friction in (0.3, 0.4)
    ]


SLICES = {"kind": "profiles", "x": "granular_temperature", "y": "packing", "curves": "friction"}


def bars_of(axes) -> list[int]:
    """Return the number of bars of each collection of them."""
    parts = [part.get_segments() for bars in axes.containers for part in bars.lines[2]]
    return [sum(len(one) > 0 for one in segments) for segments in parts]


def test_profiles_against_each_other_have_a_marker_with_bars_in_every_slice():
    figure, rows, data = drawn(SLICES, sliced(3, lone=1))
    (axes,) = figure.axes
    assert axes.get_xlabel().startswith("granular temperature") and axes.get_ylabel() == "packing"
    assert [text.get_text() for text in figure.legends[0].texts] == ["μ = 0.3", "μ = 0.4"]
    # Above 3 diameters one replicate alone knows both, and there is no bar.
    assert [len(bars.lines[0].get_xdata()) for bars in axes.containers] == [19, 19]
    assert bars_of(axes) == [12] * 4
    heat, packing = (rows.filter(regex=f"^{name} ").iloc[:, 0] for name in ("gran.*", "packing"))
    low = heat > 0.6
    assert packing[low].tolist() == pytest.approx((heat / 10)[low].tolist())
    assert heat.iloc[0] == pytest.approx(1.1 * 4.875) and heat.iloc[12] == pytest.approx(1.875)
    half = rows.filter(regex="^half width .* packing").iloc[0, 0]
    assert half == pytest.approx(student_half_width(np.array([1, 1.1, 1.2]) * 4.875 / 10))
    assert "95 % intervals" in notes(data)


def test_profiles_against_each_other_leave_out_slices_that_are_not_known_or_not_between():
    figure, rows, data = drawn(SLICES | {"between": [1, 4], "units": "natural"}, sliced(2))
    assert rows["height [σ]"].min() == 1.125 and rows["height [σ]"].max() == 2.875
    (axes,) = figure.axes
    assert bars_of(axes) == [0] * 4, "of two replicates"
    text = notes(data)
    assert "Heights shown: 1 to 4 diameters above the base." in text
    assert "(Student) where there are 3 or more." in text


def test_a_distribution_has_a_dot_for_every_replicate():
    plot = {"kind": "distribution", "x": "friction", "curves": "angle"}
    figure, rows, _ = drawn(plot, flows(replicates=7))
    assert len(rows) == 42
    dots = [line for line in figure.axes[0].lines if line.get_linestyle() == "None"]
    assert [len(line.get_xdata()) for line in dots] == [7] * 6
    assert labels(figure.axes[0]) == ["0.3", "0.4", "0.6"]


def test_what_no_run_knows_is_said():
    figure, rows, _ = drawn({"x": "friction", "curves": "angle", "y": "base_rolling"})
    assert "no run has base rolling" in [text.get_text() for text in figure.axes[0].texts]
    assert len(rows) == 6


def test_time_series_are_read_from_run_files(tmp_path):
    path = tmp_path / "own.yaml"
    path.write_text(
        "study: own\nseries: [{name: flows, system: chute, base: {replicates: 2},\n"
        "  grid: {friction: [0.3, 0.4]}}]\n"
        "plots: [{name: courses, kind: time_series, curves: friction, units: natural}]\n"
    )
    study = load_study(path, tmp_path)
    for point in study.points.values():
        write_run(tmp_path / "own" / "runs", point.parameters, velocity=[0.4, 0.5])
    dataset = build(path, tmp_path)
    spec = study.plots["courses"]
    files = render(spec, dataset, tmp_path / "figures")
    assert [path.suffix for path in files] == [".png", ".svg", ".csv", ".txt"]
    rows = pd.read_csv(files[2])
    assert set(rows["replicate"]) == {0, 1} and len(rows) == 2 * 2 * 400
    first = rows[(rows["replicate"] == 0) & (rows["point"] == rows["point"].iloc[0])]
    assert first["velocity [√(gσ)]"].mean() == pytest.approx(0.4 / SPEED, rel=1e-2)
    assert files[3].read_text().startswith("Velocity: mean velocity down the slope, weighted by")
    (dataset.parent / "runs" / f"{next(iter(study.points))}.nc").unlink()
    with pytest.raises(InputError, match="no such run file"):
        derive_texts(spec, load_results(dataset))


# Logarithmic axes: what has no place there is not drawn, and the caption counts it.


DEPTHS = {"x": "friction", "y": "shear_depth"}


@pytest.mark.parametrize(
    ("plot", "said"),
    [
        (DEPTHS | {"log": ["y"]}, "Not drawn, not above 0 on a logarithmic axis: 1."),
        (DEPTHS, ""),
        (
            {"kind": "distribution", "x": "friction", "log": ["y"]},
            "replicates not above 0 on a logarithmic axis: 3.",
        ),
        (
            {"kind": "profiles", "curves": "friction", "log": ["x"]},
            "slices not above 0 on a logarithmic axis: 16.",
        ),
    ],
)
def test_what_is_not_above_zero_has_no_place_on_a_logarithmic_axis(plot, said):
    profiles = {
        "packing_profile": lambda height: np.where(height < 5 * SIZE, 0.6, 0.0),
        "velocity_profile": lambda height: np.where(height < 2 * SIZE, -1.0, 1.0),
    }
    points = [
        made_point(
            "chute", {"velocity": values, "shear_depth": values}, profiles, friction=friction
        )
        for friction, values in ((0.3, [1.0, -1.0, 2.0]), (0.4, [1.0, 0.0, -1.0]))
    ]
    _, rows, data = drawn(plot, points)
    assert said in notes(data) and len(rows) >= len(points)
    assert said or "logarithmic" not in notes(data)


@pytest.mark.parametrize(("powers", "are_alone"), [(2, False), (5, True)])
def test_ticks_of_many_powers_are_powers_alone(powers, are_alone):
    """Others would touch each other in small panels."""
    points = [
        made_point("chute", {"velocity": 10.0**-power}, friction=0.3 + power / 10)
        for power in range(powers)
    ]
    figure, _, _ = drawn({"x": "friction", "log": ["y"]}, points)
    digits = {f"{tick:e}"[0] for tick in figure.axes[0].get_yticks()}
    assert (digits == {"1"}) is are_alone


@pytest.mark.parametrize(
    ("values", "errors", "half_width", "kind"),
    [
        # Tabulated quantile of Student's t with two degrees of freedom at 0.975: 4.30265.
        ([1.0, 2.0, 3.0], [0.9] * 3, 4.30265 / np.sqrt(3), "replicates"),
        # Replicates that agree by accident keep their own intervals.
        ([1.0] * 4, [0.6] * 4, 0.3, "replicates"),
        ([1.0], [0.5], 0.5, "within run"),
        ([], [], np.nan, "none"),
        ([1.0], [np.nan], np.nan, "none"),
    ],
)
def test_an_interval_is_students_or_that_within_a_run(values, errors, half_width, kind):
    found = mean_interval(np.array(values), np.array(errors))
    assert found == (pytest.approx(half_width, rel=1e-5, nan_ok=True), kind)


@pytest.mark.parametrize(
    ("columns", "keys", "expected"),
    [
        (
            {"depth": [50, 20, 20, 50], "a": [1, 1, 2, 2], "friction_plane": [0] * 4},
            ["a"],
            [{"a": 1}, {"a": 2}],
        ),
        # Run lengths, and a plane like the particles, split nothing.
        (
            {
                "depth": [5, 20, 5],
                "friction": [0.4, 0.4, 0.5],
                "friction_plane": [0.4, 0.4, 0.5],
                "cell": [10, 5, 10],
                "transient": [300, 900, 300],
            },
            ["friction"],
            [{"friction": 0.4}, {"friction": 0.5}],
        ),
        (
            {"depth": [5, 5], "friction": [0.4, 0.4], "friction_plane": [0.4, 0.6]},
            ["friction"],
            [{"friction": 0.4, "friction_plane": plane} for plane in (0.4, 0.6)],
        ),
    ],
)
def test_curves_are_split_by_keys_and_what_varies_and_sorted_along_the_axis(
    columns, keys, expected
):
    curves = split_curves(pd.DataFrame(columns), "depth", keys, tuple(columns))
    assert [names for names, _ in curves] == expected
    assert all(curve["depth"].is_monotonic_increasing for _, curve in curves)
