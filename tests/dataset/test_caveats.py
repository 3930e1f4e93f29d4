"""Caveats: those of the run file, energy that does not add up, overlaps and lengths."""

import numpy as np
import pytest
import xarray as xr

from sim.dataset.caveats import UNSOUND_SHARE, caveat, caveat_of_run
from sim.dataset.gather import read_run
from sim.dataset.run_file import summary_of
from sim.parameters import BeltParameters, ChuteParameters, ConveyorParameters, amounts
from tests.made.netcdf import store
from tests.made.runs import write_run

PAPER = ChuteParameters()


def caveat_text(own_caveat, missing_shares, overlaps=(), lengths=()):
    return caveat(own_caveat, missing_shares, PAPER, overlaps, lengths)


def test_one_replicate_that_leaks_is_enough():
    assert caveat_text("", [1e-5, 2 * UNSOUND_SHARE]).startswith("energy does not add up")
    assert caveat_text("", [1e-5, UNSOUND_SHARE, float("nan")]) == ""


def test_both_caveats_are_told():
    assert caveat_text("a long step", [1e-5]) == "a long step"
    assert caveat_text("a long step", [1.0]).startswith("a long step; energy does not add up")


def test_flows_that_overlap_beyond_the_contact_law_say_so_once():
    assert caveat_text("", [], [np.nan, 0.099]) == ""
    text = caveat_text("", [], [0.05, 0.11, 0.2])
    assert text.startswith("spheres overlap by more than 10 % of a diameter")
    assert caveat("", [], BeltParameters(), [0.6], []) == ""


def test_runs_longer_than_is_asked_for_say_so():
    asked = PAPER.steps * PAPER.time_step
    assert caveat_text("", [], lengths=[asked, 0.2 * asked, np.nan]) == ""
    assert caveat_text("", [], lengths=[asked, 1.1 * asked]).startswith(
        "runs longer than is asked for"
    )


def test_a_study_that_asks_for_less_than_was_run_is_told_so(tmp_path):
    """It takes the first of several replicates, but cannot take a part of a longer run."""
    held = ChuteParameters(average=40, replicates=2)
    path = write_run(tmp_path, held, 0.5)
    for asked, is_longer in ((held, False), (ChuteParameters(average=10, replicates=1), True)):
        text = caveat_of_run(summary_of(path, amounts(asked)), asked)
        assert text.startswith("runs longer") == is_longer


def test_a_start_faster_than_the_contact_law_bears_is_known_before_any_run():
    """At 100 N/m an impact at √(gσ) overlaps by 0.85 % of a diameter; half of V counts."""
    assert not ChuteParameters(initial_velocity=23.3).caveat
    assert "beyond the range" in ChuteParameters(initial_velocity=23.5).caveat
    assert not ChuteParameters(initial_velocity=70, stiffness=1000).caveat


def test_a_depth_that_whole_particles_do_not_have_is_known_before_any_run():
    """0.45 · 4² = 7.2 spheres become 7, and 2.9 discs become a row of 3."""
    assert ChuteParameters(depth=0.45, cell=4).caveat.startswith("whole particles in the cell")
    assert not ChuteParameters(depth=0.4375, cell=4).caveat
    assert ConveyorParameters(shape="disc", depth=0.97, cell=3).caveat
    both = ChuteParameters(depth=0.45, cell=4, initial_velocity=50).caveat
    assert both.startswith("impacts") and "; whole particles" in both


@pytest.mark.parametrize("acceleration", [0.0, 5.0])
def test_a_run_file_and_the_dataset_agree(tmp_path, acceleration):
    """The gain of a flow is turned over too: 1.5 % of the dissipation may be a small share."""
    point = ChuteParameters(replicates=2)
    mass = point.particles * point.mass
    arrays = {
        "energy_residual": ("replicate", [0.015, np.nan]),
        "frictional_power": ("replicate", [mass * 0.5, np.nan]),
        "normal_power": ("replicate", [mass * 0.5, np.nan]),
        "acceleration": ("replicate", [acceleration, np.nan]),
    }
    path = write_run(tmp_path, point, 0.5, failed=[1], arrays=arrays)
    text = caveat_of_run(summary_of(path), point)
    assert bool(text) == (acceleration == 0)
    assert text == caveat_text("", read_run(path).values["missing_energy"][0])


def test_a_file_without_a_ledger_says_what_it_has(tmp_path):
    store(xr.Dataset(attrs={"caveat": "a long step"}), tmp_path / "run.nc")
    assert caveat_of_run(summary_of(tmp_path / "run.nc"), ChuteParameters()) == "a long step"
