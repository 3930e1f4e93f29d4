"""Figures of papers: their styles, curves, profiles, regimes and boundaries, data and captions."""

from dataclasses import replace
from math import atan, degrees, pi, radians, sqrt, tan
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from matplotlib.collections import FillBetweenPolyCollection
from matplotlib.colors import to_rgb
from scipy.stats import t

from sim.dataset.results import load_results
from sim.figures.curves import _replicates_apart, quantities_by_axis
from sim.figures.family import MOST_BARS, Y_HALF, X, Y, _with_gaps
from sim.figures.plot import completed_rows
from sim.figures.profiles import THIN, means
from sim.figures.regimes import MARKS, boundary_sentences, creeping
from sim.figures.style import DASH_DOT, DOTTED, LONG_DASH, RING_MEANS, SHORT_DASH
from sim.parameters import BeltParameters
from sim.study.load import load_study
from tests.figures import drawing
from tests.figures.drawing import dashes, data_of_figure, drawn, picture, table, texts
from tests.figures.made_papers import SPREAD, overlap, plateau, transport
from tests.made.figures import make_built_regimes, make_built_study
from tests.made.netcdf import ROUNDING, store
from tests.made.runs import FAILURE, is_hurt, is_lost

#: Legend entries and dashes of papers, by their figures.
STYLES = {
    "gallas_1a": {"α = 60°": DASH_DOT, "α = 45°": "-", "α = 30°": SHORT_DASH},
    "gallas_1b": {"$A_z$/⟨d⟩ = 1.5": DASH_DOT, "$A_z$/⟨d⟩ = 1": "-", "$A_z$/⟨d⟩ = 0.5": SHORT_DASH},
    "gallas_1c": {"f = 50 Hz": "-", "f = 20 Hz": LONG_DASH},
    "gallas_2a": {
        **{"f = 10 Hz": "-", "f = 20 Hz": LONG_DASH, "f = 60 Hz": DASH_DOT, "f = 80 Hz": DOTTED}
    },
    "gallas_3c": {
        "(γ, γ$_s$) = (10g, 10g)": SHORT_DASH,
        "(γ, γ$_s$) = (0, 50g)": DASH_DOT,
        "(γ, γ$_s$) = (50g, 100g)": "-",
        "(γ, γ$_s$) = (10g, 10g), fast start": LONG_DASH,
    },
}


@pytest.fixture(scope="module")
def made(tmp_path_factory) -> tuple[Path, Path]:
    return make_built_study(tmp_path_factory.mktemp("made"))


@pytest.fixture(scope="module")
def velocities(made) -> Path:
    return made[1] / "made" / "dataset.nc"


def legend(axes) -> dict[str, object]:
    return {line.get_label(): dashes(line) for line in axes.get_lines() if "=" in line.get_label()}


def entries(figure) -> list[str]:
    return [text.get_text() for text in figure.legends[0].get_texts()]


def curve(axes, colour: str, dash: object = "-") -> dict[float, float]:
    """Return the data of the line of a colour and a dash pattern."""
    (line,) = (
        line
        for line in axes.get_lines()
        if line.get_linestyle() != "None" and len(line.get_xdata()) > 2
        if line.get_color() == colour and dashes(line) == dash and line.get_linewidth() > 1
    )
    return dict(zip(line.get_xdata(), line.get_ydata(), strict=True))


@pytest.mark.parametrize("name", STYLES)
def test_lines_have_the_dashes_of_the_paper(name, velocities, made_dataset):
    figure, _ = drawn(name, velocities if name.startswith("gallas_1") else made_dataset)
    found = legend(figure.axes[0])
    assert {label: found[label] for label in STYLES[name]} == STYLES[name]


# Curves.


def test_points_that_are_not_steady_have_open_markers(velocities):
    figure, data = drawn("gallas_1a", velocities)
    markers = [line for line in figure.axes[0].get_lines() if line.get_zorder() == 3]
    open_ones = [line for line in markers if line.get_markerfacecolor() == "white"]
    count = [sum(len(line.get_xdata()) for line in each) for each in (open_ones, markers)]
    assert count == [3, 12]
    rows = data.rows
    assert list(rows[rows["regime"] == "arrested"]["frequency"]) == [10, 10, 10]


@pytest.mark.parametrize(
    ("regime", "slope", "velocity"),
    [("accelerating", 2.0, (0.5, 0.5)), ("steady", 0.0, (0.2, 2.0))],
)
def test_flows_that_accelerate_or_disagree_are_not_joined_and_these_are_drawn_one_by_one(
    regime, slope, velocity, velocities, tmp_path
):
    with xr.open_dataset(velocities) as opened:
        dataset = opened.load()
    series = (dataset["depth"] == 5) & (dataset["restitution"] == 0.85)
    point = np.flatnonzero(series & (dataset["friction"] == 0.4))[0]
    for name, value in {"regime": regime, "velocity": velocity, "acceleration": slope}.items():
        dataset[name].values[point, :2] = value
    store(dataset, tmp_path / "dataset.nc")
    figure, _ = drawn("walton_2", tmp_path / "dataset.nc")
    joined = {
        line.get_color(): np.isfinite(line.get_ydata()[list(line.get_xdata()).index(5)])
        for line in figure.axes[0].get_lines()
        if line.get_linestyle() != "None" and 5 in line.get_xdata()[1:]
    }
    assert joined == {"#000000": True, "#0072b2": False, "#d55e00": True}
    lines = [line for line in figure.axes[0].get_lines() if line.get_markersize() < 4]
    apart = [value for line in lines for value in line.get_ydata() if len(line.get_xdata())]
    assert apart == ([] if regime == "accelerating" else list(velocity))
    assert ("single replicates" in entries(figure)) == bool(apart)


@pytest.mark.parametrize("relative", [False, True])
def test_replicates_are_drawn_in_the_unit_of_their_mean(relative, velocities):
    _, data = drawn("gallas_1a", velocities)
    data = replace(data, spec=data.spec.model_copy(update={"widest": 1e-12, "relative": relative}))
    one = quantities_by_axis(data)["y"]
    apart = _replicates_apart(data, one, None).dropna()
    assert len(apart)
    for row, values in apart.items():
        assert values.mean() == pytest.approx(one.value[row])


def test_a_pale_line_breaks_where_the_other_protocol_lies_off_it():
    line = pd.Series([1.0, 2.0, 3.0], [10.0, 20.0, 30.0])
    beside = pd.DataFrame({X: [10, 15, 25, 30], Y: [9, 1.6, 2.7, 9], Y_HALF: [0.1, 0.11, 0.1, 0.1]})
    path = _with_gaps(line, beside)
    assert list(path.index) == [10, 20, 25, 30] and list(path.isna()) == [0, 0, 1, 0]


def test_a_thin_line_joins_open_points_where_a_figure_says_so(velocities):
    for name in ("walton_2", "gallas_1a"):
        figure, _ = drawn(name, velocities)
        thin = [line for line in figure.axes[0].get_lines() if line.get_alpha() == 0.6]
        assert bool(thin) == (name == "gallas_1a")


def test_captions_say_what_is_missing_and_what_the_bars_are(velocities, made):
    _, caption = texts("walton_2", velocities)
    points = load_study(*made).points.values()
    (lost,) = (point.id for point in points if is_lost(point.parameters))
    (hurt,) = (point.id for point in points if is_hurt(point.parameters))
    assert f"Left out because the run failed: {lost} ({FAILURE})" in caption
    assert f"{hurt} (1 of 2 replicates left: {FAILURE})" in caption
    assert "of one replicate within the run" in caption
    assert "accelerating 2" in caption and "failed 1" in caption and "θ = 17°" in caption
    assert "open ones" not in texts("gallas_1c", velocities)[1]


def test_protocols_stand_side_by_side_on_one_scale(made_dataset):
    figure, data = drawn("protocols_1c", made_dataset)
    left, right = figure.axes
    titles = ["published protocol", "converged protocol"]
    assert [axes.get_title() for axes in (left, right)] == titles
    assert left.get_ylim() == right.get_ylim() and len(data.rows) == 12
    for axes in (left, right):
        assert legend(axes) == {"f = 50 Hz": "-", "f = 20 Hz": LONG_DASH}
        assert list(curve(axes, "#000000")) == [0, 10, 50]
    assert sorted(entries(figure)) == ["f = 20 Hz", "f = 50 Hz", "may be steady (short run)"]
    assert figure.legends[0].get_title().get_text() == "frequency f"
    assert "Converged protocol (6 points)" in texts("protocols_1c", made_dataset)[1]


def test_overlaps_are_a_line_and_a_dashed_one_per_stiffness(made_dataset):
    figure, data = drawn("overlaps", made_dataset)
    (axes,) = figure.axes
    assert axes.get_yscale() == "log"
    for dash, times in ((LONG_DASH, 1), ("-", 10)):
        found = curve(axes, "#000000", dash)
        made = [times * overlap({"depth": depth, "stiffness": 100}) for depth in found]
        assert list(found) == [1.24, 2.5, 5, 10, 20, 40]
        assert list(found.values()) == pytest.approx(made)
    assert set(legend(axes)) == {f"K1 = {stiffness} N/m" for stiffness in (100, 1000)}
    assert {"99.9th percentile", "median", "the paper: 0.5 and 5 %"} < set(entries(figure))
    heading = "half width of 95 % interval of the median overlap [σ]"
    columns = set(table(data))
    assert {"median overlap [σ]", heading, "overlap that one of a thousand exceeds [σ]"} < columns


def test_onset_is_drawn_against_the_acceleration_and_relative_to_the_belt(made_dataset):
    figure, data = drawn("onset_acceleration", made_dataset)
    (axes,) = figure.axes
    rows = data.rows
    assert set(rows["frequency"]) == {15, 20}, "80 Hz is far from the onset"
    rate, vertical = 2 * np.pi * rows["frequency"], rows["amplitude"] * rows["diameter"]
    assert rows["acceleration_ratio"].to_numpy() == pytest.approx(rate**2 * vertical / 10)
    speed = [transport(each) for each in rows.itertuples()]
    relative = quantities_by_axis(data)["y"].value.to_numpy()
    assert relative == pytest.approx((speed / (rate * vertical)).to_numpy())
    heights = [y for line in axes.get_lines() if len(line.get_xdata()) for y in line.get_ydata()]
    assert set(relative) <= set(heights)
    named = [label for label in legend(axes) if "α" in label]
    assert set(named) == {"$A_z$/⟨d⟩ = 0.5, α = 45°", "$A_z$/⟨d⟩ = 1, α = 45°"}


def test_a_crowded_line_has_a_band_and_lines_join_no_open_marker(made_dataset):
    data = data_of_figure("gallas_6", made_dataset)
    row = data.rows[data.rows["frequency"] == 80].iloc[[0]]
    number = MOST_BARS + 2
    many = pd.concat([row] * number, ignore_index=True)
    many = many.assign(obstacle=np.arange(number) / 10, velocity=0.1, half_width=0.01)
    many.loc[3, "regime"] = "accelerating"
    axes = picture(replace(data, rows=many)).axes[0]
    (band,) = (one for one in axes.collections if isinstance(one, FillBetweenPolyCollection))
    assert len(band.get_paths()) == 2, "interrupted where the line is"
    assert [x for x, y in curve(axes, "#000000").items() if np.isnan(y)] == [0.3]
    (bars,) = (part.get_segments() for each in axes.containers for part in each.lines[2])
    assert sum(len(one) > 0 for one in bars) == 1, "of the open marker alone"


# Profiles of the belt.


def test_a_ring_marks_what_one_replicate_tells_where_others_have_bars(made_dataset):
    data = data_of_figure("gallas_6", made_dataset)
    rows = data.rows.assign(half_width=data.rows["half_width"].where(np.arange(len(data.rows)) > 0))
    axes = picture(replace(data, rows=rows)).axes[0]
    (ring,) = (line for line in axes.get_lines() if line.get_label() == RING_MEANS)
    assert ring.get_ydata() == rows["velocity"].iloc[:1].to_list()
    assert all(line.get_label() != RING_MEANS for line in picture(data).axes[0].get_lines())


def profiles(data) -> pd.DataFrame:
    """Return the slices of all points."""
    return pd.concat([means(data, row).assign(point=row["point"]) for row in completed_rows(data)])


@pytest.mark.parametrize("name", ["gallas_2a", "gallas_3c"])
def test_the_profiles_are_those_of_the_dataset_in_the_units_of_the_axes(name, made_dataset):
    half_width = t.ppf(0.975, 2) * SPREAD.std(ddof=1) / 3**0.5
    data = data_of_figure(name, made_dataset)
    slices = profiles(data)
    for row in data.rows.to_dict("records"):
        names = ("frequency", "damping", "shear_damping")
        parameters = BeltParameters(**{name: row[name] for name in names})
        expected = plateau(parameters) if name[-2] == "2" else transport(parameters)
        part = slices[slices["point"] == row["point"]]
        assert part["x"].to_numpy() == pytest.approx(expected, rel=ROUNDING)
        widths = pytest.approx(expected * half_width, abs=5 * expected * ROUNDING)
        assert part["x_half"].to_numpy() == widths
        assert part["height"].to_numpy() == pytest.approx(np.arange(len(part)) + 0.5)
        assert part["height"].iloc[-1] + 1 > 10 / plateau(parameters) > part["height"].iloc[-1]


def test_converged_profiles_are_pale_beside_the_published_ones(made_dataset):
    figure, _ = drawn("gallas_2a", made_dataset)
    lines = [line for line in figure.axes[0].get_lines() if len(line.get_xdata())]
    pale, plain = (
        [x for x in lines if bool(x.get_alpha()) is is_pale] for is_pale in (True, False)
    )
    assert (len(pale), len(plain)) == (2, 4)
    assert {to_rgb(line.get_color()) for line in pale} < {to_rgb(x.get_color()) for x in plain}
    assert entries(figure)[-2:] == ["published protocol", "converged protocol"]


def test_slices_that_are_empty_in_a_replicate_or_too_thin_at_the_top_have_no_value(made_dataset):
    data = data_of_figure("gallas_3a", load_results(made_dataset))
    point, belt = data.rows["point"].iloc[0], data.results.profiles["belt"]
    belt["velocity_profile"].loc[{"run": point, "replicate": 1, "slice": 2}] = np.nan
    for place, factor in ((20, 1.01), (25, 0.99)):
        thin = factor * THIN / data.rows["diameter"][0] ** 2
        belt["number_density"].loc[{"run": point, "slice": place}] = thin
    found = profiles(data)
    found = found[found["point"] == point]
    assert found["height"].max() == pytest.approx(20.5)
    assert np.isnan(found["x"].iloc[2]) and found["x"].iloc[:2].notna().all()


# Regimes.


@pytest.fixture(scope="module")
def regimes(tmp_path_factory) -> Path:
    _, results = make_built_regimes(tmp_path_factory.mktemp("made"))
    return results / "regimes" / "dataset.nc"


def line(axes, label: str):
    return next(one for one in axes.get_lines() if one.get_label().startswith(label))


@pytest.mark.parametrize("name", ["regimes_friction", "regimes_angle", "belt_onset"])
def test_a_map_has_markers_of_regimes_bars_of_boundaries_and_a_line_of_theory(name, regimes):
    figure, data = drawing.drawn(name, regimes)
    axes, rows, found = figure.axes[0], data.rows, data.boundaries
    segments = [one for each in axes.collections for one in each.get_segments()]
    bars = {tuple(np.round(sorted(one[:, axis]), 9)) for one in segments for axis in (0, 1)}
    assert set(zip(found["low"].round(9), found["high"].round(9), strict=True)) <= bars
    if name == "belt_onset":
        amplitude, frequency = line(axes, "$Γ").get_data()
        assert np.interp(1, amplitude, frequency) == pytest.approx(sqrt(1e4) / (2 * pi), rel=1e-3)
        return
    label, level = {
        "regimes_friction": ("μ = tan θ", tan(radians(17))),
        "regimes_angle": ("tan θ = μ", degrees(atan(0.4))),
    }[name]
    assert line(axes, label).get_ydata()[0] == pytest.approx(level)
    for regime in set(rows["regime"]):
        part = rows[rows["regime"] == regime]
        places = set(zip(part["depth"], part[name.partition("_")[2]], strict=True))
        assert set(zip(*line(axes, regime).get_data(), strict=True)) == places
    assert len({(marker, filled) for marker, _, filled in MARKS.values()}) == len(MARKS)


def test_bars_of_one_place_stand_side_by_side_and_kinds_differ_in_colour_and_marker(regimes):
    data = data_of_figure("belt_onset", regimes)
    other = data.boundaries.assign(vibration_angle=60.0)
    axes = picture(replace(data, boundaries=pd.concat([data.boundaries, other]))).axes[0]
    kinds = [line(axes, f"onset of transport, α = {angle}°") for angle in (45, 60)]
    looks = {(one.get_color(), one.get_marker()) for one in kinds}
    assert {len(set(each)) for each in zip(*looks, strict=True)} == {2}
    places = [
        one.get_transform().transform((1, 15))[0] * 72 / axes.figure.dpi
        for one in (container.lines[0] for container in axes.containers)
        if list(one.get_xdata()) == [1]
    ]
    assert np.diff(sorted(places)) == pytest.approx([5])


def test_flows_that_creep_are_told_from_those_that_flow(regimes):
    data = data_of_figure("regimes_friction", regimes)
    unit = sqrt(9.8e-3)
    rows = data.rows.assign(velocity=data.rows["velocity"].where(data.rows.index > 2, 0.09 * unit))
    rows.loc[:2, "regime"] = ["accelerating", "undetermined", "arrested"]
    assert list(np.flatnonzero(creeping(rows))) == [0, 1]
    assert not creeping(rows.assign(velocity=0.11 * unit)).any()
    axes = picture(replace(data, rows=rows)).axes[0]
    shown = line(axes, "creeps: |V| < 0.1 √(gσ)")
    assert list(shown.get_xdata()) == list(rows["depth"][:2])
    assert shown.get_markerfacecolor() == "white"


def test_the_caption_counts_what_was_not_found(regimes):
    found = data_of_figure("regimes_angle", regimes).boundaries
    verdicts = found.assign(verdict=["found", "wide", "none", "none"])
    verdicts.loc[verdicts["verdict"] == "none", ["low", "high"]] = np.nan
    assert boundary_sentences(verdicts, ("depth", "angle")) == [
        "Bars: intervals that hold a boundary, 2 of 4 looked for.",
        "Boundaries: 1 wider than asked for; 2 not within the range searched.",
    ]


def test_markers_at_one_place_stand_side_by_side(regimes):
    data = data_of_figure("regimes_friction", regimes)
    row = data.rows[data.rows["regime"] != "failed"].iloc[[0]]
    both = replace(data, rows=pd.concat([row, row], ignore_index=True))
    lines = picture(both).axes[0].get_lines()
    markers = [one for one in lines if len(one.get_xdata()) and one.get_zorder() == 3]
    places = {one.get_transform().transform(one.get_xydata()[0])[0] for one in markers}
    assert len(places) == len(markers) == 2
