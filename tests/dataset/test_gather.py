"""Profiles of runs of different sizes in one group of the dataset."""

import numpy as np
import pytest
import xarray as xr

from sim.dataset.combine import profiles
from sim.dataset.gather import column_means
from sim.dataset.rows import OF_PROFILES, STATE_VARIABLES, Rows, align_rows
from sim.parameters.variables import variables_of


def run_row(name, width, slices, replicates):
    """Return the row of a run on a belt ``width`` (mm) long."""
    squares = np.arange(width) + 0.5
    field = xr.Dataset(
        {
            "field_velocity": (
                ("replicate", "column", "level"),
                np.broadcast_to(squares[:, None], (replicates, width, 2)),
            ),
            "field_density": (("replicate", "column", "level"), np.ones((replicates, width, 2))),
        },
        coords={"column": 1e-3 * squares, "level": [0.0, 1e-3]},
    )
    arrays = {
        "height": 1e-3 * np.arange(slices),
        "number_density": np.ones((replicates, slices)),
    }
    values = {key: one[np.newaxis] for key, one in (arrays | column_means(field)).items()}
    return Rows([name], {}, values, {})


def test_belts_of_different_lengths_are_filled_up():
    blocks = [run_row("short", 3, 5, 2), run_row("long", 6, 4, 3)]
    dataset = profiles(align_rows(blocks, ["long", "short"], OF_PROFILES, 3))
    assert dataset.sizes == {"run": 2, "replicate": 3, "slice": 5, "square": 6}
    short = dataset.sel(run="short")
    assert short["column"].values[:3] == pytest.approx([0.5e-3, 1.5e-3, 2.5e-3])
    assert np.isnan(short["column"].values[3:]).all()
    assert short["column_velocity"].values[1, :3] == pytest.approx([0.5, 1.5, 2.5])
    assert np.isnan(short["column_velocity"].values[2]).all()
    assert np.isnan(dataset.sel(run="long")["height"].values[4:]).all()


def test_every_profile_and_what_pictures_show_of_particles_is_kept():
    rows = variables_of("profile").values()
    unread = {row.name for row in rows if not row.in_datasets}
    parts = ("number_density", "granular_temperature_profile", "vertical_temperature_profile")
    assert {name for name in unread if not name.endswith("_history")} == {
        f"{name}_instantaneous" for name in parts
    }
    assert variables_of("particle").keys() - set(STATE_VARIABLES) == {
        "particle_spin",
        "orientation",
    }
