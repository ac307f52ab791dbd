import numpy as np
import pytest

from geotlm_lm.recordings.pixels import drifted, faded, gained, jpeg

GRADIENT = np.broadcast_to(np.arange(64, 192, 2, dtype=np.uint8)[:, None], (64, 64, 3)).copy()
NOISE = np.random.default_rng(0).integers(0, 256, (64, 64, 3)).astype(np.uint8)


def test_jpeg_loses_more_at_a_lower_quality():
    losses = [np.abs(jpeg(q, NOISE).astype(int) - NOISE).mean() for q in (95, 50, 10)]
    assert losses[0] < losses[1] < losses[2]


def test_jpeg_keeps_the_order_of_colours():
    image = np.zeros((16, 16, 3), np.uint8)
    image[..., 0] = 200
    assert jpeg(90, image)[..., 0].mean() > 150 > jpeg(90, image)[..., 2].mean()


def test_a_longer_exposure_brightens_up_to_white():
    assert gained(2.0, GRADIENT)[10, 0, 0] == 2 * GRADIENT[10, 0, 0]
    assert gained(10.0, GRADIENT).min() == 255


@pytest.mark.parametrize(("grey", "gain", "last"), [(10.0, 0.0, 110), (0.0, 0.2, 120)])
def test_a_drift_grows_from_the_first_frame_to_the_last(grey, gain, last):
    frames = np.full((3, 4, 4, 3), 100, np.uint8)
    levels = drifted(grey, gain, frames)[:, 0, 0, 0].tolist()
    assert levels == [100, (100 + last) // 2, last]


def test_a_faded_touch_differs_by_its_share_from_the_idle_gel():
    idle = np.full((4, 4, 3), 100, np.uint8)
    frames = np.stack([idle, idle + 40])
    assert faded(0.25, frames, idle)[:, 0, 0, 0].tolist() == [100, 110]
