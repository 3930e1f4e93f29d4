"""Figures of regimes: a marker per point and regime, boundaries as bars, lines of theory."""

from dataclasses import replace
from math import atan, degrees, pi, radians, sqrt, tan
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from sim.figures.regimes import MARKS, boundary_sentences, creeping
from tests.figures import drawing
from tests.figures.drawing import data_of_figure, picture
from tests.made.figures import make_built_regimes

NAMES = ("regimes_friction", "regimes_angle", "belt_onset")


@pytest.fixture(scope="module")
def dataset_path(tmp_path_factory) -> Path:
    _, results = make_built_regimes(tmp_path_factory.mktemp("made"))
    return results / "regimes" / "dataset.nc"


def drawn(name: str, dataset_path: Path):
    """Return the axes of a figure, its rows and its boundaries."""
    figure, data = drawing.drawn(name, dataset_path)
    return figure.axes[0], data.rows, data.boundaries


def line(axes, label: str):
    return next(one for one in axes.get_lines() if one.get_label().startswith(label))


@pytest.mark.parametrize(
    ("name", "y"), [("regimes_friction", "friction"), ("regimes_angle", "angle")]
)
def test_every_point_has_the_marker_of_its_regime(name, y, dataset_path):
    axes, rows, _ = drawn(name, dataset_path)
    for regime in set(rows["regime"]):
        part = rows[rows["regime"] == regime]
        assert set(zip(*line(axes, regime).get_data(), strict=True)) == set(
            zip(part["depth"], part[y], strict=True)
        )
    assert len({(marker, filled) for marker, _, filled in MARKS.values()}) == len(MARKS)


@pytest.mark.parametrize("name", NAMES)
def test_bars_span_the_intervals(name, dataset_path):
    axes, _, found = drawn(name, dataset_path)
    bars = {
        tuple(np.round(sorted(segment[:, axis]), 9))
        for collection in axes.collections
        for segment in collection.get_segments()
        for axis in (0, 1)
    }
    assert {
        (low, high) for low, high in zip(found["low"].round(9), found["high"].round(9), strict=True)
    } <= bars


def test_bars_of_one_place_stand_side_by_side_and_kinds_differ_in_colour_and_marker(dataset_path):
    data = data_of_figure("belt_onset", dataset_path)
    other = data.boundaries.assign(vibration_angle=60.0)
    both = replace(data, boundaries=pd.concat([data.boundaries, other]))
    axes = picture(both).axes[0]
    looks = {
        (one.get_color(), one.get_marker())
        for one in (
            line(axes, "onset of transport, α = 45°"),
            line(axes, "onset of transport, α = 60°"),
        )
    }
    assert {len(set(each)) for each in zip(*looks, strict=True)} == {2}
    places = [
        one.get_transform().transform((1, 15))[0] * 72 / axes.figure.dpi
        for one in (container.lines[0] for container in axes.containers)
        if list(one.get_xdata()) == [1]
    ]
    assert np.diff(sorted(places)) == pytest.approx([5])


def test_flows_that_creep_are_told_from_those_that_flow(dataset_path):
    data = data_of_figure("regimes_friction", dataset_path)
    unit = sqrt(9.8e-3)
    rows = data.rows.assign(velocity=data.rows["velocity"].where(data.rows.index > 2, 0.09 * unit))
    rows.loc[:2, "regime"] = ["accelerating", "undetermined", "arrested"]
    assert list(np.flatnonzero(creeping(rows))) == [0, 1]
    assert not creeping(rows.assign(velocity=0.11 * unit)).any()
    axes = picture(replace(data, rows=rows)).axes[0]
    shown = line(axes, "creeps: |V| < 0.1 √(gσ)")
    assert list(shown.get_xdata()) == list(rows["depth"][:2])
    assert shown.get_markerfacecolor() == "white"
    together = sum(len(line(axes, regime).get_xdata()) for regime in ("accelerating", "arrested"))
    assert together == rows["regime"][2:].isin(("accelerating", "arrested")).sum()


def test_lines_of_theory(dataset_path):
    axes, _, _ = drawn("regimes_friction", dataset_path)
    assert line(axes, "μ = tan θ").get_ydata()[0] == pytest.approx(tan(radians(17)))
    axes, _, _ = drawn("regimes_angle", dataset_path)
    assert line(axes, "tan θ = μ").get_ydata()[0] == pytest.approx(degrees(atan(0.4)))
    axes, _, _ = drawn("belt_onset", dataset_path)
    amplitude, frequency = line(axes, "$Γ").get_data()
    assert np.interp(1, amplitude, frequency) == pytest.approx(sqrt(1e4) / (2 * pi), rel=1e-3)


def test_the_caption_says_what_was_not_found(dataset_path):
    _, _, found = drawn("regimes_angle", dataset_path)
    verdicts = found.assign(verdict=["found", "wide", "none", "none"])
    assert boundary_sentences(verdicts, ("depth", "angle")) == [
        "Bars: intervals that hold a boundary, 4 of 4 looked for.",
        "Boundaries: 1 wider than asked for; 2 not within the range searched.",
    ]
    verdicts.loc[verdicts["verdict"] == "none", ["low", "high"]] = np.nan
    assert "2 of 4 looked for" in boundary_sentences(verdicts, ("depth", "angle"))[0]


def test_markers_at_one_place_stand_side_by_side(dataset_path):
    data = data_of_figure("regimes_friction", dataset_path)
    row = data.rows[data.rows["regime"] != "failed"].iloc[[0]]
    both = replace(data, rows=pd.concat([row, row], ignore_index=True))
    axes = picture(both).axes[0]
    drawn = [one for one in axes.get_lines() if len(one.get_xdata()) and one.get_zorder() == 3]
    places = {one.get_transform().transform(one.get_xydata()[0])[0] for one in drawn}
    assert len(places) == len(drawn) == 2
