"""Measures of chute and conveyor from the arrays of a replicate, and the order of spheres."""

import numpy as np
import pytest
import xarray as xr

from sim.engine.boundary.drive import plane_position, plane_velocity, vibration
from sim.measures.chute import (
    MIN_BONDS,
    coherent_bonds,
    crystalline_share,
    layer_order,
    quantile,
)
from sim.parameters import ConveyorParameters
from tests.made.results import measured

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
    others = {"flow_height", "bulk_packing", "packing_change"}
    assert set(measured(make_run(), "chute")) == {"shear_depth"} | others
    assert measured(make_run().drop_vars("packing_profile"), "chute") == {}
    forces = measured(make_run(base_normal=2.0, base_shear=0.5), "chute")
    assert forces["base_stress_ratio"] == 0.25
    assert "base_stress_ratio" not in measured(make_run(base_normal=0.0, base_shear=0.0), "chute")


def test_quantiles_of_overlaps():
    edges = np.geomspace(1e-4, 1e-1, 31)
    counts = np.zeros(30)
    counts[10] = 900
    counts[25] = 100
    median = quantile(counts, edges, 0.5)
    assert edges[10] < median < edges[11]
    assert edges[25] < quantile(counts, edges, 0.999) < edges[26]
    assert np.isnan(quantile(0 * counts, edges, 0.5))
    # Within a bin the logarithm grows evenly: a third of the way from 10 to 1000.
    assert quantile(np.array([1, 3]), np.array([1, 10, 1000]), 0.5) == pytest.approx(10 ** (5 / 3))
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


def crystal(cells: int, high: int) -> tuple[np.ndarray, float]:
    """Face-centred cubic positions (N, 3) at contact, and the side of the cell they fill."""
    edge = np.sqrt(2) * SIZE
    basis = np.array([[0, 0, 0], [0.5, 0.5, 0], [0.5, 0, 0.5], [0, 0.5, 0.5]])
    corner = np.stack(np.meshgrid(*map(np.arange, (cells, cells, high)), indexing="ij"), -1)
    return edge * (corner.reshape(-1, 1, 3) + basis).reshape(-1, 3), cells * edge


def scattered_positions(number: int, side: float, height: float) -> np.ndarray:
    return np.random.default_rng(1).uniform(0, 1, (number, 3)) * [side, side, height]


def test_spheres_of_a_crystal_are_crystalline_across_the_edges_of_the_cell_but_not_of_its_top():
    position, side = crystal(4, 4)
    position, sides = np.vstack([position, position + np.array([side, 0, 0])]), (2 * side, side)
    bonds = coherent_bonds(position, sides, SIZE)
    inside = (position[:, 2] > 0.1 * SIZE) & (position[:, 2] < position[:, 2].max() - 0.1 * SIZE)
    assert (bonds[inside] == 12).all()
    assert (bonds[~inside] == MIN_BONDS).all()
    shifted = position + np.array([3.7 * side, -0.4 * side, 0.02])
    assert (coherent_bonds(shifted, sides, SIZE) == bonds).all()


def test_share_is_of_the_chosen_spheres():
    position, side = crystal(4, 4)
    above = scattered_positions(256, side, 6 * SIZE) + np.array([0, 0, 8 * SIZE])
    mixed = np.vstack([position, above])
    lower = np.arange(len(mixed)) < len(position)
    assert crystalline_share(mixed, lower, (side, side), SIZE) == 1.0
    assert crystalline_share(mixed, ~lower, (side, side), SIZE) < 0.1
    assert np.isnan(crystalline_share(mixed, lower & ~lower, (side, side), SIZE))


@pytest.mark.parametrize("spacing", [0.72, 0.82, 1.0])
def test_layers_of_any_spacing_are_found(spacing):
    heights = SIZE * spacing * np.repeat(np.arange(10), 30)
    assert layer_order(heights, SIZE) == pytest.approx(1.0, abs=1e-6)
    rng = np.random.default_rng(2)
    blurred = layer_order(heights + 0.1 * SIZE * rng.normal(size=300), SIZE)
    assert 0.6 < blurred < 1.0
    assert layer_order(rng.uniform(0, 10 * SIZE, 300), SIZE) < 0.2


def shaken_run(point: ConveyorParameters, velocity: float) -> dict:
    """Return the arrays of a replicate with a velocity (m/s) that the measures need."""
    limits = {name: value for name, (value, _) in point.limits.items()}
    return point.model_dump() | limits | {"velocity": velocity}


def cycle_and_drive(point: ConveyorParameters):
    """Return the times (s) of a cycle and the drive of the plane."""
    return np.linspace(0, 1 / point.frequency, 20_001), vibration(point, (0, 0, -point.gravity))


def test_the_shaking_strength_is_the_largest_acceleration_along_z_over_gravity():
    point = ConveyorParameters(
        frequency=23, amplitude=0.7, amplitude_along=0.2, phase_along=50, angle=25
    )
    time, drive = cycle_and_drive(point)
    velocity = np.gradient(plane_position(drive, 1, time), time)
    largest = np.abs(np.gradient(velocity, time)[5:-5]).max()
    found = measured(shaken_run(point, 0.1), "conveyor")
    assert found["shaking_strength"] == pytest.approx(largest / point.gravity, rel=1e-3)
    assert found["throw_number"] == pytest.approx(point.throw_number)
    # On a slope gravity presses with its cosine alone.
    pressing = point.gravity * np.cos(np.radians(point.angle))
    assert point.throw_number == pytest.approx(largest / pressing, rel=1e-3)


def test_what_goes_as_fast_as_the_plane_at_its_fastest_is_transported_wholly():
    point = ConveyorParameters(frequency=23, amplitude=0.7, amplitude_along=0.2, phase_along=50)
    time, drive = cycle_and_drive(point)
    fastest = plane_velocity(drive, 0, time).max()
    for sign in (1, -1):
        found = measured(shaken_run(point, sign * fastest), "conveyor")["transport_efficiency"]
        assert found == pytest.approx(sign, rel=1e-6)
    upward = ConveyorParameters(amplitude_along=0)
    assert set(measured(shaken_run(upward, 0.0), "conveyor")) == {
        "shaking_strength",
        "throw_number",
    }
