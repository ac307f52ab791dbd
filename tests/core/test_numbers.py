"""Named generators repeat, and differ from each other."""

import itertools

from geotlm_lm.core.numbers import generator_for, seed_for


def test_the_same_names_give_the_same_numbers():
    assert generator_for(7, "weights").random() == generator_for(7, "weights").random()


def test_root_names_and_order_all_matter():
    seeds = [
        seed_for(7, "a", "b"),
        seed_for(7, "b", "a"),
        seed_for(7, "a"),
        seed_for(8, "a", "b"),
        seed_for(7, "a", 1),
        seed_for(7, "a", 2),
    ]
    assert all(one != other for one, other in itertools.combinations(seeds, 2))


def test_a_seed_fits_a_signed_64_bit_integer():
    assert all(0 <= seed_for(0, "clip", index) < 2**63 for index in range(100))


def test_neighbouring_clips_are_uncorrelated():
    first, second = (generator_for(0, "clip", index).random(4000) for index in (0, 1))
    # The correlation of 4000 independent pairs has a standard deviation of 0.016.
    assert abs(((first - 0.5) * (second - 0.5)).mean() * 12) < 0.08
