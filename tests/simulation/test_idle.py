import numpy as np

from geotlm_lm.simulation.idle import MEASURED_IDLE, idle_frame


def test_idle_frames_stay_near_the_measured_light():
    means = np.mean([idle_frame(seed).mean(axis=(1, 2)) for seed in range(40)], axis=0)
    assert np.all(np.abs(means - MEASURED_IDLE.mean(axis=(1, 2))) < 22)


def test_the_sides_of_the_lights_are_never_swapped():
    # Measured: the top of a whole view is bluer than the bottom.
    frames = [idle_frame(seed) for seed in range(40)]
    top = np.mean([frame[2, :40].mean() for frame in frames])
    bottom = np.mean([frame[2, -40:].mean() for frame in frames])
    assert top > bottom + 10


def test_two_seeds_give_two_gels_and_one_seed_one():
    assert np.array_equal(idle_frame(3), idle_frame(3))
    assert np.abs(idle_frame(3) - idle_frame(4)).mean() > 3
