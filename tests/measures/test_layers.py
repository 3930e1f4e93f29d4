"""Surface, shear layer and plug of profiles of known shape."""

import numpy as np
import pytest

from sim.measures import layers

SIZE = 1e-3
HEIGHT = (np.arange(80) + 0.5) * 0.25 * SIZE


def filled_profile(depth: float, packing: float = 0.6) -> np.ndarray:
    """Packing (H,) of a flow filled evenly up to a depth in diameters."""
    return packing * (depth * SIZE > HEIGHT)


def bent_profile(knee: float, top: float, rest: float = 0.0) -> np.ndarray:
    """Velocity (H,) that rises to ``top`` at ``knee`` diameters, then by ``rest`` per m."""
    z = HEIGHT / (knee * SIZE)
    return top * np.minimum(z, 1) + rest * np.maximum(HEIGHT - knee * SIZE, 0)


def test_surface_is_where_99_percent_of_the_mass_lies_below():
    assert layers.surface(HEIGHT, filled_profile(10)) == pytest.approx(9.9 * SIZE, rel=1e-9)
    flying = filled_profile(10) + 1e-4 * (HEIGHT > 15 * SIZE)
    assert layers.surface(HEIGHT, flying) == pytest.approx(9.9 * SIZE, rel=0.01)


def test_shear_depth_does_not_depend_on_spheres_that_fly_or_on_empty_slices():
    plain = layers.shear_depth(HEIGHT, bent_profile(4, 2.0), filled_profile(10), SIZE)
    assert plain == pytest.approx(3.6 * SIZE, rel=0.01)
    assert np.isnan(layers.shear_depth(HEIGHT, 0 * HEIGHT, filled_profile(10), SIZE))
    velocity = np.where(HEIGHT < 10 * SIZE, bent_profile(4, 2.0), 7.0)
    velocity[60:] = np.nan
    packing = filled_profile(10) + 1e-5 * ((HEIGHT > 12 * SIZE) & (HEIGHT < 15 * SIZE))
    depth = layers.shear_depth(HEIGHT, velocity, packing, SIZE)
    assert depth == pytest.approx(3.6 * SIZE, rel=0.01)


@pytest.mark.parametrize("knee", [2.0, 5.0])
def test_plug_begins_where_the_mean_shear_above_falls_below_a_twentieth(knee):
    base = layers.plug_base(HEIGHT, bent_profile(knee, 1.0), filled_profile(12), SIZE)
    assert (knee - 0.5) * SIZE < base <= (knee + 0.25) * SIZE


def test_flow_that_shears_throughout_has_no_plug():
    packing = filled_profile(12)
    base = layers.plug_base(HEIGHT, 100 * HEIGHT, packing, SIZE)
    assert base == layers.surface(HEIGHT, packing)
    shearing = bent_profile(2, 1.0, rest=0.1 * 1.0 / (2 * SIZE))
    assert layers.plug_base(HEIGHT, shearing, packing, SIZE) == base


def test_a_bulge_of_the_velocity_is_no_plug_though_its_sides_cancel():
    bulge = 0.3 * np.clip(1 - np.abs(HEIGHT / SIZE - 7) / 3, 0, None)
    base = layers.plug_base(HEIGHT, bent_profile(2, 1.0) + bulge, filled_profile(12), SIZE)
    assert base > 9 * SIZE


def test_layers_of_diameters_average_what_is_within():
    packing = filled_profile(8) * (1 + 0.3 * np.cos(2 * np.pi * HEIGHT / SIZE))
    assert layers.packing_by_diameters(HEIGHT, packing, SIZE) == pytest.approx([0.6] * 7)
    assert layers.packing_by_diameters(HEIGHT, packing, SIZE, layers=2) == pytest.approx([0.6] * 3)
