"""A recording that is drawn: a rough disc, pressed on a plain gel, turned and slid."""

import cv2
import numpy as np

from geotlm_lm.core.clip import Clip

ROWS, COLUMNS = 120, 160
PATTERN = cv2.GaussianBlur(np.random.default_rng(1).normal(0, 1, (240, 240)), (0, 0), 5)
PATTERN *= 30 / PATTERN.std()


def frame(angle_deg=0.0, depth=1.0, right_px=0.0, seed=0):
    """Return the disc, turned by `angle_deg`, pressed to `depth`, `right_px` off the middle."""
    turn = cv2.getRotationMatrix2D((120, 120), -angle_deg, 1)
    turn[0, 2] += right_px
    rough = cv2.warpAffine(PATTERN, turn, (240, 240))[60:180, 40:200]
    y, x = np.mgrid[:ROWS, :COLUMNS]
    disc = np.hypot(x - 80 - right_px, y - 60) < 45
    grey = 120 + depth * disc * rough + np.random.default_rng(seed).normal(0, 1, (ROWS, COLUMNS))
    return np.repeat(np.clip(np.rint(grey), 0, 255).astype(np.uint8)[..., None], 3, axis=-1)


def recording(angles, depths, rights=None, fps=25.0):
    """Return a clip of these poses, one a frame."""
    poses = zip(angles, depths, rights or [0] * len(angles), strict=True)
    return Clip(np.stack([frame(*pose, seed) for seed, pose in enumerate(poses)]), fps=fps)


def there_and_back(fps=25.0):
    """Idle 0-9, pressed by 14, clockwise by 30 degrees from 25 to 45, back by 20 from 60 to 75."""
    depths = [0] * 10 + list(np.linspace(0.2, 1, 5)) + [1] * 75 + list(np.linspace(0.8, 0, 5))
    angles = np.interp(np.arange(95), [0, 25, 45, 60, 75, 94], [0, 0, 30, 30, 10, 10])
    return recording([*angles, *[10] * 10], [*depths, *[0] * 10], fps=fps)
