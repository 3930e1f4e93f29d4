"""Warming up: one small point per set of compiled kernels."""

import subprocess
import sys

import pytest

from sim.engine.command import variants, warm
from sim.parameters import parse_point
from tests.made.processes import ROOT


def point(**values):
    return parse_point(values, "test")


def test_points_that_differ_in_numbers_alone_share_one_variant():
    points = [
        point(system="chute", depth=depth, stiffness=k, threads=threads)
        for depth, k, threads in ((1, 100, 1), (5, 100, 2), (1, 1000, 4), (5, 1000, 1))
    ]
    assert len(variants(points)) == 1


def test_every_reading_that_selects_code_is_a_variant_of_its_own():
    points = [
        point(system="chute"),
        point(system="chute", tangential_exponent=0),
        point(system="chute", overlap_memory="shrink"),
        point(system="belt"),
        point(system="belt", integrator="verlet"),
    ]
    small = variants(points)
    assert [p.system for p in small] == ["chute", "chute", "chute", "belt", "belt"]
    assert [p.tangential_exponent for p in small[:2]] == [points[0].tangential_exponent, 0]
    assert small[2].overlap_memory == "shrink"
    assert small[4].integrator == "verlet"


def test_warming_runs_every_kernel_of_a_run():
    warm([point(system="belt", beads=5, width=6)])


def test_the_command_says_what_it_compiles():
    lines = (
        "import logging, sys, sim.engine.command\n"
        "def log_compiling(*_):\n"
        "    logging.getLogger('talus').info('compiling')\n"
        "sim.engine.command.warm = log_compiling\n"
        "from sim.__main__ import main\n"
        "sys.exit(main(['warm']))\n"
    )
    command = [sys.executable, "-c", lines]
    process = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    assert (process.returncode, process.stderr) == (0, "compiling\n")


def test_systems_may_be_warmed_side_by_side(monkeypatch):
    """And what goes wrong with one of them is not lost."""
    points = [point(system="belt", beads=5, width=6), point(system="chute", depth=1, cell=3)]
    warm(points, processes=2)

    def broken(*_):
        raise RuntimeError("broken")

    monkeypatch.setattr("sim.engine.systems.build", broken)
    with pytest.raises(RuntimeError, match="broken"):
        warm(points, processes=2)
