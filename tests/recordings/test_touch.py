"""An idle gel is told from a faint touch by its change alone."""

import cv2
import numpy as np
import pytest

from geotlm_lm.core.clip import Clip
from geotlm_lm.recordings.touch import FAINT_GREY, UNTOUCHED_GREY, change_from_idle, change_map
from geotlm_lm.simulation.indenters import TRAINING_OBJECTS
from geotlm_lm.simulation.simulate import simulate_series

IDLE = np.full((240, 320, 3), 110, np.uint8)


def recorded(change, noise_grey=1.5, seed=0):
    noise = np.random.default_rng(seed).normal(0, noise_grey, (4, 240, 320, 3))
    frames = np.clip(np.rint(110.0 + change[..., None] + noise), 0, 255)
    return Clip(frames.astype(np.uint8), background=IDLE)


def imprint(grey, radius_px=14):
    rows, columns = np.mgrid[:240, :320]
    return grey * np.exp(-((rows - 60) ** 2 + (columns - 250) ** 2) / (2 * radius_px**2))


def grey_of(clip):
    return change_from_idle(clip).grey


def test_camera_noise_and_a_change_of_exposure_are_no_touch():
    assert grey_of(recorded(np.zeros((240, 320)))) < UNTOUCHED_GREY
    assert grey_of(recorded(np.full((240, 320), 6.0))) < UNTOUCHED_GREY


@pytest.mark.parametrize("grey", [4.0, -4.0])
def test_a_small_faint_imprint_is_a_touch_wherever_it_lies(grey):
    assert grey_of(recorded(imprint(grey))) >= UNTOUCHED_GREY


def test_the_map_of_the_change_shows_where_it_is_and_nothing_of_the_light():
    idle = np.full((96, 128, 3), 100, np.uint8)
    frame = idle + np.uint8(20)  # another exposure
    frame[24:48, 64:96] += 60
    seen = change_map(frame, idle)
    assert seen.shape == (24, 32)
    assert seen[7:11, 17:23].min() == 1
    assert seen[:, :14].max() == seen[14:].max() == 0


def test_the_change_does_not_depend_on_the_recorded_size():
    clip = recorded(imprint(8.0), noise_grey=0)
    small = [cv2.resize(one, (160, 120), interpolation=cv2.INTER_AREA) for one in clip.frames]
    half = Clip(np.stack(small), background=IDLE[::2, ::2])
    assert grey_of(half) == pytest.approx(grey_of(clip), rel=0.1)


def test_the_smallest_and_the_narrowest_frames_are_judged():
    for shape in ((8, 8, 3), (8, 400, 3), (400, 8, 3)):
        clip = Clip(np.full((4, *shape), 110, np.uint8), background=np.full(shape, 110, np.uint8))
        assert grey_of(clip) < UNTOUCHED_GREY


def test_no_readable_simulated_touch_counts_as_untouched():
    clips = [
        one
        for one in simulate_series(515, 40, objects=TRAINING_OBJECTS)
        if one.label.is_readable and max(one.label.contact_fraction) > 0
    ]
    assert len(clips) > 20
    assert min(grey_of(one.clip) for one in clips) > UNTOUCHED_GREY


def test_faint_is_beyond_noise_and_no_more_than_an_idle_gel_may_change():
    faint = [
        change_from_idle(recorded(imprint(depth), noise_grey=noise)).is_faint
        for depth, noise in ((0.6, 0.3), (1.3, 0.3), (2.5, 0.3), (1.3, 3.0))
    ]
    assert faint == [False, True, False, False]


def test_motion_between_the_frames_is_not_taken_for_noise():
    clip = recorded(imprint(0), noise_grey=0)
    frames = clip.frames.copy()
    frames[1:] = recorded(imprint(12.0), noise_grey=0).frames[0]
    assert change_from_idle(Clip(frames, background=IDLE)).is_beyond_noise


def test_frames_that_are_fed_twice_do_not_make_noise_vanish():
    noisy = recorded(np.zeros((240, 320)), noise_grey=9.0)
    for order in ([0, 0, 1, 1], [0, 0, 0, 0]):
        pair = change_from_idle(Clip(noisy.frames[order], background=IDLE))
        assert pair.grey > FAINT_GREY
        assert not pair.is_beyond_noise


@pytest.mark.parametrize("shift", [(0, 0), (60, 0), (-250, 0), (260, 0), (0, 180), (0, -62)])
def test_an_imprint_is_cut_off_where_its_middle_is_at_the_border(shift):
    matrix = np.float32([[1, 0, shift[0]], [0, 1, shift[1]]])
    clip = recorded(cv2.warpAffine(imprint(40.0), matrix, (320, 240)))
    # It lies at (250, 60): whole as it is, and beside the middle; gone or cut elsewhere.
    x, y = 250 + shift[0], 60 + shift[1]
    is_cut = min(abs(x), abs(320 - x), abs(y), abs(240 - y)) < 14
    assert change_from_idle(clip).is_cut_off == is_cut
