"""Blocks of profiles: the sum from a late start, in bounded memory."""

import pytest

from sim.engine.observe.blocks import MOST, ProfileBlocks
from sim.engine.observe.profiles import empty_profile


def filled(samples: int) -> ProfileBlocks:
    """Blocks of a profile whose sample k has the weight k."""
    blocks = ProfileBlocks()
    for number in range(samples):
        profile = empty_profile(1, 2)
        profile.samples[0], profile.weight[0] = 1.0, float(number)
        blocks.add((profile,))
    return blocks


@pytest.mark.parametrize("samples", [1, 5, MOST, MOST + 1, 10 * MOST + 3])
def test_all_blocks_together_hold_all_samples(samples):
    (total,) = filled(samples).since(0)
    assert total.samples[0] == samples
    assert total.weight[0] == sum(range(samples))


@pytest.mark.parametrize("start", [1, 7, 100, 333])
def test_a_late_start_leaves_out_what_comes_before_it(start):
    samples = 400
    (total,) = filled(samples).since(start)
    counted = int(total.samples[0])
    assert samples - start - samples // (MOST // 2) <= counted <= samples - start
    assert total.weight[0] == sum(range(samples - counted, samples))


def test_memory_is_bounded_and_the_last_sample_is_kept():
    blocks = filled(100 * MOST)
    assert len(blocks._blocks) <= MOST
    assert blocks.latest[0].weight[0] == 100 * MOST - 1
    assert blocks.since(10**9)[0].samples[0] > 0


def test_nothing_before_the_first_sample():
    assert ProfileBlocks().since(0) is None and ProfileBlocks().latest is None
