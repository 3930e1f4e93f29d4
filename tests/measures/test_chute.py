"""Measures of a chute's replicate from the arrays of its run file."""

import numpy as np
import pytest
import xarray as xr

from sim.measures.chute import quantile
from tests.measures.measuring import measured

SIZE = 1e-3
HEIGHT = (np.arange(40) + 0.5) * 0.25 * SIZE


def make_run(**arrays) -> xr.Dataset:
    """A replicate that shears up to two diameters under a plug of eight diameters in all."""
    data = {
        "height": ("height", HEIGHT),
        "packing_profile": ("height", 0.6 * (HEIGHT < 8 * SIZE)),
        "velocity_profile": ("height", np.minimum(HEIGHT / (2 * SIZE), 1.0)),
    }
    return xr.Dataset(data | {"diameter": SIZE, "cell": 5.0} | arrays)


def test_plug_alone_is_asked_for_its_order():
    grid = np.stack(np.meshgrid(np.arange(5), np.arange(5), np.arange(8)), -1).reshape(-1, 3)
    place = (grid + 0.5) * SIZE
    below = place[:, 2] < 1.8 * SIZE
    place[below] += np.random.default_rng(1).uniform(-0.5, 0.5, (below.sum(), 3)) * SIZE
    frames = np.stack([np.zeros_like(place), place])
    values = measured(make_run(position=(("frame", "particle", "axis"), frames)), "chute")
    assert values["shear_depth"] == pytest.approx(1.8 * SIZE, rel=1e-6)
    # All but those of the simple cubic plug's two faces have six coherent neighbors: none has 8.
    assert values["crystalline_share"] == 0.0
    assert values["layer_order"] > 0.9


def test_run_without_particles_or_overlaps_has_its_shear_depth_alone():
    assert set(measured(make_run(), "chute")) == {"shear_depth"}


def test_run_without_profiles_has_no_measures():
    assert measured(make_run().drop_vars("packing_profile"), "chute") == {}


def test_quantiles_of_overlaps():
    edges = np.geomspace(1e-4, 1e-1, 31)
    counts = np.zeros(30)
    counts[10] = 900
    counts[25] = 100
    median = quantile(counts, edges, 0.5)
    assert edges[10] < median < edges[11]
    assert edges[25] < quantile(counts, edges, 0.999) < edges[26]
    assert np.isnan(quantile(0 * counts, edges, 0.5))
    run = make_run(overlap_histogram=("overlap_bin", counts), overlap_edges=("overlap_edge", edges))
    assert measured(run, "chute")["median_overlap"] == median


def test_rolling_of_the_lowest_spheres_is_told_where_spins_were_kept():
    """Only slices below their centres count, so spheres above do not."""
    below = HEIGHT < 0.5 * SIZE
    spin = np.where(below, 0.5 * HEIGHT / (2 * SIZE) / (0.5 * SIZE), 99.0)
    profiles = {
        "spin_profile": ("height", spin),
        "vertical_temperature_profile": ("height", np.where(below, 0.01, 7.0)),
    }
    values = measured(make_run(**profiles), "chute")
    assert values["base_rolling"] == pytest.approx(0.5)
    assert values["base_slip_ratio"] == pytest.approx(0.5 * 0.125 / 0.1)
    assert not {"base_rolling", "base_slip_ratio"} & measured(make_run(), "chute").keys()


def test_forces_on_the_plane_have_a_ratio():
    assert measured(make_run(base_normal=2.0, base_shear=0.5), "chute")["base_stress_ratio"] == 0.25
    assert "base_stress_ratio" not in measured(make_run(base_normal=0.0, base_shear=0.0), "chute")
